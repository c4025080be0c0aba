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

/// The larger and the smaller of two, or a NaN if one is. One instruction on a device; comparing and selecting
/// takes two.
MELTSIM_HD float larger(float a, float b) {
#if defined(__CUDA_ARCH__)
  float r;
  asm("max.NaN.f32 %0, %1, %2;" : "=f"(r) : "f"(a), "f"(b));
  return r;
#else
  return a < b ? b : a;
#endif
}
MELTSIM_HD float smaller(float a, float b) {
#if defined(__CUDA_ARCH__)
  float r;
  asm("min.NaN.f32 %0, %1, %2;" : "=f"(r) : "f"(a), "f"(b));
  return r;
#else
  return b < a ? b : a;
#endif
}

/// 1 where v is below 0 (or -0), else 0, without a comparison.
MELTSIM_HD std::uint32_t sign_bit(float v) {
#if defined(__CUDA_ARCH__)
  return __float_as_uint(v) >> 31;
#else
  return __builtin_signbit(v) != 0 ? 1u : 0u;
#endif
}
MELTSIM_HD std::uint32_t sign_bit(double v) {
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__double2hiint(v)) >> 31;
#else
  return __builtin_signbit(v) != 0 ? 1u : 0u;
#endif
}

/// a b, not fused with what it is added to, so that kernels that make the same sum make the same bits, whatever else
/// they hold. Only of doubles: of floats the compiler fuses the same in all of them, which tests hold it to
/// (tests/world/water_test.cpp), and fused they are 1 % of a step faster.
MELTSIM_HD float product(float a, float b) { return a * b; }
MELTSIM_HD double product(double a, double b) {
#if defined(__CUDA_ARCH__)
  return __dmul_rn(a, b);
#else
  return a * b;
#endif
}

/// max(1 - x k, 0), x k not below 0. One instruction on a device, where a NaN becomes 0; not in builds that fuse
/// nothing.
MELTSIM_HD float falling(float x, float k) {
#if defined(__CUDA_ARCH__) && !defined(MELTSIM_REPRODUCIBLE)
  float r;
  asm("fma.rn.ftz.sat.f32 %0, %1, %2, %3;" : "=f"(r) : "f"(-x), "f"(k), "f"(1.0f));
  return r;
#else
  return larger(1.0f - x * k, 0.0f);
#endif
}
MELTSIM_HD double falling(double x, double k) {
  const double v = 1 - x * k;
  return v < 0 ? 0 : v;
}

/// Bits in the reverse order.
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

/// Index of the lowest and of the highest set bit; v must not be 0. The instruction differs by compiler.
MELTSIM_HD int lowest_bit(std::uint64_t v) {
#if defined(__CUDA_ARCH__)
  return __ffsll(static_cast<long long>(v)) - 1;
#else
  return __builtin_ctzll(v);
#endif
}
MELTSIM_HD int highest_bit(std::uint32_t v) {
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
MELTSIM_HD std::uint32_t popcount(std::uint32_t v) {
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__popc(static_cast<int>(v)));
#else
  v = v - ((v >> 1) & 0x55555555u);  // an instruction of its own not every x86-64 has
  v = (v & 0x33333333u) + ((v >> 2) & 0x33333333u);
  return (((v + (v >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24;
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
