// SPDX-License-Identifier: Apache-2.0
// MELTSIM_HD marks functions that compile for the host and for the device; bit operations for both.
#pragma once

#if defined(__CUDACC__)
#define MELTSIM_HD __host__ __device__ __forceinline__
#else
#define MELTSIM_HD inline
#endif

#include <cstdint>

namespace meltsim {
inline namespace v0 {

/// Whether the code runs on a device, where threads of a warp execute both sides of a divergent branch.
MELTSIM_HD constexpr bool on_device() {
#if defined(__CUDA_ARCH__)
  return true;
#else
  return false;
#endif
}
/// Index of the lowest set bit; v must not be 0.
MELTSIM_HD int lowest_bit(std::uint32_t v) {
#if defined(__CUDA_ARCH__)
  return __clz(static_cast<int>(__brev(v)));  // two instructions; __ffs takes five
#else
  return __builtin_ctz(v);
#endif
}

/// The larger of two values; on a device NaN if either is NaN. One instruction on a device, where a comparison and a
/// selection are two.
MELTSIM_HD float larger(float a, float b) {
#if defined(__CUDA_ARCH__)
  float r;
  asm("max.NaN.f32 %0, %1, %2;" : "=f"(r) : "f"(a), "f"(b));
  return r;
#else
  return a < b ? b : a;
#endif
}
MELTSIM_HD float smaller(float a, float b) {  ///< the smaller of two values, likewise
#if defined(__CUDA_ARCH__)
  float r;
  asm("min.NaN.f32 %0, %1, %2;" : "=f"(r) : "f"(a), "f"(b));
  return r;
#else
  return b < a ? b : a;
#endif
}

/// 1 if v is below 0 (or -0), otherwise 0, without a comparison.
MELTSIM_HD std::uint32_t sign_bit(float v) {
#if defined(__CUDA_ARCH__)
  return __float_as_uint(v) >> 31;
#else
  return __builtin_signbit(v) != 0 ? 1u : 0u;
#endif
}
MELTSIM_HD std::uint32_t sign_bit(double v) {  ///< likewise
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__double2hiint(v)) >> 31;
#else
  return __builtin_signbit(v) != 0 ? 1u : 0u;
#endif
}

/// The product a b, in double not fused with a following addition, so that kernels that compute the same sum give the same
/// bits whatever else they contain. In float the compiler fuses alike in all kernels, which tests/world/water_test.cpp
/// checks, and fused operations are faster.
MELTSIM_HD float product(float a, float b) { return a * b; }
MELTSIM_HD double product(double a, double b) {  ///< likewise
#if defined(__CUDA_ARCH__)
  return __dmul_rn(a, b);
#else
  return a * b;
#endif
}

/// max(1 - x k, 0), for x k >= 0. One instruction on a device, where NaN becomes 0, except in MELTSIM_REPRODUCIBLE
/// builds.
MELTSIM_HD float falling(float x, float k) {
#if defined(__CUDA_ARCH__) && !defined(MELTSIM_REPRODUCIBLE)
  float r;
  asm("fma.rn.ftz.sat.f32 %0, %1, %2, %3;" : "=f"(r) : "f"(-x), "f"(k), "f"(1.0f));
  return r;
#else
  return larger(1.0f - x * k, 0.0f);
#endif
}
MELTSIM_HD double falling(double x, double k) {  ///< likewise
  const double v = 1 - x * k;
  return v < 0 ? 0 : v;
}

/// The bits in reverse order.
MELTSIM_HD std::uint32_t reversed(std::uint32_t v) {
#if defined(__CUDA_ARCH__)
  return __brev(v);
#else
  v = (v >> 16) | (v << 16);
  v = ((v >> 8) & 0x00ff00ffu) | ((v & 0x00ff00ffu) << 8);
  v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
  v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
  return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
#endif
}

/// Index of the lowest set bit; v must not be 0. The instruction depends on the compiler.
MELTSIM_HD int lowest_bit(std::uint64_t v) {
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(v)) - 1;
#else
  return __builtin_ctzll(v);
#endif
}
MELTSIM_HD int highest_bit(std::uint32_t v) {  ///< index of the highest set bit; v must not be 0
#if defined(__CUDA_ARCH__)
  return 31 - __clz(static_cast<int>(v));
#else
  return 31 - __builtin_clz(v);
#endif
}
/// The n lowest bits set, n < 32. One instruction on a device.
MELTSIM_HD std::uint32_t bits_below(std::uint32_t n) {
#if defined(__CUDA_ARCH__)
  std::uint32_t mask;
  asm("bmsk.clamp.b32 %0, %1, %2;" : "=r"(mask) : "r"(0u), "r"(n));
  return mask;
#else
  return (1u << n) - 1u;
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
MELTSIM_HD std::uint32_t popcount(std::uint32_t v) {  ///< number of set bits
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__popc(static_cast<int>(v)));
#else
  v = v - ((v >> 1) & 0x55555555u);  // not every x86-64 has an instruction for it
  v = (v & 0x33333333u) + ((v >> 2) & 0x33333333u);
  return (((v + (v >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24;
#endif
}
MELTSIM_HD int highest_bit(std::uint64_t v) {  ///< index of the highest set bit; v must not be 0
#if defined(__CUDA_ARCH__)
  return 63 - __clzll(static_cast<long long>(v));
#else
  return 63 - __builtin_clzll(v);
#endif
}

}  // namespace v0
}  // namespace meltsim
