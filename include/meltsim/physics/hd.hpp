// SPDX-License-Identifier: Apache-2.0
// The one annotation header: marks functions that compile for the host and for the device.
#pragma once

#if defined(__CUDACC__)
#define MELTSIM_HD __host__ __device__ __forceinline__
#else
#define MELTSIM_HD inline
#endif

#include <cstdint>

namespace meltsim {
inline namespace v0 {

/// Whether this runs on a device, where neighbouring threads take the same branch or pay for both.
MELTSIM_HD constexpr bool on_device() {
#if defined(__CUDA_ARCH__)
  return true;
#else
  return false;
#endif
}

MELTSIM_HD int lowest_bit(std::uint32_t v) {
#if defined(__CUDA_ARCH__)
  return __clz(static_cast<int>(__brev(v)));  // two instructions; by way of __ffs five
#else
  return __builtin_ctz(v);
#endif
}

/// Index of the lowest and of the highest set bit; v must not be 0. The instruction differs by compiler.
MELTSIM_HD int lowest_bit(std::uint64_t v) {
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(v)) - 1;
#else
  return __builtin_ctzll(v);
#endif
}
/// Number of set bits.
MELTSIM_HD std::uint32_t popcount(std::uint64_t v) {
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__popcll(static_cast<long long>(v)));
#else
  return static_cast<std::uint32_t>(__builtin_popcountll(v));
#endif
}
MELTSIM_HD int highest_bit(std::uint64_t v) {
#if defined(__CUDA_ARCH__)
  return 63 - __clzll(static_cast<long long>(v));
#else
  return 63 - __builtin_clzll(v);
#endif
}

}  // namespace v0
}  // namespace meltsim
