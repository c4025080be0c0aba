// SPDX-License-Identifier: Apache-2.0
// CudaExec::bucket: a counting sort. Ranks within a bucket come from atomics, in any order. Include it where a stage
// buckets.
#pragma once

#include "core/exec_cuda.cuh"

namespace meltsim {
inline namespace v0 {
namespace core {

namespace kernels {

template <class Body>
struct CountBody {
  Body body;
  std::uint32_t *bucket_of, *counts, *rank;
  __device__ void operator()(std::uint64_t i) const {
    const std::uint32_t b = body(i);
    bucket_of[i] = b;
    // Items side by side mostly share a bucket: one addition for all of a warp that do.
    const unsigned here = __activemask(), alike = __match_any_sync(here, b);
    const unsigned lane = threadIdx.x % 32u,
                   first = static_cast<unsigned>(__ffs(static_cast<int>(alike))) - 1u;
    std::uint32_t before = 0;
    if (lane == first) before = atomicAdd(counts + b, static_cast<unsigned>(__popc(alike)));
    before = __shfl_sync(alike, before, static_cast<int>(first));
    rank[i] = before + static_cast<unsigned>(__popc(alike & ((1u << lane) - 1u)));
  }
};

struct PlaceBody {
  const std::uint32_t *bucket_of, *begin, *rank;
  std::uint32_t *order, *counts;
  __device__ void operator()(std::uint64_t i) const {
    const std::uint32_t b = bucket_of[i];
    order[begin[b] + rank[i]] = static_cast<std::uint32_t>(i);
    counts[b] = 0u;  // for the next time: a memset ahead of the counting is a node more in a graph
  }
};

}  // namespace kernels

template <class Body>
void CudaExec::bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
                      std::uint32_t* begin, std::uint32_t* order, std::uint32_t* scratch,
                      std::uint32_t* counts) const {
  if (n == 0) return;
  for_each(n, kernels::CountBody<Body>{body, bucket_of, counts, scratch});
  sum_before(std::uint64_t{m} + 1, counts, begin);
  for_each(n, kernels::PlaceBody{bucket_of, begin, scratch, order, counts});
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
