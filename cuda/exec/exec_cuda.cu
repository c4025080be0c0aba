// SPDX-License-Identifier: Apache-2.0
// Parts of the CUDA executor that depend on no body: memory, stream, sort, timings, errors.
#include "exec/exec_cuda.cuh"

#include <algorithm>
#include <chrono>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <limits>
#include <utility>
#include <vector>

#include "exec/profiler_range.cuh"
#include "pipeline/schedule.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

namespace {

/// Start and stop events of the last few runs of one stage.
struct StageEvents {
  static constexpr int ring = 32;
  cudaEvent_t start[ring] = {}, stop[ring] = {};
  bool pending[ring] = {};
  int next = 0;
};

/// A captured sub-step.
struct Repeat {
  RepeatKey key;
  cudaGraphExec_t graph = nullptr;
  cudaGraph_t recorded = nullptr;  // kept, as its nodes name those of the other
  cudaGraphNode_t first = nullptr;
  std::uint64_t used = 0;  // launch that used it last
  /// One that still runs is freed when it has ended.
  void destroy() const {
    (void)cudaGraphExecDestroy(graph);
    (void)cudaGraphDestroy(recorded);
  }
};

/// Both halves of the double buffer, with and without the stages that run every few sub-steps, and some more
/// for step lengths that alternate.
constexpr std::size_t most_repeats = 16;

/// Work that may be enqueued [s]; as many sub-steps at most; marks (events) among them.
constexpr double queue_seconds = 0.5;
constexpr std::uint64_t most_queued = 256;
constexpr std::uint64_t queue_marks = 8;

/// Work that the device has not finished: a mark every few sub-steps, oldest first.
struct Queue {
  static constexpr std::size_t ring = 2 * queue_marks;
  cudaEvent_t event[ring] = {};
  std::uint64_t steps[ring] = {};  // since the mark before
  std::size_t first = 0, marks = 0;
  std::uint64_t queued = 0, unmarked = 0;       // sub-steps up to the last mark, and since
  std::uint64_t allowed = 1;                    // sub-steps in the queue; follows how long they take
  std::chrono::steady_clock::time_point since;  // the device began what the oldest mark ends, or later
};

/// Partial results of one track and, behind them, the ticket; aligned.
constexpr std::uint64_t partials_bytes(std::uint64_t parts) {
  return (parts * kernels::reduce_item + 127) / 128 * 128 + 128;
}

/// Working space of gather_reduce: results and locks.
constexpr std::uint64_t handing_bytes = kernels::handing_places * (kernels::handing_item + sizeof(unsigned));

struct PairCopy {
  const std::uint64_t* keys;
  const std::uint32_t* values;
  std::uint64_t* keys_out;
  std::uint32_t* values_out;
  __device__ void operator()(std::uint64_t i) const {
    keys_out[i] = keys[i];
    values_out[i] = values[i];
  }
};

}  // namespace

struct CudaExec::Owned {
  cudaStream_t stream = nullptr;  // null when the stream is the host's
  void* partials = nullptr;
  std::uint64_t parts = 0;  // of a reduction, at most
  void* scratch = nullptr;
  std::uint64_t scratch_bytes = 0;  // of one track
  void* handing = nullptr;          // partial results of the warps of a gather_reduce
  std::string fault;
  std::vector<StageEvents> stages;
  std::vector<Repeat> repeats;
  cudaStream_t tracks[most_tracks] = {};  // 0: the stream itself
  bool entered[most_tracks] = {};         // since begin_tracks
  std::vector<cudaEvent_t> marks;         // a stage has ended; the last one: the tracks begin
  Queue queue;
  cudaStream_t copies = nullptr;  // to page-locked memory
  cudaEvent_t copies_begin = nullptr;
  std::uint64_t launches = 0, captures = 0;
  std::size_t known = 0;
  int most_urgent = 0;  // priorities are 0 and below
  bool timing = false;  // between begin_stage and end_stage
  Timings timings;
};

CudaExec::CudaExec(int device, void* stream)
    : device_(device), stream_(static_cast<cudaStream_t>(stream)), own_(new Owned) {
  const DeviceScope scope(device_);
  // Non-blocking: the host's legacy default stream neither waits for this one nor holds it up.
  const auto make = [this](cudaStream_t* made) {
    return check(cudaStreamCreateWithFlags(made, cudaStreamNonBlocking), "making a stream");
  };
  int multiprocessors = 0;
  if (check(cudaDeviceGetAttribute(&multiprocessors, cudaDevAttrMultiProcessorCount, device_),
            "asking for the number of multiprocessors"))
    multiprocessors_ = static_cast<unsigned>(multiprocessors);
  int least = 0, greatest = 0;
  if (check(cudaDeviceGetStreamPriorityRange(&least, &greatest), "asking for priorities"))
    own_->most_urgent = -greatest;
  if (stream_ == nullptr && make(&own_->stream)) stream_ = own_->stream;
  own_->tracks[0] = stream_;
  for (int k = 1; k < most_tracks; ++k) make(&own_->tracks[k]);
  own_->marks.resize(stage_count + 1);
  for (cudaEvent_t& e : own_->marks)
    check(cudaEventCreateWithFlags(&e, cudaEventDisableTiming), "making an event");
  make(&own_->copies);
  check(cudaEventCreateWithFlags(&own_->copies_begin, cudaEventDisableTiming), "making an event");
  for (cudaEvent_t& e : own_->queue.event)  // a thread that waits for one sleeps
    check(cudaEventCreateWithFlags(&e, cudaEventDisableTiming | cudaEventBlockingSync), "making an event");
}

CudaExec::CudaExec(CudaExec&&) noexcept = default;

CudaExec& CudaExec::operator=(CudaExec&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(track_, other.track_);
  std::swap(priority_, other.priority_);
  std::swap(aside_, other.aside_);
  std::swap(multiprocessors_, other.multiprocessors_);
  std::swap(stream_, other.stream_);
  std::swap(guard_, other.guard_);
  std::swap(own_, other.own_);
  return *this;
}

CudaExec::~CudaExec() {
  if (own_ == nullptr) return;  // moved from
  const DeviceScope scope(device_);
  forget_repeats();
  for (StageEvents& s : own_->stages)
    for (int k = 0; k < StageEvents::ring; ++k) {
      if (s.start[k] != nullptr) (void)cudaEventDestroy(s.start[k]);
      if (s.stop[k] != nullptr) (void)cudaEventDestroy(s.stop[k]);
    }
  if (own_->partials != nullptr) (void)cudaFree(own_->partials);
  if (own_->scratch != nullptr) (void)cudaFree(own_->scratch);
  if (own_->handing != nullptr) (void)cudaFree(own_->handing);
  for (const cudaEvent_t e : own_->marks)
    if (e != nullptr) (void)cudaEventDestroy(e);
  for (const cudaEvent_t e : own_->queue.event)
    if (e != nullptr) (void)cudaEventDestroy(e);
  if (own_->copies_begin != nullptr) (void)cudaEventDestroy(own_->copies_begin);
  if (own_->copies != nullptr) (void)cudaStreamDestroy(own_->copies);
  for (int k = 1; k < most_tracks; ++k)
    if (own_->tracks[k] != nullptr) (void)cudaStreamDestroy(own_->tracks[k]);
  if (own_->stream != nullptr) (void)cudaStreamDestroy(own_->stream);
}

// --- stages side by side ----------------------------------------------------------------------------------

void CudaExec::begin_tracks() {
  const DeviceScope scope(device_);
  std::fill(std::begin(own_->entered), std::end(own_->entered), false);
  own_->entered[0] = true;
  mark_stage(stage_count);
}

void CudaExec::enter_track(int track) {
  track_ = track;
  stream_ = own_->tracks[track];
  if (own_->entered[track]) return;
  own_->entered[track] = true;
  wait_for_stage(stage_count);
}

void CudaExec::hurry(int urgency) { priority_ = -std::min(urgency, own_->most_urgent); }

void CudaExec::mark_stage(int stage) {
  const DeviceScope scope(device_);
  check(cudaEventRecord(own_->marks[static_cast<std::size_t>(stage)], stream_), "marking the end of a stage");
}

void CudaExec::wait_for_stage(int stage) const {
  const DeviceScope scope(device_);
  check(cudaStreamWaitEvent(stream_, own_->marks[static_cast<std::size_t>(stage)], 0), "waiting for a stage");
}

// --- repeated sub-steps -----------------------------------------------------------------------------------

bool CudaExec::known(const RepeatKey& key) const {
  for (std::size_t k = 0; k < own_->repeats.size(); ++k)
    if (own_->repeats[k].key == key) {
      own_->known = k;
      return true;
    }
  return false;
}

void CudaExec::launch_known() const {
  const DeviceScope scope(device_);
  Repeat& r = own_->repeats[own_->known];
  r.used = ++own_->launches;
  check(cudaGraphLaunch(r.graph, stream_), "launching a sub-step");
}

void CudaExec::renew(void* kernel, std::uint64_t grid, unsigned threads, void** arguments) const {
  const Repeat& r = own_->repeats[own_->known];
  cudaKernelNodeParams p{};
  p.func = kernel;
  p.gridDim = dim3(static_cast<unsigned>(grid));
  p.blockDim = dim3(threads);
  p.kernelParams = arguments;
  check(cudaGraphExecKernelNodeSetParams(r.graph, r.first, &p), "renewing the first kernel of a sub-step");
}

bool CudaExec::host_captures() const {
  const DeviceScope scope(device_);
  cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
  return !check(cudaStreamIsCapturing(stream_, &status), "asking whether the stream is captured") ||
         status != cudaStreamCaptureStatusNone;
}

namespace {
std::string event_refused(cudaError_t result) {
  if (result == cudaSuccess) return {};
  (void)cudaGetLastError();
  return std::string("CUDA refuses it: ") + cudaGetErrorString(result) + " (" + cudaGetErrorName(result) +
         "); pass a cudaEvent_t made on the World's device, and destroy it later";
}
constexpr const char* no_event = "is null; pass a cudaEvent_t";
}  // namespace

std::string CudaExec::wait_for_event(void* event) const {
  if (event == nullptr) return no_event;
  const DeviceScope scope(device_);
  return event_refused(cudaStreamWaitEvent(stream_, static_cast<cudaEvent_t>(event), 0));
}

std::string CudaExec::signal_event(void* event) const {
  if (event == nullptr) return no_event;
  const DeviceScope scope(device_);
  return event_refused(cudaEventRecord(static_cast<cudaEvent_t>(event), stream_));
}

void CudaExec::ended_recorded(const std::string& name) const {
  const DeviceScope scope(device_);
  cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
  const cudaError_t asked = cudaStreamIsCapturing(stream_, &status);
  if (asked == cudaSuccess && status != cudaStreamCaptureStatusInvalidated) return;
  (void)cudaGetLastError();
  if (own_->fault.empty())
    own_->fault =
        "custom stage \"" + name +
        "\": recorded: what it did cannot be recorded; let it only launch kernels and asynchronous copies "
        "on its stream (no waiting, no allocation), or set recorded = false";
}

bool CudaExec::begin_capture() const {
  if (host_captures()) return false;
  const DeviceScope scope(device_);
  return check(cudaStreamBeginCapture(stream_, cudaStreamCaptureModeThreadLocal), "capturing a sub-step");
}

void CudaExec::end_capture(const RepeatKey& key) const {
  const DeviceScope scope(device_);
  cudaGraph_t graph = nullptr;
  if (!check(cudaStreamEndCapture(stream_, &graph), "capturing a sub-step")) return;
  Repeat made{key, nullptr, graph, nullptr, ++own_->launches};
  std::size_t roots = 1;
  check(cudaGraphGetRootNodes(graph, &made.first, &roots), "looking for the first kernel of a sub-step");
  // Without this flag every kernel of a graph has the priority of the stream it is launched into.
  if (!check(cudaGraphInstantiate(&made.graph, graph, cudaGraphInstantiateFlagUseNodePriority),
             "instantiating a sub-step")) {
    (void)cudaGraphDestroy(graph);
    return;
  }
  ++own_->captures;
  std::vector<Repeat>& all = own_->repeats;
  if (all.size() == most_repeats) {
    const auto oldest = std::min_element(all.begin(), all.end(),
                                         [](const Repeat& a, const Repeat& b) { return a.used < b.used; });
    oldest->destroy();
    *oldest = made;
  } else {
    all.push_back(made);
  }
  check(cudaGraphLaunch(made.graph, stream_), "launching a sub-step");
}

void CudaExec::forget_repeats() {
  const DeviceScope scope(device_);
  for (const Repeat& r : own_->repeats) r.destroy();
  own_->repeats.clear();
  own_->captures = 0;
}

std::uint64_t CudaExec::captures() const { return own_->captures; }

bool CudaExec::check(cudaError_t result, const char* what) const {
  if (result == cudaSuccess) return true;
  (void)cudaGetLastError();  // it is reported here; the host must not find it again
  if (own_->fault.empty())
    own_->fault =
        std::string(what) + " failed: " + cudaGetErrorString(result) + " (" + cudaGetErrorName(result) + ")";
  return false;
}

std::string CudaExec::fault() { return std::exchange(own_->fault, std::string{}); }

// --- memory -----------------------------------------------------------------------------------------------

void* CudaExec::allocate(std::uint64_t bytes) const {
  const DeviceScope scope(device_);
  void* p = nullptr;
  const cudaError_t result = cudaMalloc(&p, static_cast<std::size_t>(bytes));
  if (result == cudaSuccess) return p;
  (void)cudaGetLastError();
  // Running out is an answer, not a fault.
  if (result != cudaErrorMemoryAllocation) check(result, "allocating memory");
  return nullptr;
}

void CudaExec::release(void* p) const {
  const DeviceScope scope(device_);
  check(cudaFree(p), "freeing memory");
}

void CudaExec::upload(void* to, const void* from, std::uint64_t bytes) const {
  if (bytes == 0) return;
  const DeviceScope scope(device_);
  if (check(cudaMemcpyAsync(to, from, static_cast<std::size_t>(bytes), cudaMemcpyHostToDevice, stream_),
            "copying to the device"))
    check(cudaStreamSynchronize(stream_), "copying to the device");
}

void CudaExec::download(void* to, const void* from, std::uint64_t bytes) const {
  if (bytes == 0) return;
  const DeviceScope scope(device_);
  if (check(cudaMemcpyAsync(to, from, static_cast<std::size_t>(bytes), cudaMemcpyDeviceToHost, stream_),
            "copying from the device"))
    check(cudaStreamSynchronize(stream_), "copying from the device");
}

void CudaExec::zero(void* p, std::uint64_t bytes) const {
  if (bytes == 0) return;
  const DeviceScope scope(device_);
  check(cudaMemsetAsync(p, 0, static_cast<std::size_t>(bytes), stream_), "clearing memory");
}

void* CudaExec::allocate_pinned(std::uint64_t bytes) const {
  const DeviceScope scope(device_);
  void* p = nullptr;
  const cudaError_t result = cudaMallocHost(&p, static_cast<std::size_t>(bytes));
  if (result == cudaSuccess) return p;
  (void)cudaGetLastError();
  if (result != cudaErrorMemoryAllocation) check(result, "allocating page-locked memory");
  return nullptr;
}

void CudaExec::release_pinned(void* p) const {
  const DeviceScope scope(device_);
  check(cudaFreeHost(p), "freeing page-locked memory");
}

void* CudaExec::make_mark() const {
  const DeviceScope scope(device_);
  cudaEvent_t mark = nullptr;  // a thread that waits for it sleeps
  check(cudaEventCreateWithFlags(&mark, cudaEventDisableTiming | cudaEventBlockingSync), "making an event");
  return mark;
}

void CudaExec::release_mark(void* mark) const {
  const DeviceScope scope(device_);
  if (mark != nullptr) check(cudaEventDestroy(static_cast<cudaEvent_t>(mark)), "releasing an event");
}

void CudaExec::begin_copies() const {
  const DeviceScope scope(device_);
  if (check(cudaEventRecord(own_->copies_begin, stream_), "marking what is to be copied"))
    check(cudaStreamWaitEvent(own_->copies, own_->copies_begin, 0), "waiting for what is to be copied");
}

void CudaExec::copy_out(void* to, const void* from, std::uint64_t bytes) const {
  if (bytes == 0) return;
  const DeviceScope scope(device_);
  check(cudaMemcpyAsync(to, from, static_cast<std::size_t>(bytes), cudaMemcpyDeviceToHost, own_->copies),
        "copying from the device");
}

void CudaExec::end_copies(void* mark) const {
  const DeviceScope scope(device_);
  check(cudaEventRecord(static_cast<cudaEvent_t>(mark), own_->copies), "marking the end of a copy");
}

bool CudaExec::reached(void* mark) const {
  const DeviceScope scope(device_);
  const cudaError_t result = cudaEventQuery(static_cast<cudaEvent_t>(mark));
  if (result == cudaErrorNotReady) {
    (void)cudaGetLastError();  // an answer, not an error
    return false;
  }
  check(result, "copying from the device");
  return true;  // nothing more will come
}

void CudaExec::wait_for_mark(void* mark) const {
  const DeviceScope scope(device_);
  check(cudaEventSynchronize(static_cast<cudaEvent_t>(mark)), "copying from the device");
}

void CudaExec::synchronize() {
  const DeviceScope scope(device_);
  if (check(cudaStreamSynchronize(stream_), "a step")) harvest();
  Queue& q = own_->queue;
  q.first = q.marks = 0;
  q.queued = q.unmarked = 0;
}

void CudaExec::pace() {
  if (host_captures()) return;
  const DeviceScope scope(device_);
  using Clock = std::chrono::steady_clock;
  Queue& q = own_->queue;
  if (q.marks == 0 && q.unmarked == 0) q.since = Clock::now();
  // A mark costs its host as much as a sub-step's launch.
  if (++q.unmarked >= std::max(std::min<std::uint64_t>(q.allowed, 4), q.allowed / queue_marks)) {
    const std::size_t last = (q.first + q.marks++) % Queue::ring;
    check(cudaEventRecord(q.event[last], stream_), "marking the end of a sub-step");
    q.steps[last] = q.unmarked;
    q.queued += std::exchange(q.unmarked, 0);
  }
  // The host may be capturing another stream of its own; waiting here is no part of that.
  cudaStreamCaptureMode mode = cudaStreamCaptureModeRelaxed;
  const bool full = q.marks == Queue::ring || (q.marks != 0 && q.queued + q.unmarked > q.allowed);
  if (!full || !check(cudaThreadExchangeStreamCaptureMode(&mode), "waiting for sub-steps")) return;
  while (q.marks != 0 && (q.queued + q.unmarked > q.allowed || q.marks == Queue::ring)) {
    const cudaEvent_t oldest = q.event[q.first];
    const std::uint64_t steps = q.steps[q.first];
    const bool waits = cudaEventQuery(oldest) == cudaErrorNotReady;
    (void)cudaGetLastError();  // "not ready" is an answer, not an error
    if (!check(cudaEventSynchronize(oldest), "a step")) break;
    const Clock::time_point now = Clock::now();
    if (waits) {  // else it ended some time ago, and says nothing of how long sub-steps take
      const double each = std::chrono::duration<double>(now - q.since).count() / static_cast<double>(steps);
      const double fit = queue_seconds / std::max(each, queue_seconds / static_cast<double>(most_queued));
      q.allowed = std::clamp<std::uint64_t>(static_cast<std::uint64_t>(fit), 1, 2 * q.allowed);
    }
    q.since = now;
    q.first = (q.first + 1) % Queue::ring;
    --q.marks;
    q.queued -= steps;
  }
  check(cudaThreadExchangeStreamCaptureMode(&mode), "waiting for sub-steps");
}

std::uint64_t CudaExec::free_bytes() const {
  const DeviceScope scope(device_);
  std::size_t free = 0, total = 0;
  return check(cudaMemGetInfo(&free, &total), "asking for free memory") ? free : 0;
}

/// Room for the parts of reductions over n items, and for what kernels hand over.
bool CudaExec::reserve_partials(std::uint64_t n) {
  const std::uint64_t parts = reduce_parts(n);
  if (own_->parts < parts) {
    if (own_->partials != nullptr) release(own_->partials);
    own_->partials = allocate(most_tracks * partials_bytes(parts));
    own_->parts = own_->partials != nullptr ? parts : 0;
    if (own_->partials == nullptr) return false;
    zero(own_->partials, most_tracks * partials_bytes(parts));
  }
  if (own_->handing == nullptr) {
    own_->handing = allocate(handing_bytes);
    if (own_->handing == nullptr) return false;
    zero(own_->handing, handing_bytes);
  }
  return true;
}

bool CudaExec::reserve(std::uint64_t n) {
  const DeviceScope scope(device_);
  if (!reserve_partials(n)) return false;
  // Asked for all 64 bits; fewer need no more. The sort runs between its caller's buffers, so this is
  // histograms only, a fraction of a byte per item.
  const auto items = static_cast<std::uint32_t>(n);
  CUB_NS_QUALIFIER::DoubleBuffer<std::uint64_t> keys;
  CUB_NS_QUALIFIER::DoubleBuffer<std::uint32_t> values;
  std::size_t sort_bytes = 0, scan_bytes = 0;
  (void)cudaGetLastError();
  if (!check(CUB_NS_QUALIFIER::DeviceRadixSort::SortPairs(nullptr, sort_bytes, keys, values, items, 0, 64,
                                                          stream_),
             "asking for the sort's working space"))
    return false;
  const std::uint32_t* in = nullptr;
  std::uint32_t* out = nullptr;
  if (!check(CUB_NS_QUALIFIER::DeviceScan::InclusiveSum(nullptr, scan_bytes, in, out, items, stream_),
             "asking for the scan's working space"))
    return false;
  // A scan over a body may be tiled more finely than one over memory: 8 bytes for every 64 items at least.
  const std::uint64_t needed =
      (std::max<std::uint64_t>({sort_bytes, 2 * scan_bytes, n / 8 + 65536}) + 255) / 256 * 256;
  if (own_->scratch != nullptr && own_->scratch_bytes >= needed && own_->scratch_bytes / 2 <= needed)
    return true;
  if (own_->scratch != nullptr) release(own_->scratch);
  own_->scratch = allocate(most_tracks * needed);
  own_->scratch_bytes = own_->scratch != nullptr ? needed : 0;
  return own_->scratch != nullptr;
}

std::uint64_t CudaExec::reserved_bytes() const {
  return most_tracks * (own_->scratch_bytes +
                        (own_->partials != nullptr ? partials_bytes(own_->parts) : std::uint64_t{0})) +
         (own_->handing != nullptr ? handing_bytes : std::uint64_t{0});
}

void* CudaExec::handing_places() const {
  if (own_->handing == nullptr) check(cudaErrorInvalidValue, "gather_reduce before anything was reserved");
  return own_->handing;
}

void* CudaExec::partials(std::uint64_t parts) const {
  if (own_->partials == nullptr || own_->parts < parts) {
    check(cudaErrorInvalidValue, "reduce of more items than were reserved");
    return nullptr;
  }
  return static_cast<unsigned char*>(own_->partials) +
         static_cast<std::uint64_t>(track_) * partials_bytes(own_->parts);
}

/// Behind the partial results.
unsigned* CudaExec::ticket() const {
  return reinterpret_cast<unsigned*>(static_cast<unsigned char*>(partials(0)) + partials_bytes(own_->parts) -
                                     128);
}

void* CudaExec::scratch(std::size_t bytes) const {
  if (bytes <= own_->scratch_bytes)
    return static_cast<unsigned char*>(own_->scratch) +
           static_cast<std::uint64_t>(track_) * own_->scratch_bytes;
  check(cudaErrorInvalidValue, "scan or sort of more items than were reserved");
  return nullptr;
}

// --- sums and sort
// -------------------------------------------------------------------------------------------------

void CudaExec::sort(std::uint64_t n, std::uint32_t bits, std::uint64_t* keys, std::uint32_t* values,
                    std::uint64_t* keys_out, std::uint32_t* values_out) const {
  if (n == 0) return;
  const DeviceScope scope(device_);
  (void)cudaGetLastError();  // CUB would take an earlier error of the host's for its own
  // Between the two buffers of the caller: a sort that may not touch its input needs 12 bytes more per
  // particle.
  CUB_NS_QUALIFIER::DoubleBuffer<std::uint64_t> k(keys, keys_out);
  CUB_NS_QUALIFIER::DoubleBuffer<std::uint32_t> v(values, values_out);
  const int end_bit = static_cast<int>(std::min(std::max(bits, 1u), 64u));
  const auto items = static_cast<std::uint32_t>(n);
  std::size_t bytes = 0;
  if (!check(CUB_NS_QUALIFIER::DeviceRadixSort::SortPairs(nullptr, bytes, k, v, items, 0, end_bit, stream_),
             "sort"))
    return;
  void* const space = scratch(bytes);
  if (space == nullptr) return;
  if (!check(CUB_NS_QUALIFIER::DeviceRadixSort::SortPairs(space, bytes, k, v, items, 0, end_bit, stream_),
             "sort"))
    return;
  // An even number of passes ends where it began. The guard must not keep the copy from happening.
  if (k.Current() != keys_out)
    launch(kernels::each<PairCopy>, blocks(n, kernels::block), kernels::block,
           static_cast<const std::uint32_t*>(nullptr), n, PairCopy{keys, values, keys_out, values_out});
}

// --- timings ----------------------------------------------------------------------------------------------

void CudaExec::begin_stage(int index, const char* name) {
  push_profiler_range(name);
  const DeviceScope scope(device_);
  cudaStreamCaptureStatus capture = cudaStreamCaptureStatusNone;
  // Events recorded into a graph have no time of their own.
  own_->timing =
      check(cudaStreamIsCapturing(stream_, &capture), "timing") && capture == cudaStreamCaptureStatusNone;
  if (!own_->timing) return;
  if (index >= static_cast<int>(own_->stages.size()))
    own_->stages.resize(static_cast<std::size_t>(index) + 1);
  StageEvents& s = own_->stages[static_cast<std::size_t>(index)];
  if (s.start[0] == nullptr)
    for (int k = 0; k < StageEvents::ring && own_->timing; ++k)
      own_->timing =
          check(cudaEventCreate(&s.start[k]), "timing") && check(cudaEventCreate(&s.stop[k]), "timing");
  if (s.pending[s.next]) harvest();
  s.pending[s.next] = false;  // one that has not ended yet is forgotten
  if (own_->timing) own_->timing = check(cudaEventRecord(s.start[s.next], stream_), "timing");
}

void CudaExec::end_stage(int index) {
  if (own_->timing) {
    const DeviceScope scope(device_);
    StageEvents& s = own_->stages[static_cast<std::size_t>(index)];
    s.pending[s.next] = check(cudaEventRecord(s.stop[s.next], stream_), "timing");
    s.next = (s.next + 1) % StageEvents::ring;
    own_->timing = false;
  }
  pop_profiler_range();
}

void CudaExec::harvest() {
  for (std::size_t index = 0; index < own_->stages.size(); ++index) {
    StageEvents& s = own_->stages[index];
    for (int n = 0; n < StageEvents::ring; ++n) {
      const int k = (s.next + n) % StageEvents::ring;  // oldest first
      if (!s.pending[k] || cudaEventQuery(s.stop[k]) != cudaSuccess) continue;
      float ms = 0;
      s.pending[k] = false;
      if (check(cudaEventElapsedTime(&ms, s.start[k], s.stop[k]), "timing"))
        own_->timings.add(static_cast<int>(index), static_cast<double>(ms));
    }
  }
  (void)cudaGetLastError();  // "not ready" is an answer, not an error
}

const Timings& CudaExec::collect() {
  const DeviceScope scope(device_);
  harvest();
  return own_->timings;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
