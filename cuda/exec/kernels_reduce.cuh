// SPDX-License-Identifier: Apache-2.0
// Kernels of reduce and gather_reduce, such as the result of a sub-step.
#pragma once

#include "exec/kernels_gather.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace kernels {

// As many blocks as an H200 runs at once are all there are: a second wave would pay the combining of a block again.
inline constexpr unsigned reduce_block = 128;
inline constexpr unsigned reduce_multiprocessors = 132;
inline constexpr unsigned reduce_most_resident = 8;
inline constexpr std::uint64_t reduce_blocks = reduce_most_resident * reduce_multiprocessors;  // most blocks
inline constexpr std::size_t reduce_item = 112;  // largest result of a reduction, bytes
inline constexpr std::size_t handing_item = 64;  // of gather_reduce

/// r of the lane `offset` further up.
template <class R>
__device__ R from_lane_above(const R& r, unsigned offset) {
  static_assert(sizeof(R) % sizeof(unsigned) == 0);
  constexpr unsigned words = sizeof(R) / sizeof(unsigned);
  R other;
  unsigned* const to = reinterpret_cast<unsigned*>(&other);
  const unsigned* const from = reinterpret_cast<const unsigned*>(&r);
#pragma unroll
  for (unsigned k = 0; k < words; ++k) to[k] = __shfl_down_sync(~0u, from[k], offset);
  return other;
}

/// Combines the values of a block, in an order that depends on nothing; thread 0 gets the result.
template <class R>
__device__ R combine_block(R r) {
  constexpr unsigned warps = reduce_block / 32;
  // Raw bytes: shared variables may not have constructors.
  __shared__ alignas(16) unsigned char raw[warps * sizeof(R)];
  R* const of_warp = reinterpret_cast<R*>(raw);
  for (unsigned offset = 16; offset != 0; offset /= 2) r = R::combine(r, from_lane_above(r, offset));
  __syncthreads();  // of_warp may still be read from the call before
  if (threadIdx.x % 32 == 0) of_warp[threadIdx.x / 32] = r;
  __syncthreads();
  if (threadIdx.x == 0) {
    for (unsigned k = 1; k < warps; ++k) r = R::combine(r, of_warp[k]);
  }
  return r;
}

/// Stores the result of this block, which thread 0 has. True in all threads of the last block to do so. `ticket` counts the
/// blocks that have, and is 0 again afterwards.
template <class R>
__device__ bool hand_in(const R& r, R* partial, unsigned* ticket) {
  __shared__ bool is_last;
  if (threadIdx.x == 0) {
    partial[blockIdx.x] = r;
    __threadfence();
    is_last = atomicInc(ticket, gridDim.x - 1u) == gridDim.x - 1u;
  }
  __syncthreads();
  if (is_last) __threadfence();
  return is_last;
}

/// Results of all blocks, combined in their order; in thread 0 of the last block.
template <class R>
__device__ R combine_handed_in(const R* partial) {
  // All loads first, where there are registers for them: one wait, not one per round.
  constexpr unsigned fit = 256 / sizeof(R), together = fit < 1 ? 1 : fit < 5 ? fit : 5;
  R r{};
  for (unsigned first = threadIdx.x; first < gridDim.x; first += together * reduce_block) {
    R handed_in[together];
#pragma unroll
    for (unsigned k = 0; k < together; ++k)
      if (first + k * reduce_block < gridDim.x) handed_in[k] = partial[first + k * reduce_block];
#pragma unroll
    for (unsigned k = 0; k < together; ++k) r = R::combine(r, handed_in[k]);
  }
  return combine_block(r);
}

/// Blocks of a reduction on a multiprocessor.
template <class Body>
inline constexpr unsigned reduce_resident = resident<Body>::warps(1u) != 0u
                                                ? resident<Body>::warps(1u) * 32 / reduce_block
                                                : 4u;

/// This thread's share of a reduction. Where the body says how, it reads the next item while it works on one: a
/// compiler otherwise moves loads into the branches that use them, each with a wait of its own.
template <class R, class Body>
__device__ bool reduce_share(const std::uint32_t* guard, std::uint64_t n, const Body& body, R& r) {
  const std::uint64_t stride = static_cast<std::uint64_t>(gridDim.x) * reduce_block;
  std::uint64_t i = index();
  if constexpr (reads_ahead<Body>::value) {
    typename Body::Item next{};
    if (i < n) next = body.read(i);  // ahead of the guard: one wait for both
    if (stopped(guard)) return false;
    for (; i < n; i += stride) {
      const typename Body::Item item = next;
      if (i + stride < n) next = body.read(i + stride);
      r = R::combine(r, body(i, item, CudaAdder{}));
    }
  } else {
    if (stopped(guard)) return false;
    for (; i < n; i += stride) r = R::combine(r, body(i));
  }
  return true;
}

/// Every block combines its share; the last one to finish combines theirs, in their order.
template <class R, class Body, class Last>
__global__ void __launch_bounds__(reduce_block, reduce_resident<Body>)
    reduce(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body, R* partial,
           unsigned* ticket, R* out, const __grid_constant__ Last last) {
  R r{};
  if (!reduce_share(guard, n, body, r)) return;
  r = combine_block(r);
  if (!hand_in(r, partial, ticket)) return;
  r = combine_handed_in(partial);
  if (threadIdx.x != 0) return;
  *out = r;
  last(r);
}

/// Combines the values of a warp; lane 0 gets the result.
template <class R>
__device__ R combine_warp(R r) {
  for (unsigned offset = 16; offset != 0; offset /= 2) r = R::combine(r, from_lane_above(r, offset));
  return r;
}

// Places for the results of the warps of a gather_reduce, by turns. A thread for each combines them: 32 take
// 2 us, 512 take 4, but where 31,250 warps come within 30 us, 32 places take as long again.
inline constexpr unsigned handing_places = 512, few_places = 32;

/// gather whose results are combined: within a warp, then by atomics. No block waits: one that did, for
/// its writes to arrive, would keep its place from the next.
template <unsigned Parts, class R, class Body>
__global__ void __launch_bounds__(gather_block<Parts>, resident_blocks<Parts, Body>)
    gather_reduce(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body, R* places,
                  unsigned* locks, unsigned places_used) {
  if (stopped(guard)) return;
  std::uint64_t i;
  typename Body::Sum sum{};
  using Item = typename Body::Item;
  decltype(body.finish(i, sum, Item{}, CudaAdder{})) one{};
  if (gathered<Parts>(n, body, i, sum)) one = body.finish(i, sum, ahead(body.read(i)), CudaAdder{});
  if (Parts != 1 && threadIdx.x >= 32) return;  // the first warp has the sums
  const unsigned place = (blockIdx.x * (Parts == 1 ? block / 32 : 1u) + threadIdx.x / 32) % places_used;
  if (__all_sync(~0u, one.plain()) != 0) {
    const R r = one.over(WarpLanes{});
    if (threadIdx.x % 32 == 0) r.hand_in(places[place], CudaAtomics{});
    return;
  }
  const R r = combine_warp(one.result());  // once in the life of a World
  if (threadIdx.x % 32 != 0) return;
  while (atomicCAS(locks + place, 0u, 1u) != 0u) {
  }
  __threadfence();
  places[place] = R::combine(r, places[place]);
  __threadfence();
  atomicExch(locks + place, 0u);
}

/// Combines the results of all warps and clears their places for the next launch. One block.
template <class R, class Last>
__global__ void __launch_bounds__(handing_places)
    combine_places(const std::uint32_t* guard, R* places, R* out, const __grid_constant__ Last last) {
  R r = places[threadIdx.x];
  if (stopped(guard)) return;
  places[threadIdx.x] = R{};
  const unsigned warps = blockDim.x / 32;
  // Raw bytes: shared variables may not have constructors.
  __shared__ alignas(16) unsigned char raw[handing_places / 32 * sizeof(R)];
  R* const of_warp = reinterpret_cast<R*>(raw);
  r = combine_warp(r);
  if (threadIdx.x % 32 == 0) of_warp[threadIdx.x / 32] = r;
  __syncthreads();
  if (threadIdx.x >= 32) return;
  r = combine_warp(threadIdx.x < warps ? of_warp[threadIdx.x] : R{});
  if (threadIdx.x != 0) return;
  *out = r;
  last(r);
}

}  // namespace kernels
}  // namespace core
}  // namespace v0
}  // namespace meltsim
