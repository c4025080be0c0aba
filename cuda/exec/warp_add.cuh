// SPDX-License-Identifier: Apache-2.0
// Exact integer sums from many threads. Thousands of neighbours adding to one address would queue there, so a
// warp whose lanes all add to the same one adds up first and sends a single sum. Integers: no order matters.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <nv/target>

namespace meltsim {
inline namespace v0 {
namespace core {
namespace kernels {

__device__ inline void add_one(std::int64_t* address, std::int64_t value) {
  atomicAdd(reinterpret_cast<unsigned long long*>(address), static_cast<unsigned long long>(value));
}

/// Sum over the lanes in `lanes`, modulo 2^64. The hardware sums 32-bit words: three parts of 22, 22 and 20
/// bits, so that 32 of them fit.
__device__ inline std::uint64_t sum_lanes(unsigned lanes, std::uint64_t v) {
  std::uint64_t low = v & 0x3fffffu, middle = (v >> 22) & 0x3fffffu, high = v >> 44;
  NV_IF_TARGET(NV_PROVIDES_SM_80, (low = __reduce_add_sync(lanes, static_cast<unsigned>(low));
                                   middle = __reduce_add_sync(lanes, static_cast<unsigned>(middle));
                                   high = __reduce_add_sync(lanes, static_cast<unsigned>(high));))
  return low + (middle << 22) + (high << 44);
}

/// Sum over a whole warp.
__device__ inline unsigned sum_of_warp(unsigned v) {
  NV_IF_ELSE_TARGET(
      NV_PROVIDES_SM_80, (v = __reduce_add_sync(~0u, v);),
      (for (unsigned offset = 16; offset != 0; offset /= 2) v += __shfl_xor_sync(~0u, v, offset);))
  return v;
}

/// The largest over a whole warp.
__device__ inline unsigned largest_of_warp(unsigned v) {
  NV_IF_ELSE_TARGET(
      NV_PROVIDES_SM_80, (v = __reduce_max_sync(~0u, v);),
      (for (unsigned offset = 16; offset != 0; offset /= 2) v = max(v, __shfl_xor_sync(~0u, v, offset));))
  return v;
}

/// Reductions over a whole warp for combined results (ParticleCheck::over).
struct WarpLanes {
  /// For non-negative numbers, whose bits are ordered like their values.
  __host__ __device__ float largest(float v) const {
    NV_IF_TARGET(NV_IS_DEVICE, (v = __uint_as_float(largest_of_warp(__float_as_uint(v)));))
    return v;
  }
  __host__ __device__ double largest(double v) const {
    NV_IF_TARGET(
        NV_IS_DEVICE,
        (const auto bits = static_cast<unsigned long long>(__double_as_longlong(v));
         const auto high = static_cast<unsigned>(bits >> 32); const unsigned most = largest_of_warp(high);
         const unsigned low = largest_of_warp(high == most ? static_cast<unsigned>(bits) : 0u);
         v = __hiloint2double(static_cast<int>(most), static_cast<int>(low));))
    return v;
  }
  __host__ __device__ std::uint32_t sum(std::uint32_t v) const {
    NV_IF_TARGET(NV_IS_DEVICE, (v = sum_of_warp(v);))
    return v;
  }
};

__device__ inline void add_together(std::int64_t* address, std::int64_t value) {
  const unsigned lanes = __activemask();
  int same = 0;
  __match_all_sync(lanes, reinterpret_cast<unsigned long long>(address), &same);
  if (same == 0) {
    add_one(address, value);
    return;
  }
  const std::uint64_t sum = sum_lanes(lanes, static_cast<std::uint64_t>(value));
  if ((threadIdx.x & 31u) == static_cast<unsigned>(__ffs(static_cast<int>(lanes)) - 1))
    add_one(address, static_cast<std::int64_t>(sum));
}

/// Lanes with the same counter as this one; the first of them adds for all.
struct Alike {
  unsigned lanes, rank;
  bool first;
};
__device__ inline Alike alike(std::uint32_t which) {
  const unsigned lanes = __match_any_sync(__activemask(), which), lane = threadIdx.x & 31u;
  const auto rank = static_cast<unsigned>(__popc(lanes & ((1u << lane) - 1u)));
  return {lanes, rank, rank == 0u};
}

__device__ inline void count_together(std::uint32_t* counters, std::uint32_t which) {
  const Alike a = alike(which);
  if (a.first) atomicAdd(counters + which, static_cast<unsigned>(__popc(a.lanes)));
}

/// Counts down; what is left, another for everyone.
__device__ inline std::uint32_t count_down_together(std::uint32_t* counters, std::uint32_t which) {
  const Alike a = alike(which);
  const auto many = static_cast<std::uint32_t>(__popc(a.lanes));
  std::uint32_t left = 0;
  if (a.first) left = atomicSub(counters + which, many) - many;
  return __shfl_sync(a.lanes, left, __ffs(static_cast<int>(a.lanes)) - 1) + a.rank;
}

}  // namespace kernels

/// Atomics by which a result is added to a shared one (CheckResult::hand_in).
struct CudaAtomics {
  /// For non-negative numbers, whose bits are ordered like their values.
  __host__ __device__ void raise(double& x, double v) const {
    NV_DISPATCH_TARGET(NV_IS_DEVICE,
                       (atomicMax(reinterpret_cast<unsigned long long*>(&x),
                                  static_cast<unsigned long long>(__double_as_longlong(v)));),
                       NV_ANY_TARGET, (x = x < v ? v : x;))
  }
  __host__ __device__ void add(std::uint64_t& x, std::uint64_t n) const {
    NV_DISPATCH_TARGET(
        NV_IS_DEVICE,
        (atomicAdd(reinterpret_cast<unsigned long long*>(&x), static_cast<unsigned long long>(n));),
        NV_ANY_TARGET, (x += n;))
  }
  __host__ __device__ void add(std::uint32_t& x, std::uint32_t n) const {
    NV_DISPATCH_TARGET(NV_IS_DEVICE, (atomicAdd(&x, n);), NV_ANY_TARGET, (x += n;))
  }
};

/// Called by bodies that compile for the host, too, hence the annotation; the host has core::CpuAdder.
struct CudaAdder {
  __host__ __device__ void operator()(std::int64_t* address, std::int64_t value) const {
    NV_DISPATCH_TARGET(NV_PROVIDES_SM_80, (kernels::add_together(address, value);),  //
                       NV_IS_DEVICE, (kernels::add_one(address, value);),            //
                       NV_ANY_TARGET, (*address += value;))
  }
  /// ++counters[which]
  __host__ __device__ void count(std::uint32_t* counters, std::uint32_t which) const {
    NV_DISPATCH_TARGET(NV_IS_DEVICE, (kernels::count_together(counters, which);),  //
                       NV_ANY_TARGET, (++counters[which];))
  }
  /// *address = min(*address, value); what was there.
  __host__ __device__ std::uint32_t lower(std::uint32_t* address, std::uint32_t value) const {
    std::uint32_t was = *address;
    NV_DISPATCH_TARGET(NV_IS_DEVICE, (was = atomicMin(address, value);),  //
                       NV_ANY_TARGET, (*address = was < value ? was : value;))
    return was;
  }
  __host__ __device__ std::uint32_t load(const std::uint32_t* address) const {
    return *const_cast<const volatile std::uint32_t*>(address);
  }
  /// Bits of *address.
  __host__ __device__ void set(std::uint32_t* address, std::uint32_t bits) const {
    NV_DISPATCH_TARGET(NV_IS_DEVICE, (atomicOr(address, bits);), NV_ANY_TARGET, (*address |= bits;))
  }
  __host__ __device__ void clear(std::uint32_t* address, std::uint32_t bits) const {
    NV_DISPATCH_TARGET(NV_IS_DEVICE, (atomicAnd(address, ~bits);), NV_ANY_TARGET, (*address &= ~bits;))
  }
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
