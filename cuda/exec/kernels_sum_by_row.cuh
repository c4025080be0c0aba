// SPDX-License-Identifier: Apache-2.0
// Kernel of sum_by_row: exact sums per piece of a body.
#pragma once

#include "exec/kernels_each.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace kernels {

// Items per thread of sum_by_row where there are many: a piece of a million vertices then takes 4,000
// additions per sum, and there are blocks enough to hide their waits.
inline constexpr unsigned sum_items = 2;

/// Adds `values` to a row of sums.
template <class Sum>
__device__ __forceinline__ void add_to_row(Sum* rows, std::uint32_t to, const std::int64_t* values) {
  auto* words = reinterpret_cast<std::int64_t*>(rows + to);
  for (int k = 0; k < Sum::words; ++k) add_one(words + k, values[k]);
}

/// Adds the items of a thread to `sum`. Returns their row, `none` without one; a thread between two pieces sends what it has of
/// the second one.
template <unsigned Items, class Body>
__device__ __forceinline__ std::uint32_t sum_of_thread(std::uint64_t n, const Body& body,
                                                       typename Body::Sum* rows,
                                                       std::int64_t (&sum)[Body::Sum::words]) {
  using Sum = typename Body::Sum;
  constexpr std::uint32_t none = 0xffffffffu;
  std::uint32_t row = none;
  for (unsigned k = 0; k < Items; ++k) {
    const std::uint64_t i = (static_cast<std::uint64_t>(blockIdx.x) * Items + k) * block + threadIdx.x;
    if (i >= n) break;
    Sum s;
    const std::uint32_t to = body(i, s);
    if (to == none) continue;
    const std::int64_t* const values = reinterpret_cast<const std::int64_t*>(&s);
    if (row != none && to != row) {
      add_to_row(rows, to, values);
      continue;
    }
    row = to;
    for (int word = 0; word < Sum::words; ++word) sum[word] += values[word];
  }
  return row;
}

template <unsigned Items, class Body>
__global__ void __launch_bounds__(block)
    sum_by_row(const std::uint32_t* guard, std::uint64_t n, const __grid_constant__ Body body,
               typename Body::Sum* rows) {
  using Sum = typename Body::Sum;
  constexpr std::uint32_t none = 0xffffffffu;
  constexpr unsigned warps = block / 32;
  static_assert(Sum::words <= 32);
  __shared__ std::int64_t sums[warps][Sum::words];
  __shared__ std::uint32_t row_of[warps];
  if (stopped(guard)) return;
  std::int64_t sum[Sum::words] = {};
  const std::uint32_t row = sum_of_thread<Items>(n, body, rows, sum);
  // Lanes that have nothing go with the others; a warp of several pieces sends lane by lane.
  const unsigned lane = threadIdx.x % 32, warp = threadIdx.x / 32;
  const unsigned having = __ballot_sync(~0u, row != none);
  const std::uint32_t first = __shfl_sync(~0u, row, having != 0u ? __ffs(static_cast<int>(having)) - 1 : 0);
  const bool alike = __all_sync(~0u, row == none || row == first) != 0;
  if (!alike && row != none) add_to_row(rows, row, sum);
  for (int word = 0; word < Sum::words; ++word) {
    const std::uint64_t total = alike ? sum_lanes(~0u, static_cast<std::uint64_t>(sum[word])) : 0u;
    if (lane == 0) sums[warp][word] = static_cast<std::int64_t>(total);
  }
  if (lane == 0) row_of[warp] = alike ? first : none;
  __syncthreads();
  if (threadIdx.x >= Sum::words) return;
  std::int64_t total = 0;
  for (unsigned k = 0; k < warps; ++k) {
    if (row_of[k] == none) continue;
    total += sums[k][threadIdx.x];
    if (k + 1 < warps && row_of[k + 1] == row_of[k]) continue;
    add_one(reinterpret_cast<std::int64_t*>(rows + row_of[k]) + threadIdx.x, total);
    total = 0;
  }
}

}  // namespace kernels
}  // namespace core
}  // namespace v0
}  // namespace meltsim
