// SPDX-License-Identifier: Apache-2.0
// CudaExec::scan. Include it where a stage scans, next to exec/exec_cuda.cuh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cub/device/device_scan.cuh>

#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>

#include "exec/exec_cuda.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {

/// No guard: a scan works on working space, which a World that halted does not read again.
template <class Body, class Count>
void CudaExec::scan(std::uint64_t n, const Body& body, Count* out) const {
  if (n == 0) return;
  const DeviceScope scope(device_);
  (void)cudaGetLastError();  // CUB would take an earlier error of the host's for its own
  // body(0), body(1), ... as CUB reads them
  const auto values = THRUST_NS_QUALIFIER::make_transform_iterator(
      THRUST_NS_QUALIFIER::make_counting_iterator(std::uint64_t{0}), body);
  const auto items = static_cast<std::uint32_t>(n);  // particle ids are 32-bit
  std::size_t bytes = 0;
  if (!check(CUB_NS_QUALIFIER::DeviceScan::InclusiveSum(nullptr, bytes, values, out, items, stream_), "scan"))
    return;
  void* const space = scratch(bytes);
  if (space != nullptr)
    check(CUB_NS_QUALIFIER::DeviceScan::InclusiveSum(space, bytes, values, out, items, stream_), "scan");
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
