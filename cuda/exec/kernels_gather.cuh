// SPDX-License-Identifier: Apache-2.0
// Kernels of gather, gather_adding, gather_two, select and gather_listed: sums over neighbours.
#pragma once

#include "exec/kernels_each.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace kernels {

// Warp k of a block takes part k of the sums of 32 items.
inline constexpr unsigned gather_items = 32;

/// Which of the blocks' shares this block takes: those at both ends of the order first, for bodies that ask
/// for it.
template <class Body>
__device__ unsigned share_of_block() {
  if constexpr (ends_first<Body>::value) {
    const unsigned half = blockIdx.x / 2u;
    return blockIdx.x % 2u == 0u ? half : gridDim.x - 1u - half;
  } else {
    return blockIdx.x;
  }
}

/// body.part of all parts, added up in the first warp. True in threads that hold the sum of an item.
template <unsigned Parts, class Body>
__device__ bool gathered(std::uint64_t n, const Body& body, std::uint64_t& i, typename Body::Sum& sum) {
  using Sum = typename Body::Sum;
  if constexpr (Parts == 1) {
    i = index();
    if (i < n) sum = sum_of(body, i, 1);
    return i < n;
  } else {
    // Raw bytes: shared variables may not have constructors.
    __shared__ alignas(16) unsigned char raw[(Parts - 1) * gather_items * sizeof(Sum)];
    Sum* const others = reinterpret_cast<Sum*>(raw);
    const unsigned lane = threadIdx.x % gather_items, part = threadIdx.x / gather_items;
    i = std::uint64_t{share_of_block<Body>()} * gather_items + lane;
    if (i < n) sum = body.part(i, part, Parts);
    if constexpr (joins<Body>::value) {
      __syncthreads();
      if (part == 0 && i < n) body.join(i);
      __syncthreads();
      if (i < n) body.more(i, part, Parts, sum);
    }
    if (part != 0) others[(part - 1) * gather_items + lane] = sum;
    __syncthreads();
    if (part != 0 || i >= n) return false;
    for (unsigned k = 0; k + 1 < Parts; ++k) sum.add(others[k * gather_items + lane]);
    return true;
  }
}

template <unsigned Parts>
inline constexpr unsigned gather_block = Parts == 1 ? block : Parts* gather_items;

/// Blocks that are to be in place at once; 0: as many as there are registers for.
template <unsigned Parts, class Body>
inline constexpr unsigned resident_blocks = resident<Body>::warps(Parts) * 32 / gather_block<Parts>;

template <unsigned Parts, class Body>
__global__ void __launch_bounds__(gather_block<Parts>, resident_blocks<Parts, Body>)
    gather(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body) {
  if (stopped(guard)) return;
  std::uint64_t i;
  typename Body::Sum sum{};
  if (gathered<Parts>(n, body, i, sum)) body.finish(i, sum);
}

template <unsigned Parts, class Body>
__global__ void __launch_bounds__(gather_block<Parts>, resident_blocks<Parts, Body>)
    gather_adding(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body) {
  if (stopped(guard)) return;
  std::uint64_t i;
  typename Body::Sum sum{};
  if (gathered<Parts>(n, body, i, sum)) body.finish(i, sum, CudaAdder{});
}

/// Puts the sums of items whose work is unfinished, `more` of the two of a thread, into a list of the block. All threads of a warp call it.
template <class Sum>
__device__ __forceinline__ void set_aside(std::uint64_t i, const bool (&more)[2], const Sum (&sum)[2],
                                          Sum* sums, std::uint32_t* unfinished, unsigned* all) {
  const unsigned have[2] = {__ballot_sync(~0u, more[0]), __ballot_sync(~0u, more[1])};
  if ((have[0] | have[1]) == 0u) return;
  const unsigned lane = threadIdx.x % 32u, below = (1u << lane) - 1u;
  unsigned at = 0;
  if (lane == 0) at = atomicAdd(all, static_cast<unsigned>(__popc(have[0]) + __popc(have[1])));
  at = __shfl_sync(~0u, at, 0) + static_cast<unsigned>(__popc(have[0] & below) + __popc(have[1] & below));
#pragma unroll
  for (unsigned k = 0; k < 2u; ++k) {
    if (!more[k]) continue;
    sums[at] = sum[k];
    unfinished[at++] = static_cast<std::uint32_t>(i) + k;
  }
}

/// Sums of two items per thread at once; items left over come first. The remaining work of some items is shared out
/// anew among the threads of the block, one item to each, in order: else a warp whose first half has it would go through
/// it twice.
template <class Body>
__global__ void __launch_bounds__(block, Body::resident_warps_of_two * 32 / block)
    gather_two(const std::uint32_t* guard, std::uint64_t n, unsigned blocks_left_over,
               std::uint64_t left_over, const __grid_constant__ Body body) {
  using Sum = typename Body::Sum;
  __shared__ std::uint32_t unfinished[2 * block];
  // Raw bytes: shared variables may not have constructors.
  __shared__ alignas(16) unsigned char raw[2 * block * sizeof(Sum)];
  __shared__ unsigned all_unfinished;
  Sum* const sums = reinterpret_cast<Sum*>(raw);
  if (stopped(guard)) return;
  if (threadIdx.x == 0) all_unfinished = 0;
  __syncthreads();
  const bool alone = blockIdx.x < blocks_left_over;
  std::uint64_t i = n;
  if (!alone) i = 2u * (index() - std::uint64_t{blocks_left_over} * block);
  else if (index() < left_over) i = body.left_over(index());
  std::uint32_t count = 0;
  Sum sum[2]{};
  if (i < n) count = body.two(i, alone, sum);
  bool more[2] = {false, false};
#pragma unroll
  for (unsigned k = 0; k < 2u; ++k) {
    if (k >= count) continue;
    more[k] = body.unfinished(i + k);
    if (!more[k]) body.finish(i + k, sum[k]);
  }
  set_aside(i, more, sum, sums, unfinished, &all_unfinished);
  __syncthreads();
  for (unsigned k = threadIdx.x; k < all_unfinished; k += block) {
    Sum s = sums[k];
    body.more(unfinished[k], 0u, 1u, s);
    body.finish(unfinished[k], s);
  }
}

/// list[0] counts, the rest follows in whatever order blocks come.
template <class Body>
__global__ void __launch_bounds__(block) select(const std::uint32_t* guard, std::uint64_t n,
                                                const __grid_constant__ Body body, std::uint32_t* list) {
  __shared__ unsigned first[block / 32];
  if (stopped(guard)) return;
  const std::uint64_t i = index();
  const bool wanted = i < n && body.wanted(i);
  const unsigned lane = threadIdx.x % 32, warp = threadIdx.x / 32;
  const unsigned all = __ballot_sync(~0u, wanted);
  if (lane == 0) first[warp] = static_cast<unsigned>(__popc(all));
  __syncthreads();
  if (threadIdx.x == 0) {
    unsigned total = 0;
    for (unsigned k = 0; k < block / 32; ++k) total += first[k];
    unsigned at = total != 0 ? atomicAdd(list, total) : 0u;
    for (unsigned k = 0; k < block / 32; ++k) {
      const unsigned of_warp = first[k];
      first[k] = at;
      at += of_warp;
    }
  }
  __syncthreads();
  if (wanted)
    list[1 + first[warp] + static_cast<unsigned>(__popc(all & ((1u << lane) - 1u)))] =
        static_cast<std::uint32_t>(i);
}

// Most blocks over a list, per multiprocessor; its length is on the device. Starting a block beyond its end
// costs a nanosecond (8,448 of them 7 us), too few blocks even out less.
inline constexpr unsigned listed_blocks = 16;

template <class Body>
__global__ void __launch_bounds__(listed<Body>::parts* gather_items)
    gather_listed(const std::uint32_t* guard, const std::uint32_t* list, const __grid_constant__ Body body) {
  using Sum = typename Body::Sum;
  constexpr unsigned parts = listed<Body>::parts;
  // Raw bytes: shared variables may not have constructors.
  __shared__ alignas(16) unsigned char raw[(parts - 1) * gather_items * sizeof(Sum)];
  Sum* const others = reinterpret_cast<Sum*>(raw);
  if (stopped(guard)) return;
  const std::uint32_t n = list[0];
  const unsigned lane = threadIdx.x % gather_items, part = threadIdx.x / gather_items;
  for (std::uint32_t first = blockIdx.x * gather_items; first < n; first += gridDim.x * gather_items) {
    const bool mine = first + lane < n;
    const std::uint64_t i = mine ? list[1 + first + lane] : 0u;
    Sum sum{};
    if (mine) sum = body.part(i, part, parts);
    if (part != 0) others[(part - 1) * gather_items + lane] = sum;
    __syncthreads();
    if (part == 0 && mine) {
      for (unsigned k = 0; k + 1 < parts; ++k) sum.add(others[k * gather_items + lane]);
      body.finish(i, sum);
    }
    __syncthreads();
  }
}

}  // namespace kernels
}  // namespace core
}  // namespace v0
}  // namespace meltsim
