// SPDX-License-Identifier: Apache-2.0
// The buffer is mapped around the steps of a frame; a stage of the viewer's own writes it at the end of every
// sub-step, on the World's stream. A World with such a stage is run stage by stage, not as one CUDA graph.
#include <cuda_runtime.h>
// After it:
#include <cuda_gl_interop.h>

#include <algorithm>

#include "device_feed.hpp"
#include "meltsim/cuda_interop.hpp"
#include "particle_vertex.hpp"
#include "temperature_table.hpp"

namespace view {

namespace {

constexpr const char* stage_name = "view";

template <class T>
__global__ void write_vertices(meltsim::DeviceSpan<meltsim::Vec4<T>> position,
                               meltsim::DeviceSpan<meltsim::Vec4<T>> velocity, const double* enthalpy,
                               const std::uint32_t* tag, const SubstanceCurve* curves, ParticleVertex* to) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i >= position.size) return;
  const meltsim::Vec4<T> x = position.data[i];
  ParticleVertex v;
  v.x = static_cast<float>(x.x);
  v.y = static_cast<float>(x.y);
  v.z = static_cast<float>(x.z);
  v.speed = static_cast<float>(length(xyz(velocity.data[i])));
  v.tag = tag[i];
  const double volume = static_cast<double>(x.w);
  v.temperature = static_cast<float>(particle_temperature(curves, v.tag, enthalpy[i], volume));
  to[i] = v;
}

class CudaFeed : public DeviceFeed {
 public:
  CudaFeed(std::size_t capacity, int device) : capacity_(capacity), device_(device) {}
  CudaFeed(const CudaFeed&) = delete;
  CudaFeed& operator=(const CudaFeed&) = delete;

  ~CudaFeed() override {
    // Nothing is left to do about a failure here.
    if (resource_ != nullptr) (void)cudaGraphicsUnregisterResource(resource_);
    (void)cudaFree(curves_);
  }

  bool open(unsigned buffer, const std::vector<SubstanceCurve>& curves) {
    const std::size_t bytes = curves.size() * sizeof(SubstanceCurve);
    return good(cudaSetDevice(device_)) &&
           good(cudaGraphicsGLRegisterBuffer(&resource_, buffer, cudaGraphicsRegisterFlagsWriteDiscard)) &&
           good(cudaMalloc(reinterpret_cast<void**>(&curves_), bytes)) &&
           good(cudaMemcpy(curves_, curves.data(), bytes, cudaMemcpyHostToDevice));
  }

  void before_steps() override {
    written_ = 0;
    std::size_t bytes = 0;
    void* mapped = nullptr;
    mapped_ = good(cudaSetDevice(device_)) && good(cudaGraphicsMapResources(1, &resource_, stream_)) &&
              good(cudaGraphicsResourceGetMappedPointer(&mapped, &bytes, resource_));
    // Before the first sub-step its stream is not known yet.
    if (mapped_ && stream_ == nullptr) (void)good(cudaDeviceSynchronize());
    vertices_ = mapped_ ? static_cast<ParticleVertex*>(mapped) : nullptr;
  }

  std::size_t after_steps() override {
    vertices_ = nullptr;
    if (!mapped_) return 0;
    mapped_ = false;
    // Orders OpenGL behind everything enqueued on the stream so far.
    if (!good(cudaGraphicsUnmapResources(1, &resource_, stream_))) return 0;
    return written_;
  }

  std::size_t needed() const override { return needed_; }
  const std::string& error() const override { return error_; }

  static void run(const meltsim::StageContext& context, void* user) {
    static_cast<CudaFeed*>(user)->write(context);
  }

 private:
  void write(const meltsim::StageContext& context) {
    stream_ = meltsim::cuda_interop::stream(context);
    needed_ = static_cast<std::size_t>(context.particles);
    if (vertices_ == nullptr || context.particles == 0 || context.particles > capacity_) return;
    const bool single = meltsim::cuda_interop::holds<float>(context);
    if (single) launch<float>(context);
    else launch<double>(context);
    if (good(cudaGetLastError())) written_ = needed_;
  }

  template <class T>
  void launch(const meltsim::StageContext& context) {
    namespace interop = meltsim::cuda_interop;
    const auto position = interop::position<T>(context);
    const auto velocity = interop::velocity<T>(context);
    if (position.data == nullptr || velocity.data == nullptr || context.enthalpy == nullptr) return;
    const unsigned threads = 128, blocks = static_cast<unsigned>((position.size + threads - 1) / threads);
    write_vertices<<<blocks, threads, 0, stream_>>>(position, velocity, context.enthalpy, context.tag,
                                                    curves_, vertices_);
  }

  bool good(cudaError_t status) {
    if (status != cudaSuccess) error_ = cudaGetErrorString(status);
    return status == cudaSuccess;
  }

  std::size_t capacity_, needed_ = 0, written_ = 0;
  int device_;
  bool mapped_ = false;
  cudaStream_t stream_ = nullptr;  ///< of the World, once it has run a sub-step
  cudaGraphicsResource* resource_ = nullptr;
  SubstanceCurve* curves_ = nullptr;
  ParticleVertex* vertices_ = nullptr;
  std::string error_;
};

bool draws_on(int device, std::string& reason) {
  unsigned count = 0;
  int devices[16] = {};
  const cudaError_t status = cudaGLGetDevices(&count, devices, 16, cudaGLDeviceListAll);
  if (status == cudaSuccess && std::count(devices, devices + count, device) > 0) return true;
  reason = "the window is drawn by another device than the one that simulates";
  if (status != cudaSuccess) reason += std::string(": ") + cudaGetErrorString(status);
  (void)cudaGetLastError();  // said; nobody else need stumble over it
  return false;
}

}  // namespace

DeviceFeedResult make_device_feed(meltsim::World& world, const std::vector<meltsim::MaterialId>& materials,
                                  unsigned buffer, std::size_t capacity) {
  if (world.backend() != meltsim::Backend::cuda) return {nullptr, "the backend is the CPU"};
  const int device = world.desc().device;
  DeviceFeedResult result;
  if (!draws_on(device, result.reason)) return result;
  auto feed = std::make_unique<CudaFeed>(capacity, device);
  if (!feed->open(buffer, substance_curves(world, materials))) return {nullptr, feed->error()};
  meltsim::CustomStage stage;
  stage.name = stage_name;
  stage.run = &CudaFeed::run;
  stage.user = feed.get();
  stage.reads = {"position", "velocity", "enthalpy", "tag"};
  const meltsim::Status added = world.scheduler().insert_after("step.integrate", stage);
  if (!added) return {nullptr, added.error().message};
  result.feed = std::move(feed);
  return result;
}

void remove_device_feed(meltsim::World& world, std::unique_ptr<DeviceFeed>& feed) {
  if (feed == nullptr) return;
  (void)world.scheduler().remove(stage_name);
  feed.reset();
}

}  // namespace view
