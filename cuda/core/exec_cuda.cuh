// SPDX-License-Identifier: Apache-2.0
// The verbs on CUDA. What each one means is said once, in core/exec_cpu.hpp; here is what differs:
//
//   - Everything is enqueued on one stream, and no verb allocates, waits or reads back, so that a step can be
//     captured into a CUDA graph. Only upload, download, synchronize and (de)allocation wait, and only
//     release(), for which CUDA has no other way, waits for more than this stream.
//   - The guard is read on the device, at the start of every kernel.
//   - reduce asks for a combine that is commutative, too: threads take strided shares. Its shape depends on n
//     alone, so equal inputs give equal bits.
//   - scan is defined in core/exec_cuda_scan.cuh, because CUB's header would cost every stage seconds to
//     compile.
//   - Stages that do not need each other run on streams of their own, which fork from that one and join it
//     again within a sub-step; a capture takes them along.
//   - repeat() captures what is enqueued into a graph, kept by its key, and launches that the next time.
//     Where the host captures the stream itself, or makes it do so, nothing is kept.
//   - Hosts use other devices: every entry selects its own and puts the host's back.
//   - The first error is kept until fault() is asked; nothing is thrown or printed.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>

#include "core/gather.hpp"
#include "core/repeat_key.hpp"
#include "core/timings.hpp"
#include "core/warp_add.cuh"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

namespace kernels {

// 128: at 60 thousand particles every multiprocessor of a large GPU still gets several blocks.
inline constexpr unsigned block = 128;
// As many blocks as an H200 runs at once are all there are: a second wave would pay the combining of a block again.
inline constexpr unsigned reduce_block = 128;
inline constexpr unsigned reduce_multiprocessors = 132;
inline constexpr unsigned reduce_most_resident = 8;
inline constexpr std::uint64_t reduce_blocks = reduce_most_resident * reduce_multiprocessors;  // most blocks
inline constexpr std::size_t reduce_item = 112;  // largest result of a reduction, bytes
inline constexpr std::size_t handing_item = 64;  // of gather_reduce
inline constexpr unsigned sum_tile = 2048;       // counts whose running sum is one block's

__device__ inline bool stopped(const std::uint32_t* guard) { return guard != nullptr && *guard != 0u; }

__device__ inline std::uint64_t index() {
  return static_cast<std::uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
}

/// What has been read, as it is, and not later: a compiler would move it behind the next question.
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

// Those of modest bodies: a few threads of every multiprocessor may have to do for all items.
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

/// Sums of two items per thread at once; first those that are left over. What is left to do for some of them is shared out
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
  const unsigned have[2] = {__ballot_sync(~0u, more[0]), __ballot_sync(~0u, more[1])};
  if ((have[0] | have[1]) != 0u) {
    const unsigned lane = threadIdx.x % 32u, below = (1u << lane) - 1u;
    unsigned at = 0;
    if (lane == 0) at = atomicAdd(&all_unfinished, static_cast<unsigned>(__popc(have[0]) + __popc(have[1])));
    at = __shfl_sync(~0u, at, 0) + static_cast<unsigned>(__popc(have[0] & below) + __popc(have[1] & below));
#pragma unroll
    for (unsigned k = 0; k < 2u; ++k) {
      if (!more[k]) continue;
      sums[at] = sum[k];
      unfinished[at++] = static_cast<std::uint32_t>(i) + k;
    }
  }
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

// Most blocks over a list, per multiprocessor; how long it is, the device knows. Starting a block beyond its end
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

/// Notes what this block has in thread 0. True in all threads where it is the last block to do so. `ticket` counts the
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

/// What the blocks have handed in, combined in their order; in the last block to come, in thread 0.
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

// Places where the warps of a gather_reduce hand in what they have, by turns. A thread for each combines them: 32 take
// 2 us, 512 take 4, but where 31,250 warps come within 30 us, 32 places take as long again.
inline constexpr unsigned handing_places = 512, few_places = 32;

/// gather whose results are combined: within a warp, then by atomics. Nobody waits for anything: a block that did, for
/// what it wrote to arrive, would keep its place from the next.
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

/// What was handed in, which makes room for the next. One block.
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

// Items per thread of sum_by_row where there are many: a piece of a million vertices then takes 4,000
// additions per sum, and there are blocks enough to hide their waits.
inline constexpr unsigned sum_items = 2;

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
  std::uint32_t row = none;
  std::int64_t sum[Sum::words] = {};
  const auto send = [&](std::uint32_t to, const std::int64_t* values) {
    auto* words = reinterpret_cast<std::int64_t*>(rows + to);
    for (int k = 0; k < Sum::words; ++k) add_one(words + k, values[k]);
  };
  for (unsigned k = 0; k < Items; ++k) {
    const std::uint64_t i = (static_cast<std::uint64_t>(blockIdx.x) * Items + k) * block + threadIdx.x;
    if (i >= n) break;
    Sum s;
    const std::uint32_t to = body(i, s);
    if (to == none) continue;
    const std::int64_t* const values = reinterpret_cast<const std::int64_t*>(&s);
    if (row != none && to != row) {  // a thread between two pieces sends what it has
      send(to, values);
      continue;
    }
    row = to;
    for (int word = 0; word < Sum::words; ++word) sum[word] += values[word];
  }
  // Lanes that have nothing go with the others; a warp of several pieces sends lane by lane.
  const unsigned lane = threadIdx.x % 32, warp = threadIdx.x / 32;
  const unsigned having = __ballot_sync(~0u, row != none);
  const std::uint32_t first = __shfl_sync(~0u, row, having != 0u ? __ffs(static_cast<int>(having)) - 1 : 0);
  const bool alike = __all_sync(~0u, row == none || row == first) != 0;
  if (!alike && row != none) send(row, sum);
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

/// Makes a device current for as long as it lives.
class DeviceScope {
 public:
  explicit DeviceScope(int device) {
    if (cudaGetDevice(&before_) != cudaSuccess) before_ = device;
    changed_ = before_ != device && cudaSetDevice(device) == cudaSuccess;
  }
  ~DeviceScope() {
    if (changed_) (void)cudaSetDevice(before_);
  }
  DeviceScope(const DeviceScope&) = delete;
  DeviceScope& operator=(const DeviceScope&) = delete;

 private:
  int before_ = 0;
  bool changed_ = false;
};

class CudaExec {
 public:
  static constexpr Backend backend = Backend::cuda;

  /// stream: a cudaStream_t of the host's, which must outlive this; null = one of its own.
  CudaExec(int device, void* stream);
  CudaExec(CudaExec&&) noexcept;
  CudaExec& operator=(CudaExec&&) noexcept;
  ~CudaExec();

  void set_guard(const std::uint32_t* guard) { guard_ = guard; }

  template <class Body>
  void for_each(std::uint64_t n, const Body& body) const {
    if (n == 0) return;
    const std::uint64_t all = blocks(n, kernels::block);
    if constexpr (modest<Body>::value) {
      const std::uint64_t few = std::uint64_t{aside_} * multiprocessors_;
      launch(kernels::each_modestly<Body>, few != 0 && few < all ? few : all, kernels::block, guard_, n,
             body);
    } else {
      launch(kernels::each<Body>, all, kernels::block, guard_, n, body);
    }
  }

  template <class Body>
  void gather(std::uint64_t n, const Body& body) const {
    if (n == 0) return;
    if (gather_parts<Body>(n) == 1)
      launch(kernels::gather<1, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body);
    else
      launch(kernels::gather<3, Body>, blocks(n, kernels::gather_items), kernels::gather_block<3>, guard_, n,
             body);
  }

  static bool gathers_two(std::uint64_t n) { return shared_parts(n) == 1u; }
  template <class Body>
  void gather_two(std::uint64_t n, std::uint64_t left_over, const Body& body) const {
    if (n == 0) return;
    const std::uint64_t apart = blocks(left_over, kernels::block);
    launch(kernels::gather_two<Body>, apart + blocks(n, 2u * kernels::block), kernels::block, guard_, n,
           static_cast<unsigned>(apart), left_over, body);
  }

  template <class Body>
  void gather_adding(std::uint64_t n, const Body& body) const {
    if (n == 0) return;
    if (gather_parts<Body>(n) == 1)
      launch(kernels::gather_adding<1, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body);
    else
      launch(kernels::gather_adding<3, Body>, blocks(n, kernels::gather_items), kernels::gather_block<3>,
             guard_, n, body);
  }

  static constexpr bool lists = true;
  template <class Body>
  void select(std::uint64_t n, const Body& body, std::uint32_t* list) const {
    zero(list, sizeof *list);
    if (n != 0)
      launch(kernels::select<Body>, blocks(n, kernels::block), kernels::block, guard_, n, body, list);
  }

  template <class Body>
  void gather_listed(std::uint64_t n, const std::uint32_t* list, const Body& body) const {
    if (n == 0) return;
    const std::uint64_t all = blocks(n, kernels::gather_items);
    const std::uint64_t most = std::uint64_t{kernels::listed_blocks} * multiprocessors_;
    const std::uint64_t grid = all < most ? all : most;
    launch(kernels::gather_listed<Body>, grid, listed<Body>::parts * kernels::gather_items, guard_, list,
           body);
  }

  template <class R, class Body, class Last = Nothing>
  void reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) const {
    static_assert(
        std::is_trivially_copyable<R>::value && sizeof(R) <= kernels::reduce_item && alignof(R) <= 16,
        "the scratch memory of reductions is sized for small plain results");
    const std::uint64_t most =
        std::uint64_t{kernels::reduce_resident<Body>} * kernels::reduce_multiprocessors;
    const std::uint64_t parts = reduce_parts(n) < most ? reduce_parts(n) : most;
    R* const partial = static_cast<R*>(partials(parts));
    if (partial == nullptr) return;
    launch(kernels::reduce<R, Body, Last>, parts, kernels::reduce_block, guard_, n, body, partial, ticket(),
           out, last);
  }

  static constexpr bool fuses() { return true; }
  template <class R, class Body, class Last = Nothing>
  void gather_reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) const {
    static_assert(std::is_trivially_copyable<R>::value && sizeof(R) <= kernels::handing_item);
    R* const places = static_cast<R*>(handing_places());
    if (places == nullptr) return;
    unsigned* const locks = reinterpret_cast<unsigned*>(places + kernels::handing_places);
    const unsigned used = Body::shared || n < gather_few ? kernels::few_places : kernels::handing_places;
    const auto one_part = [&] {
      launch(kernels::gather_reduce<1, R, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body,
             places, locks, used);
    };
    if constexpr (!Body::shared) {
      if (n != 0) one_part();
    } else if (n != 0) {
      if (gather_parts<Body>(n) == 1) one_part();
      else
        launch(kernels::gather_reduce<3, R, Body>, blocks(n, kernels::gather_items), kernels::gather_block<3>,
               guard_, n, body, places, locks, used);
    }
    launch(kernels::combine_places<R, Last>, 1, used, guard_, places, out, last);
  }

  template <class Body>
  void sum_by_row(std::uint64_t n, const Body& body, typename Body::Sum* rows) const {
    if (n == 0) return;
    if (n < gather_few)
      launch(kernels::sum_by_row<1, Body>, blocks(n, kernels::block), kernels::block, guard_, n, body, rows);
    else
      launch(kernels::sum_by_row<kernels::sum_items, Body>,
             blocks(n, std::uint64_t{kernels::block} * kernels::sum_items), kernels::block, guard_, n, body,
             rows);
  }

  /// Defined in core/exec_cuda_scan.cuh.
  template <class Body, class Count>
  void scan(std::uint64_t n, const Body& body, Count* out) const;

  /// These are defined in core/exec_cuda_bucket.cuh.
  template <class Body>
  void bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
              std::uint32_t* begin, std::uint32_t* order, std::uint32_t* counts) const;
  template <class First>
  void begin_buckets(std::uint32_t m, std::uint32_t* counts, std::uint32_t* begin, const First& first) const;
  void fill_buckets(std::uint64_t n, const std::uint32_t* bucket_of, const std::uint32_t* begin,
                    std::uint32_t* order, std::uint32_t* counts) const;
  /// Behind the counts: what tiles of their running sum tell each other, and its turn.
  static constexpr std::uint64_t count_room(std::uint64_t m) {
    return even(m + 1) + 2 * blocks(m + 1, kernels::sum_tile) + 2;
  }

  void sort(std::uint64_t n, std::uint32_t bits, std::uint64_t* keys, std::uint32_t* values,
            std::uint64_t* keys_out, std::uint32_t* values_out) const;

  template <class Body>
  void accumulate(std::uint64_t n, const Body& body) const {
    if (n != 0)
      launch(kernels::each_adding<Body>, blocks(n, kernels::block), kernels::block, guard_, n, body);
  }

  template <class V>
  void copy(std::uint64_t n, const V* from, V* to) const {
    for_each(n, kernels::CopyBody<V>{from, to});
  }

  template <class V>
  void fill(std::uint64_t n, const V& value, V* to) const {
    for_each(n, kernels::FillBody<V>{value, to});
  }

  template <class Enqueue>
  void repeat(const RepeatKey& key, const Enqueue& enqueue) {
    if (known(key)) return launch_known();
    const bool captured = begin_capture();
    enqueue();
    if (captured) end_capture(key);
  }
  template <class First, class Enqueue>
  void repeat(const RepeatKey& key, const First& first, const Enqueue& enqueue) {
    if (known(key)) {
      renewing_ = true;
      first();
      renewing_ = false;
      return launch_known();
    }
    const bool captured = begin_capture();
    first();
    enqueue();
    if (captured) end_capture(key);
  }

  // --- stages side by side (core/schedule.hpp): track 0 is the stream itself; each has its own working
  // space for reductions, scans and sorts.
  void begin_tracks();
  /// What follows is enqueued on this track; the first time on one other than 0, behind what came before
  /// begin_tracks.
  void enter_track(int track);
  /// Where there is not room for all, what follows goes ahead of what is less urgent; 0: as ever.
  void hurry(int urgency);
  /// What follows takes so many blocks of every multiprocessor only; 0: as many as it likes.
  void step_aside(unsigned blocks) { aside_ = blocks; }
  void mark_stage(int stage);
  void wait_for_stage(int stage) const;

  /// Forgets what repeat() kept: the buffers it names are gone.
  void forget_repeats();
  /// Whether what is enqueued now goes into a graph of the host's, to run some time or never, once or often.
  bool host_captures() const;
  /// Graphs made since then.
  std::uint64_t captures() const;

  // --- for the engine ---
  void* allocate(std::uint64_t bytes) const;
  void release(void* p) const;
  void upload(void* to, const void* from, std::uint64_t bytes) const;
  void download(void* to, const void* from, std::uint64_t bytes) const;
  void zero(void* p, std::uint64_t bytes) const;
  void synchronize();
  std::uint64_t free_bytes() const;
  /// Working space of reduce, scan and sort over up to n items; without it they record a fault.
  bool reserve(std::uint64_t n);
  std::uint64_t reserved_bytes() const;
  void* native_stream() const { return stream_; }
  /// The first error since the last call; empty = none.
  std::string fault();

  /// Events around a stage, in a ring per stage made when it is first timed. A captured step is not timed.
  void begin_stage(int index, const char* name);
  void end_stage(int index);
  /// What has finished by now; does not wait.
  const Timings& collect();

 private:
  struct Owned;  // stream, working space, events and the first error

  static constexpr std::uint64_t blocks(std::uint64_t n, std::uint64_t size) { return (n + size - 1) / size; }
  static constexpr std::uint64_t even(std::uint64_t n) { return n + n % 2; }
  static std::uint64_t* tiles_of(std::uint32_t m, std::uint32_t* counts) {
    return reinterpret_cast<std::uint64_t*>(counts + even(std::uint64_t{m} + 1));
  }
  static std::uint32_t* turn_of(std::uint32_t m, std::uint32_t* counts) {
    return counts + (count_room(m) - 2);
  }
  static constexpr std::uint64_t reduce_parts(std::uint64_t n) {
    const std::uint64_t parts = blocks(n, kernels::reduce_block);
    return parts == 0 ? 1 : parts < kernels::reduce_blocks ? parts : kernels::reduce_blocks;
  }

  template <class... Parameters, class... Arguments>
  void launch(void (*kernel)(Parameters...), std::uint64_t grid, unsigned threads,
              Arguments... arguments) const {
    const DeviceScope scope(device_);
    if (renewing_) {
      void* pointers[] = {&arguments...};
      return renew(reinterpret_cast<void*>(kernel), grid, threads, pointers);
    }
    cudaLaunchConfig_t config{};
    config.gridDim = dim3(static_cast<unsigned>(grid));
    config.blockDim = dim3(threads);
    config.stream = stream_;
    cudaLaunchAttribute priority{};
    priority.id = cudaLaunchAttributePriority;
    priority.val.priority = priority_;
    config.attrs = &priority;
    config.numAttrs = 1;
    check(grid <= 0x7fffffffu ? cudaLaunchKernelEx(&config, kernel, arguments...)
                              : cudaErrorInvalidConfiguration,
          "launching a kernel");
  }

  /// Keeps the first error; true = success.
  bool check(cudaError_t result, const char* what) const;
  /// Of gather_reduce: one set, so that no two of them may run side by side; all 0 between launches.
  void* handing_places() const;
  void* partials(std::uint64_t parts) const;
  unsigned* ticket() const;
  /// Whether there is a graph for this key; then it is the one that renew and launch_known mean.
  bool known(const RepeatKey& key) const;
  void launch_known() const;
  /// In place of a launch: its arguments for the first kernel of the known graph.
  void renew(void* kernel, std::uint64_t grid, unsigned threads, void** arguments) const;
  bool begin_capture() const;
  void end_capture(const RepeatKey& key) const;
  /// Working space of CUB, or null and a fault when it is smaller than `bytes`.
  void* scratch(std::size_t bytes) const;
  void harvest();

  int device_ = 0;
  int track_ = 0;
  int priority_ = 0;
  unsigned aside_ = 0;
  unsigned multiprocessors_ = 1;
  bool renewing_ = false;
  cudaStream_t stream_ = nullptr;  // of the track
  const std::uint32_t* guard_ = nullptr;
  std::unique_ptr<Owned> own_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
