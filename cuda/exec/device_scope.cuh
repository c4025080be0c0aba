// SPDX-License-Identifier: Apache-2.0
// Hosts use other devices: every entry selects its own and puts the host's back.
#pragma once

#include <cuda_runtime.h>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Makes a device current for as long as it lives.
class DeviceScope {
 public:
  explicit DeviceScope(int device) {
    if (cudaGetDevice(&before_) != cudaSuccess) before_ = device;
    changed_ = before_ != device && cudaSetDevice(device) == cudaSuccess;
  }
  ~DeviceScope() {
    if (changed_) (void)cudaSetDevice(before_);
  }
  DeviceScope(const DeviceScope&) = delete;
  DeviceScope& operator=(const DeviceScope&) = delete;

 private:
  int before_ = 0;
  bool changed_ = false;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
