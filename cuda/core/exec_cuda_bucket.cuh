// SPDX-License-Identifier: Apache-2.0
// CudaExec::bucket: a counting sort. Ranks within a bucket come from atomics, in any order; a last pass puts
// every bucket in order, so that the result does not depend on them. Include it where a stage buckets.
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
  std::uint32_t* placed;
  __device__ void operator()(std::uint64_t i) const {
    placed[begin[bucket_of[i]] + rank[i]] = static_cast<std::uint32_t>(i);
  }
};

/// Where an item belongs in its bucket: after those with smaller indices. Buckets are cells, a dozen items
/// each; the last one holds what was removed, any number, in no order.
struct SettleRankBody {
  const std::uint32_t *bucket_of, *begin, *placed;
  std::uint32_t* order;
  std::uint32_t last;
  __device__ void operator()(std::uint64_t k) const {
    const std::uint32_t item = placed[k], b = bucket_of[item];
    std::uint32_t to = static_cast<std::uint32_t>(k);
    if (b != last) {
      const std::uint32_t end = begin[b + 1];
      to = begin[b];
      for (std::uint32_t other = to; other < end; ++other) to += placed[other] < item ? 1u : 0u;
    }
    order[to] = item;
  }
};

}  // namespace kernels

template <class Body>
void CudaExec::bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
                      std::uint32_t* begin, std::uint32_t* order, std::uint32_t* scratch) const {
  if (n == 0) return;
  zero(begin, (std::uint64_t{m} + 1) * sizeof *begin);
  for_each(n, kernels::CountBody<Body>{body, bucket_of, begin + 1, order});
  running_sum(m, begin + 1);
  for_each(n, kernels::PlaceBody{bucket_of, begin, order, scratch});
  for_each(n, kernels::SettleRankBody{bucket_of, begin, scratch, order, m - 1});
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
