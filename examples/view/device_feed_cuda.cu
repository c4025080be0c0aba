// SPDX-License-Identifier: Apache-2.0
// One kernel per picture, on the World's stream: the World's own steps are left as they are.
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

template <class T>
__global__ void write_vertices(std::size_t n, VertexBody<T> body) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) body(i);
}

class CudaFeed : public DeviceFeed {
 public:
  explicit CudaFeed(int device) : device_(device) {}
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

  bool write(const meltsim::StageContext& state) override {
    const cudaStream_t stream = meltsim::cuda_interop::stream(state);
    std::size_t bytes = 0;
    void* mapped = nullptr;
    if (!good(cudaSetDevice(device_)) || !good(cudaGraphicsMapResources(1, &resource_, stream))) return false;
    bool written = good(cudaGraphicsResourceGetMappedPointer(&mapped, &bytes, resource_));
    if (written && bytes < state.particles * sizeof(ParticleVertex)) {
      error_ = "the buffer is too small";
      written = false;
    }
    if (written) {
      auto* const to = static_cast<ParticleVertex*>(mapped);
      if (state.precision == meltsim::Precision::double_precision) launch<double>(state, to, stream);
      else launch<float>(state, to, stream);
      written = good(cudaGetLastError());
    }
    // Orders OpenGL behind what was enqueued on the stream.
    return good(cudaGraphicsUnmapResources(1, &resource_, stream)) && written;
  }

  const std::string& error() const override { return error_; }

 private:
  template <class T>
  void launch(const meltsim::StageContext& state, ParticleVertex* to, cudaStream_t stream) {
    const std::size_t n = static_cast<std::size_t>(state.particles);
    const unsigned threads = 128, blocks = static_cast<unsigned>((n + threads - 1) / threads);
    if (n != 0) write_vertices<<<blocks, threads, 0, stream>>>(n, VertexBody<T>(state, curves_, to));
  }

  bool good(cudaError_t status) {
    if (status != cudaSuccess) error_ = cudaGetErrorString(status);
    return status == cudaSuccess;
  }

  int device_;
  cudaGraphicsResource* resource_ = nullptr;
  SubstanceCurve* curves_ = nullptr;
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

DeviceFeedResult make_device_feed(const meltsim::World& world,
                                  const std::vector<meltsim::MaterialId>& materials, unsigned buffer) {
  if (world.backend() != meltsim::Backend::cuda) return {nullptr, "the backend is the CPU"};
  const int device = world.desc().device;
  DeviceFeedResult result;
  if (!draws_on(device, result.reason)) return result;
  auto feed = std::make_unique<CudaFeed>(device);
  if (!feed->open(buffer, substance_curves(world, materials))) return {nullptr, feed->error()};
  result.feed = std::move(feed);
  return result;
}

}  // namespace view
