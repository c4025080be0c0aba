// SPDX-License-Identifier: Apache-2.0
// The CUDA backend: finds the device, says why when it cannot be used, and makes the engine.
#include <cuda_runtime.h>

#include "engine/engine_impl.hpp"
#include "exec/exec_cuda.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {

namespace {

__global__ void probe() {}

std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

int driver_version() {
  int version = 0;
  if (cudaDriverGetVersion(&version) != cudaSuccess) version = 0;
  (void)cudaGetLastError();
  return version;
}

int runtime_version() {
  int version = 0;
  (void)cudaRuntimeGetVersion(&version);
  return version;
}

/// Number of devices, or why there is none.
Result<int> count_devices() {
  int count = 0;
  const cudaError_t result = cudaGetDeviceCount(&count);
  (void)cudaGetLastError();
  const auto none_because = [](const std::string& why) {
    return Error{ErrorCode::no_device, "backend: " + why};
  };
  if (driver_version() == 0)
    return none_because("no NVIDIA driver on this machine; install one, or use the CPU backend");
  if (result == cudaErrorInsufficientDriver)
    return none_because("the NVIDIA driver supports CUDA " + version_text(driver_version()) +
                        ", this build needs " + version_text(runtime_version()) +
                        "; update the driver, or use the CPU backend");
  if (result == cudaErrorNoDevice || (result == cudaSuccess && count == 0))
    return none_because("the NVIDIA driver finds no GPU (is CUDA_VISIBLE_DEVICES set?); use the CPU backend");
  if (result != cudaSuccess)
    return none_because(std::string("the NVIDIA driver reports: ") + cudaGetErrorString(result) +
                        "; use the CPU backend");
  return count;
}

std::string device_text(const cudaDeviceProp& p) {
  return std::string(p.name) + " (compute capability " + std::to_string(p.major) + "." +
         std::to_string(p.minor) + ", " + std::to_string(p.totalGlobalMem >> 20) + " MiB)";
}

/// Fails when no compiled architecture runs on the device.
Status probe_device(int device) {
  const DeviceScope scope(device);
  cudaDeviceProp properties{};
  cudaError_t result = cudaGetDeviceProperties(&properties, device);
  cudaFuncAttributes attributes{};
  if (result == cudaSuccess) result = cudaFuncGetAttributes(&attributes, probe);
  (void)cudaGetLastError();
  if (result == cudaSuccess) return {};
  const std::string number = std::to_string(device);
  if (result == cudaErrorNoKernelImageForDevice || result == cudaErrorInvalidDeviceFunction ||
      result == cudaErrorUnsupportedPtxVersion || result == cudaErrorInvalidPtx) {
    const std::string capability = std::to_string(properties.major) + std::to_string(properties.minor);
    return Error{ErrorCode::no_device, "device: " + number + ", " + properties.name +
                                           ", has compute capability " + capability +
                                           ", this build holds code for " MELTSIM_CUDA_ARCHITECTURES
                                           " and newer; configure with -DCMAKE_CUDA_ARCHITECTURES=" +
                                           capability + ", or use the CPU backend"};
  }
  return Error{ErrorCode::no_device, "device: " + number +
                                         " is there but cannot be used: " + cudaGetErrorString(result) +
                                         "; use another one, or the CPU backend"};
}

template <class T>
std::shared_ptr<Engine> make(CudaExec exec, std::string device) {
  return std::make_shared<EngineImpl<CudaExec, T>>(std::move(exec), std::move(device));
}

}  // namespace

Result<std::shared_ptr<Engine>> make_cuda_engine(const WorldDesc& desc) {
  const Result<int> count = count_devices();
  if (!count) return count.error();
  if (desc.device < 0 || desc.device >= *count)
    return Error{ErrorCode::no_device,
                 "device: " + std::to_string(desc.device) + " does not exist; there " +
                     (*count == 1 ? std::string("is one, number 0")
                                  : "are " + std::to_string(*count) + ", numbered 0 to " +
                                        std::to_string(*count - 1))};
  if (Status usable = probe_device(desc.device); !usable) return usable.error();
  cudaDeviceProp properties{};
  (void)cudaGetDeviceProperties(&properties, desc.device);
  CudaExec exec(desc.device, desc.stream);
  if (const std::string fault = exec.fault(); !fault.empty())
    return Error{ErrorCode::no_device, "device: " + std::to_string(desc.device) + ": " + fault};
  if (desc.precision == Precision::double_precision) return make<double>(std::move(exec), properties.name);
  return make<float>(std::move(exec), properties.name);
}

CudaInfo cuda_info() {
  CudaInfo info;
  info.built = true;
  info.runtime = version_text(runtime_version());
  info.architectures = MELTSIM_CUDA_ARCHITECTURES;
  if (driver_version() != 0) info.driver = version_text(driver_version());
  const Result<int> count = count_devices();
  if (!count) {
    info.reason = count.error().message;
    return info;
  }
  for (int device = 0; device < *count; ++device) {
    cudaDeviceProp properties{};
    if (Status usable = probe_device(device); !usable) info.reason = usable.error().message;
    else if (cudaGetDeviceProperties(&properties, device) == cudaSuccess)
      info.devices.push_back(device_text(properties));
  }
  if (!info.devices.empty()) info.reason.clear();
  return info;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
