// SPDX-License-Identifier: Apache-2.0
// Kernels of for_each, accumulate, copy and fill, and what all kernels have in common.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "exec/gather.hpp"
#include "exec/warp_add.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace kernels {

// 128: at 60 thousand particles every multiprocessor of a large GPU still gets several blocks.
inline constexpr unsigned block = 128;
inline constexpr unsigned sum_tile = 2048;  // counts whose running sum is one block's

__device__ inline bool stopped(const std::uint32_t* guard) { return guard != nullptr && *guard != 0u; }

__device__ inline std::uint64_t index() {
  return static_cast<std::uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
}

/// Keeps a loaded value where it is: a compiler would move the load behind the next branch.
template <class Item>
__device__ Item ahead(Item item) {
  static_assert(sizeof(Item) % sizeof(unsigned) == 0);
  auto* const words = reinterpret_cast<unsigned*>(&item);
#pragma unroll
  for (unsigned k = 0; k < sizeof(Item) / sizeof(unsigned); ++k) asm volatile("" : "+r"(words[k]));
  return item;
}

// __grid_constant__: bodies carry the whole frame; threads read it where the launch put it, without a copy.
template <class Body>
__global__ void __launch_bounds__(block)
    each(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body) {
  const std::uint64_t i = index();
  if constexpr (reads_ahead<Body>::value) {
    typename Body::Item item{};
    if (i < n) item = ahead(body.read(i));  // of the guard: one wait for both
    if (stopped(guard)) return;
    if (i < n) body(i, item);
  } else {
    if (stopped(guard)) return;
    if (i < n) body(i);
  }
}

// For modest bodies: a few threads of every multiprocessor may have to process all items.
template <class Body>
__global__ void __launch_bounds__(block)
    each_modestly(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body) {
  if (stopped(guard)) return;
  const std::uint64_t stride = static_cast<std::uint64_t>(gridDim.x) * block;
  for (std::uint64_t i = index(); i < n; i += stride) body(i);
}

template <class Body>
__global__ void __launch_bounds__(block)
    each_adding(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body) {
  const std::uint64_t i = index();
  if constexpr (reads_ahead<Body>::value) {
    typename Body::Item item{};
    if (i < n) item = ahead(body.read(i));
    if (stopped(guard)) return;
    if (i < n) body(i, item, CudaAdder{});
  } else {
    if (stopped(guard)) return;
    if (i < n) body(i, CudaAdder{});
  }
}

template <class V>
struct CopyBody {
  const V* from;
  V* to;
  __device__ void operator()(std::uint64_t i) const { to[i] = from[i]; }
};

template <class V>
struct FillBody {
  V value;
  V* to;
  __device__ void operator()(std::uint64_t i) const { to[i] = value; }
};

}  // namespace kernels
}  // namespace core
}  // namespace v0
}  // namespace meltsim
