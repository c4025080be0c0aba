// SPDX-License-Identifier: Apache-2.0
// The verbs on CUDA. What each one means is said once, in exec/exec_cpu.hpp; here is what differs:
//
//   - Everything is enqueued on one stream, and no verb allocates, waits or reads back, so that a step can be
//     captured into a CUDA graph. Only upload, download, synchronize and (de)allocation wait, and only
//     release(), for which CUDA has no other way, waits for more than this stream.
//   - The guard is read on the device, at the start of every kernel.
//   - reduce asks for a combine that is commutative, too: threads take strided shares. Its shape depends on n
//     alone, so equal inputs give equal bits.
//   - scan is defined in exec/exec_cuda_scan.cuh, because CUB's header would cost every stage seconds to
//     compile.
//   - Stages that do not need each other run on streams of their own, which fork from that one and join it
//     again within a sub-step; a capture takes them along.
//   - repeat() captures what is enqueued into a graph, kept by its key, and launches that the next time.
//     Where the host captures the stream itself, or makes it do so, nothing is kept.
//   - Hosts use other devices: every entry selects its own and puts the host's back.
//   - The first error is kept until fault() is asked; nothing is thrown or printed.
#pragma once

#include <cuda_runtime.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>

#include "exec/device_scope.cuh"
#include "exec/gather.hpp"
#include "exec/kernels_each.cuh"
#include "exec/kernels_gather.cuh"
#include "exec/kernels_reduce.cuh"
#include "exec/kernels_sum_by_row.cuh"
#include "exec/repeat_key.hpp"
#include "exec/timings.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

class CudaExec {
 public:
  static constexpr Backend backend = Backend::cuda;

  /// stream: a cudaStream_t of the host's, which must outlive this; null = one of its own.
  CudaExec(int device, void* stream);
  CudaExec(CudaExec&&) noexcept;
  CudaExec& operator=(CudaExec&&) noexcept;
  ~CudaExec();

  void set_guard(const std::uint32_t* guard) { guard_ = guard; }

  template <class Body>
  void for_each(std::uint64_t n, const Body& body) const {
    if (n == 0) return;
    const std::uint64_t all = blocks(n, kernels::block);
    if constexpr (modest<Body>::value) {
      const std::uint64_t few = std::uint64_t{aside_} * multiprocessors_;
      launch(kernels::each_modestly<Body>, few != 0 && few < all ? few : all, kernels::block, guard_, n,
             body);
    } else {
      launch(kernels::each<Body>, all, kernels::block, guard_, n, body);
    }
  }

  template <class Body>
  void gather(std::uint64_t n, const Body& body) const {
    if (n == 0) return;
    if (gather_parts<Body>(n) == 1)
      launch(kernels::gather<1, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body);
    else
      launch(kernels::gather<3, Body>, blocks(n, kernels::gather_items), kernels::gather_block<3>, guard_, n,
             body);
  }

  static bool gathers_two(std::uint64_t n) { return shared_parts(n) == 1u; }
  template <class Body>
  void gather_two(std::uint64_t n, std::uint64_t left_over, const Body& body) const {
    if (n == 0) return;
    const std::uint64_t apart = blocks(left_over, kernels::block);
    launch(kernels::gather_two<Body>, apart + blocks(n, 2u * kernels::block), kernels::block, guard_, n,
           static_cast<unsigned>(apart), left_over, body);
  }

  template <class Body>
  void gather_adding(std::uint64_t n, const Body& body) const {
    if (n == 0) return;
    if (gather_parts<Body>(n) == 1)
      launch(kernels::gather_adding<1, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body);
    else
      launch(kernels::gather_adding<3, Body>, blocks(n, kernels::gather_items), kernels::gather_block<3>,
             guard_, n, body);
  }

  static constexpr bool lists = true;
  template <class Body>
  void select(std::uint64_t n, const Body& body, std::uint32_t* list) const {
    zero(list, sizeof *list);
    if (n != 0)
      launch(kernels::select<Body>, blocks(n, kernels::block), kernels::block, guard_, n, body, list);
  }

  template <class Body>
  void gather_listed(std::uint64_t n, const std::uint32_t* list, const Body& body) const {
    if (n == 0) return;
    const std::uint64_t all = blocks(n, kernels::gather_items);
    const std::uint64_t most = std::uint64_t{kernels::listed_blocks} * multiprocessors_;
    const std::uint64_t grid = all < most ? all : most;
    launch(kernels::gather_listed<Body>, grid, listed<Body>::parts * kernels::gather_items, guard_, list,
           body);
  }

  template <class R, class Body, class Last = Nothing>
  void reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) const {
    static_assert(
        std::is_trivially_copyable<R>::value && sizeof(R) <= kernels::reduce_item && alignof(R) <= 16,
        "the scratch memory of reductions is sized for small plain results");
    const std::uint64_t most =
        std::uint64_t{kernels::reduce_resident<Body>} * kernels::reduce_multiprocessors;
    const std::uint64_t parts = reduce_parts(n) < most ? reduce_parts(n) : most;
    R* const partial = static_cast<R*>(partials(parts));
    if (partial == nullptr) return;
    launch(kernels::reduce<R, Body, Last>, parts, kernels::reduce_block, guard_, n, body, partial, ticket(),
           out, last);
  }

  static constexpr bool fuses() { return true; }
  template <class R, class Body, class Last = Nothing>
  void gather_reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) const {
    static_assert(std::is_trivially_copyable<R>::value && sizeof(R) <= kernels::handing_item);
    R* const places = static_cast<R*>(handing_places());
    if (places == nullptr) return;
    unsigned* const locks = reinterpret_cast<unsigned*>(places + kernels::handing_places);
    const unsigned used = Body::shared || n < gather_few ? kernels::few_places : kernels::handing_places;
    const auto one_part = [&] {
      launch(kernels::gather_reduce<1, R, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body,
             places, locks, used);
    };
    if constexpr (!Body::shared) {
      if (n != 0) one_part();
    } else if (n != 0) {
      if (gather_parts<Body>(n) == 1) one_part();
      else
        launch(kernels::gather_reduce<3, R, Body>, blocks(n, kernels::gather_items), kernels::gather_block<3>,
               guard_, n, body, places, locks, used);
    }
    launch(kernels::combine_places<R, Last>, 1, used, guard_, places, out, last);
  }

  template <class Body>
  void sum_by_row(std::uint64_t n, const Body& body, typename Body::Sum* rows) const {
    if (n == 0) return;
    if (n < gather_few)
      launch(kernels::sum_by_row<1, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body, rows);
    else
      launch(kernels::sum_by_row<kernels::sum_items, Body>,
             blocks(n, std::uint64_t{kernels::block} * kernels::sum_items), kernels::block, guard_, n, body,
             rows);
  }

  /// Defined in exec/exec_cuda_scan.cuh.
  template <class Body, class Count>
  void scan(std::uint64_t n, const Body& body, Count* out) const;

  /// These are defined in exec/exec_cuda_bucket.cuh.
  template <class Body>
  void bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
              std::uint32_t* begin, std::uint32_t* order, std::uint32_t* counts) const;
  template <class First>
  void begin_buckets(std::uint32_t m, std::uint32_t* counts, std::uint32_t* begin, const First& first) const;
  void fill_buckets(std::uint64_t n, const std::uint32_t* bucket_of, const std::uint32_t* begin,
                    std::uint32_t* order, std::uint32_t* counts) const;
  /// Behind the counts: the state that tiles of their running sum exchange, and the number of its turn.
  static constexpr std::uint64_t count_room(std::uint64_t m) {
    return even(m + 1) + 2 * blocks(m + 1, kernels::sum_tile) + 2;
  }

  void sort(std::uint64_t n, std::uint32_t bits, std::uint64_t* keys, std::uint32_t* values,
            std::uint64_t* keys_out, std::uint32_t* values_out) const;

  template <class Body>
  void accumulate(std::uint64_t n, const Body& body) const {
    if (n != 0)
      launch(kernels::each_adding<Body>, blocks(n, kernels::block), kernels::block, guard_, n, body);
  }

  template <class V>
  void copy(std::uint64_t n, const V* from, V* to) const {
    for_each(n, kernels::CopyBody<V>{from, to});
  }

  template <class V>
  void fill(std::uint64_t n, const V& value, V* to) const {
    for_each(n, kernels::FillBody<V>{value, to});
  }

  template <class Enqueue>
  void repeat(const RepeatKey& key, const Enqueue& enqueue) {
    if (known(key)) return launch_known();
    const bool captured = begin_capture();
    enqueue();
    if (captured) end_capture(key);
  }
  template <class First, class Enqueue>
  void repeat(const RepeatKey& key, const First& first, const Enqueue& enqueue) {
    if (known(key)) {
      renewing_ = true;
      first();
      renewing_ = false;
      return launch_known();
    }
    const bool captured = begin_capture();
    first();
    enqueue();
    if (captured) end_capture(key);
  }

  // --- stages side by side (pipeline/schedule.hpp): track 0 is the stream itself; each has its own working
  // space for reductions, scans and sorts.
  void begin_tracks();
  /// Work from now on is enqueued on this track; the first time on one other than 0, behind the work before
  /// begin_tracks.
  void enter_track(int track);
  /// Where there is not room for all, work enqueued from now on precedes less urgent work; 0: the usual priority.
  void hurry(int urgency);
  /// Work enqueued from now on takes at most so many blocks of every multiprocessor; 0: no limit.
  void step_aside(unsigned blocks) { aside_ = blocks; }
  void mark_stage(int stage);
  void wait_for_stage(int stage) const;

  /// Forgets what repeat() kept: the buffers it names are gone.
  void forget_repeats();
  /// Work enqueued from now on waits for an event of the host; records one behind the work so far. Returns an error text, or nothing.
  std::string wait_for_event(void* event) const;
  std::string signal_event(void* event) const;
  /// Whether what is enqueued now goes into a graph of the host's, to run some time or never, once or often.
  bool host_captures() const;
  /// A recorded stage of the host's has enqueued its work; a fault where that made an end of the recording.
  void ended_recorded(const std::string& name) const;
  /// Graphs made since then.
  std::uint64_t captures() const;

  // --- for the engine ---
  void* allocate(std::uint64_t bytes) const;
  void release(void* p) const;
  void upload(void* to, const void* from, std::uint64_t bytes) const;
  void download(void* to, const void* from, std::uint64_t bytes) const;
  void zero(void* p, std::uint64_t bytes) const;
  void synchronize();
  static constexpr bool in_host_memory = false;
  // Copies run on a stream of their own behind the work enqueued so far, so that later work need not wait for them. Marks
  // are events; null where none could be made, which is a fault.
  void* allocate_pinned(std::uint64_t bytes) const;
  void release_pinned(void* p) const;
  void* make_mark() const;
  void release_mark(void* mark) const;
  void begin_copies() const;
  void copy_out(void* to, const void* from, std::uint64_t bytes) const;
  void end_copies(void* mark) const;
  bool reached(void* mark) const;
  void wait_for_mark(void* mark) const;
  /// After every sub-step: waits until no more than queue_seconds of sub-steps are enqueued, so that a host that
  /// stops need not wait for long. Does nothing while the host captures the stream.
  void pace();
  /// Enqueued work is not examined again: pace() limits its amount.
  void watch(const std::atomic<bool>*) {}
  static constexpr bool asked_to_stop() { return false; }
  std::uint64_t free_bytes() const;
  /// Working space of reduce, scan and sort over up to n items; without it they record a fault.
  bool reserve(std::uint64_t n);
  std::uint64_t reserved_bytes() const;
  void* native_stream() const { return stream_; }
  /// The first error since the last call; empty = none.
  std::string fault();

  /// Events around a stage, in a ring per stage made when it is first timed. A captured step is not timed.
  void begin_stage(int index, const char* name);
  void end_stage(int index);
  /// Collects the timings that have finished; does not wait.
  const Timings& collect();

 private:
  struct Owned;  // stream, working space, events and the first error

  bool reserve_partials(std::uint64_t n);
  static constexpr std::uint64_t blocks(std::uint64_t n, std::uint64_t size) { return (n + size - 1) / size; }
  static constexpr std::uint64_t even(std::uint64_t n) { return n + n % 2; }
  static std::uint64_t* tiles_of(std::uint32_t m, std::uint32_t* counts) {
    return reinterpret_cast<std::uint64_t*>(counts + even(std::uint64_t{m} + 1));
  }
  static std::uint32_t* turn_of(std::uint32_t m, std::uint32_t* counts) {
    return counts + (count_room(m) - 2);
  }
  static constexpr std::uint64_t reduce_parts(std::uint64_t n) {
    const std::uint64_t parts = blocks(n, kernels::reduce_block);
    return parts == 0 ? 1 : parts < kernels::reduce_blocks ? parts : kernels::reduce_blocks;
  }

  template <class... Parameters, class... Arguments>
  void launch(void (*kernel)(Parameters...), std::uint64_t grid, unsigned threads,
              Arguments... arguments) const {
    const DeviceScope scope(device_);
    if (renewing_) {
      void* pointers[] = {&arguments...};
      return renew(reinterpret_cast<void*>(kernel), grid, threads, pointers);
    }
    cudaLaunchConfig_t config{};
    config.gridDim = dim3(static_cast<unsigned>(grid));
    config.blockDim = dim3(threads);
    config.stream = stream_;
    cudaLaunchAttribute priority{};
    priority.id = cudaLaunchAttributePriority;
    priority.val.priority = priority_;
    config.attrs = &priority;
    config.numAttrs = 1;
    check(grid <= 0x7fffffffu ? cudaLaunchKernelEx(&config, kernel, arguments...)
                              : cudaErrorInvalidConfiguration,
          "launching a kernel");
  }

  /// Keeps the first error; true = success.
  bool check(cudaError_t result, const char* what) const;
  /// Working space of gather_reduce: one set, so that no two may run concurrently; all 0 between launches.
  void* handing_places() const;
  void* partials(std::uint64_t parts) const;
  unsigned* ticket() const;
  /// Whether there is a graph for this key; renew and launch_known then refer to it.
  bool known(const RepeatKey& key) const;
  void launch_known() const;
  /// In place of a launch: its arguments for the first kernel of the known graph.
  void renew(void* kernel, std::uint64_t grid, unsigned threads, void** arguments) const;
  bool begin_capture() const;
  void end_capture(const RepeatKey& key) const;
  /// Working space of CUB, or null and a fault when it is smaller than `bytes`.
  void* scratch(std::size_t bytes) const;
  void harvest();

  int device_ = 0;
  int track_ = 0;
  int priority_ = 0;
  unsigned aside_ = 0;
  unsigned multiprocessors_ = 1;
  bool renewing_ = false;
  cudaStream_t stream_ = nullptr;  // of the track
  const std::uint32_t* guard_ = nullptr;
  std::unique_ptr<Owned> own_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
