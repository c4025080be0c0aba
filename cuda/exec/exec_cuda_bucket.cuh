// SPDX-License-Identifier: Apache-2.0
// CudaExec::bucket: a counting sort. Places within a bucket come from atomics, in any order. Include it where a stage
// buckets or begins buckets.
#pragma once

#include <cstdint>
#include <cub/block/block_scan.cuh>

#include "exec/exec_cuda.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {

namespace kernels {

template <class Body>
struct CountBody {
  Body body;
  std::uint32_t *bucket_of, *counts;
  __device__ void operator()(std::uint64_t i) const {
    const std::uint32_t b = body(i);
    bucket_of[i] = b;
    count_together(counts, b);
  }
};

/// Counts run down to 0 meanwhile.
struct PlaceBody {
  const std::uint32_t *bucket_of, *begin;
  std::uint32_t *order, *counts;
  using Item = std::uint32_t;
  __device__ Item read(std::uint64_t i) const { return bucket_of[i]; }
  __device__ void operator()(std::uint64_t i, Item b) const {
    const std::uint32_t first = begin[b];  // under way while the count is
    order[first + count_down_together(counts, b)] = static_cast<std::uint32_t>(i);
  }
};

// Running sums in one launch, by decoupled look-back (Merrill & Garland 2016, Single-pass parallel prefix scan): a block
// publishes the sum of its tile as soon as it has it, then looks back until a block ahead has the sum of all before. CUB's has a
// launch ahead that clears the states of tiles; here a state carries the number of the turn, so that states of the last turn
// are ignored.
inline constexpr unsigned tile_threads = 256, tile_items = sum_tile / tile_threads;
static_assert(tile_items == 8);

/// State of a tile: turn (30 bits), how much the sum covers (2), sum (32).
enum class Known : std::uint32_t { nothing = 0, own = 1, all = 2 };
__device__ inline std::uint64_t told(std::uint32_t turn, Known known, std::uint32_t sum) {
  return static_cast<std::uint64_t>(turn << 2u | static_cast<std::uint32_t>(known)) << 32u | sum;
}

/// Sum of all tiles before this one. One warp.
__device__ inline std::uint32_t look_back(const std::uint64_t* tiles, std::uint32_t turn) {
  const int lane = static_cast<int>(threadIdx.x % 32u);
  std::uint32_t sum = 0;
  for (int first = static_cast<int>(blockIdx.x) - 1;; first -= 32) {
    const int k = first - lane;
    std::uint64_t word = told(turn, Known::all, 0u);  // before the first tile
    std::uint32_t known = 0;
    do {
      if (k >= 0) word = *static_cast<const volatile std::uint64_t*>(tiles + k);
      const auto head = static_cast<std::uint32_t>(word >> 32u);
      known = head >> 2u == (turn & 0x3fffffffu) ? head & 3u : 0u;
    } while (__any_sync(~0u, known == static_cast<std::uint32_t>(Known::nothing)));
    const unsigned all = __ballot_sync(~0u, known == static_cast<std::uint32_t>(Known::all));
    const int nearest = all != 0u ? __ffs(static_cast<int>(all)) - 1 : 31;
    if (lane <= nearest) sum += static_cast<std::uint32_t>(word);
    if (all == 0u) continue;
    for (unsigned offset = 16; offset != 0; offset /= 2) sum += __shfl_xor_sync(~0u, sum, offset);
    return sum;
  }
}

/// The values of a thread from `at` on, of n; beyond, 0.
__device__ __forceinline__ void load_items(const std::uint32_t* values, std::uint32_t at, std::uint32_t n,
                                           std::uint32_t (&v)[tile_items]) {
  if (at + tile_items <= n) {
    const auto* from = reinterpret_cast<const uint4*>(values + at);
    const uint4 low = from[0], high = from[1];
    v[0] = low.x, v[1] = low.y, v[2] = low.z, v[3] = low.w;
    v[4] = high.x, v[5] = high.y, v[6] = high.z, v[7] = high.w;
  } else {
#pragma unroll
    for (unsigned k = 0; k < tile_items; ++k)
      if (at + k < n) v[k] = values[at + k];
  }
}

/// sums[at + k] = before + v[k], of n.
__device__ __forceinline__ void store_items(std::uint32_t* sums, std::uint32_t at, std::uint32_t n,
                                            std::uint32_t before, const std::uint32_t (&v)[tile_items]) {
  if (at + tile_items <= n) {
    auto* to = reinterpret_cast<uint4*>(sums + at);
    to[0] = make_uint4(before + v[0], before + v[1], before + v[2], before + v[3]);
    to[1] = make_uint4(before + v[4], before + v[5], before + v[6], before + v[7]);
  } else {
#pragma unroll
    for (unsigned k = 0; k < tile_items; ++k)
      if (at + k < n) sums[at + k] = before + v[k];
  }
}

/// sums[i] = values[0] + ... + values[i - 1]; and first(0) beside it.
template <class First>
__global__ void __launch_bounds__(tile_threads)
    sum_tiles(const std::uint32_t* guard, std::uint32_t n, const std::uint32_t* values, std::uint32_t* sums,
              std::uint64_t* tiles, std::uint32_t* turn_now, const __grid_constant__ First first) {
  using Scan =
      CUB_NS_QUALIFIER::BlockScan<std::uint32_t, tile_threads, CUB_NS_QUALIFIER::BLOCK_SCAN_WARP_SCANS>;
  __shared__ typename Scan::TempStorage room;
  __shared__ std::uint32_t before_tile;
  const std::uint32_t at = blockIdx.x * sum_tile + threadIdx.x * tile_items;
  const std::uint32_t turn = *turn_now;
  std::uint32_t v[tile_items] = {};
  load_items(values, at, n, v);
  std::uint32_t total = 0, sum = 0;
#pragma unroll
  for (unsigned k = 0; k < tile_items; ++k) {
    const std::uint32_t value = v[k];
    v[k] = sum;
    sum += value;
  }
  std::uint32_t before = 0;
  Scan(room).ExclusiveSum(sum, before, total);
  if (threadIdx.x < 32) {
    auto* const mine = static_cast<volatile std::uint64_t*>(tiles + blockIdx.x);
    if (threadIdx.x == 0) *mine = told(turn, blockIdx.x == 0 ? Known::all : Known::own, total);
    const std::uint32_t ahead = look_back(tiles, turn);
    if (threadIdx.x == 0) {
      if (blockIdx.x != 0) *mine = told(turn, Known::all, ahead + total);
      // All other tiles have published, hence have read it.
      if (blockIdx.x + 1 == gridDim.x) *turn_now = turn + 1u;
      before_tile = ahead;
    }
  }
  __syncthreads();
  store_items(sums, at, n, before + before_tile, v);
  if (blockIdx.x == 0 && threadIdx.x == tile_threads - 1 && !stopped(guard)) first(0);
}

}  // namespace kernels

template <class First>
void CudaExec::begin_buckets(std::uint32_t m, std::uint32_t* counts, std::uint32_t* begin,
                             const First& first) const {
  const std::uint32_t n = m + 1;
  launch(kernels::sum_tiles<First>, blocks(n, kernels::sum_tile), kernels::tile_threads, guard_, n, counts,
         begin, tiles_of(m, counts), turn_of(m, counts), first);
}

inline void CudaExec::fill_buckets(std::uint64_t n, const std::uint32_t* bucket_of,
                                   const std::uint32_t* begin, std::uint32_t* order,
                                   std::uint32_t* counts) const {
  for_each(n, kernels::PlaceBody{bucket_of, begin, order, counts});
}

template <class Body>
void CudaExec::bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
                      std::uint32_t* begin, std::uint32_t* order, std::uint32_t* counts) const {
  if (n == 0) return;
  zero(counts, (std::uint64_t{m} + 1) * sizeof *counts);
  for_each(n, kernels::CountBody<Body>{body, bucket_of, counts});
  begin_buckets(m, counts, begin, Nothing{});
  fill_buckets(n, bucket_of, begin, order, counts);
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
