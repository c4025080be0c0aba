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
    rank[i] = atomicAdd(counts + b, 1u);
  }
};

struct PlaceBody {
  const std::uint32_t *bucket_of, *begin, *rank;
  std::uint32_t* order;
  __device__ void operator()(std::uint64_t i) const {
    order[begin[bucket_of[i]] + rank[i]] = static_cast<std::uint32_t>(i);
  }
};

}  // namespace kernels

template <class Body>
void CudaExec::bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
                      std::uint32_t* begin, std::uint32_t* order, std::uint32_t* scratch) const {
  if (n == 0) return;
  zero(begin, (std::uint64_t{m} + 1) * sizeof *begin);
  for_each(n, kernels::CountBody<Body>{body, bucket_of, begin + 1, scratch});
  running_sum(m, begin + 1);
  for_each(n, kernels::PlaceBody{bucket_of, begin, scratch, order});
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
