// SPDX-License-Identifier: Apache-2.0
// The verbs on the CPU. Together with cuda/exec/exec_cuda.cuh this is the executor concept:
//
//   for_each(n, body)            body(i), i in [0, n); every call writes only what belongs to i. A body with an Item
//                                and read(i) may be called as body(i, read(i)) instead, with read(i) before the guard;
//                                in accumulate likewise, body(i, read(i), add)
//   gather(n, body)              body.finish(i, sum of body.part(i, k) over k = 0, 1, 2), for sums long
//                                enough to share out; Body::Sum::add; order of addition fixed; in two passes
//                                where the body has join(i) and more(i, k, parts, sum) (exec/gather.hpp)
//   select(n, body, list)        list = those i with body.wanted(i), in any order; list[0] = how many. Where
//                                testing again costs nothing, no list is made (lists = false)
//   gather_listed(n, list, body) gather over the items selected by the same wanted(i)
//   reduce(n, body, out[, last]) *out = combine of body(i); R::combine is associative, R{} its identity; then
//                                last(*out). body(i) may write index i. A body may read ahead: then it is
//                                body(i, item, add), item = read(i) of type Body::Item, add as in accumulate
//   gather_reduce(n, body, out[, last])
//                                gather and reduce in one: body.finish(i, sum, body.read(i), add) returns a P,
//                                P::result() is combined. P::over(lanes) is the result of up to 32 at once, where
//                                each is P::plain()
//   sum_by_row(n, body, rows)    rows[r] += s where body(i, s) = r; none = 0xffffffff adds nothing. Body::Sum
//                                is Sum::words 64-bit integers, so order does not matter
//   scan(n, body, out)           out[i] = body(0) + ... + body(i)   (32- or 64-bit counts); body(i) may be out[i]
//   sort(n, bits, k, v, ko, vo)  stable sort of pairs by the low `bits` of the key, out of place
//   bucket(n, m, body, bucket_of, begin, order, counts)
//                                bucket_of[i] = body(i) < m; order = 0..n-1 by bucket, in any order within one;
//                                begin[b] = first of bucket b, begin[m] = n. counts holds count_room(m), 0 before the
//                                first time. Where the guard holds begin may be lost, and nothing else
//   begin_buckets(m, counts, begin, first), fill_buckets(n, bucket_of, begin, order, counts)
//                                the same in two, where a stage before has set bucket_of and added up counts (add.count)
//                                since the last time. first(0) runs beside the one
//   accumulate(n, body)          body(i, add); add(address, integer), add.lower(address, integer),
//                                add.count(counters, k), add.set(address, bits) and add.clear(address, bits): exact
//                                sums, minima and sets, so order does not matter; lower returns the old value,
//                                add.load(address) reads a value that other threads may be lowering
//   copy(n, from, to), fill(n, value, to)
//
// and, for the engine:
//   repeat(key[, first], enqueue)  enqueue(), which may be recorded: the same key later stands for the same
//                                launches. first() is one launch ahead of them whose arguments may differ
//   begin_copies(), copy_out(to, from, bytes)..., end_copies(mark)
//                                copies of the present data to page-locked memory, concurrent with work enqueued next;
//                                reached(mark) and wait_for_mark(mark) say when they have ended
//   allocate/release, upload/download (they wait), the same _pinned of host memory, make_mark/release_mark, zero, synchronize, free_bytes, reserve(n) working space for
//   verbs over n items, pace() after every sub-step: waits where too much is enqueued, watch(flag),
//   asked_to_stop(): whether the flag is up, where the host can still do something about it, begin_stage/end_stage/collect
//   for timings, native_stream, fault (device errors)
//
// `guard`, when set, makes every verb but sort do nothing once *guard is non-zero: a World that diverged
// keeps its last good state without the host having to look. Threads: exec/team.hpp. Results do not depend on the number of threads: bodies are
// independent, reductions combine fixed chunks in order.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "exec/gather.hpp"
#include "exec/lane_positions.hpp"
#include "exec/repeat_key.hpp"
#include "exec/shares.hpp"
#include "exec/threads.hpp"
#include "exec/timings.hpp"
#include "exec/wide.hpp"
#include "meltsim/physics/math.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Exact adds from many threads. Neighbouring items mostly add to the same few addresses, so a chunk's adds
/// are collected here and sent when the address changes; integers, so no order matters.
class CpuAdder {
 public:
  CpuAdder() = default;
  CpuAdder(const CpuAdder&) = delete;
  CpuAdder& operator=(const CpuAdder&) = delete;
  ~CpuAdder() {
    for (Entry& e : entries_) send(e);
    count_all();
  }
  void operator()(std::int64_t* address, std::int64_t value) const {
    Entry& e = entries_[(reinterpret_cast<std::uintptr_t>(address) >> 3) & 15u];
    if (e.address != address) {
      send(e);
      e = {address, 0};
    }
    e.value =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(e.value) + static_cast<std::uint64_t>(value));
  }
  /// ++counters[which].
  void count(std::uint32_t* counters, std::uint32_t which) const {
    if (counters + which != counter_) {
      count_all();
      counter_ = counters + which;
    }
    ++times_;
  }
  /// Atomically *address = min(*address, value); returns the old value.
  std::uint32_t lower(std::uint32_t* address, std::uint32_t value) const {
    std::uint32_t old = load(address);
    while (value < old &&
           !__atomic_compare_exchange_n(address, &old, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
    return old;
  }
  std::uint32_t load(const std::uint32_t* address) const {
    return __atomic_load_n(address, __ATOMIC_RELAXED);
  }
  /// Atomically sets bits of *address.
  void set(std::uint32_t* address, std::uint32_t bits) const {
    __atomic_fetch_or(address, bits, __ATOMIC_RELAXED);
  }
  void clear(std::uint32_t* address, std::uint32_t bits) const {
    __atomic_fetch_and(address, ~bits, __ATOMIC_RELAXED);
  }

 private:
  struct Entry {
    std::int64_t* address = nullptr;
    std::int64_t value = 0;
  };
  static void send(Entry& e) {
    if (e.address != nullptr) __atomic_fetch_add(e.address, e.value, __ATOMIC_RELAXED);
  }
  void count_all() const {
    if (times_ != 0u) __atomic_fetch_add(counter_, times_, __ATOMIC_RELAXED);
    times_ = 0;
  }
  mutable Entry entries_[16];
  mutable std::uint32_t* counter_ = nullptr;
  mutable std::uint32_t times_ = 0;
};

class CpuExec {
 public:
  explicit CpuExec(int threads = 0) : threads_(threads_for(threads)), shares_(threads_) {}

  /// Sweeps over neighbours run on several of them at a time (spatial/lanes.hpp).
  static constexpr bool lanes = sums_by_lanes;
  int threads() const { return threads_; }
  void set_guard(const std::uint32_t* guard) { guard_ = guard; }
  bool stopped() const { return guard_ != nullptr && *guard_ != 0; }

  template <class Body>
  void for_each(std::uint64_t n, const Body& body) const {
    for_all<is_wide<Body>>(n, body, makes_sums<Body>::value ? few_sums : few);
  }

  template <class Body>
  void gather(std::uint64_t n, const Body& body) const {
    const std::uint32_t parts = gather_parts<Body>(n);
    for_all<is_wide<Body>>(
        n, [&body, parts](std::uint64_t i) { body.finish(i, sum_of(body, i, parts)); }, few_sums);
  }

  template <class Body>
  void gather_adding(std::uint64_t n, const Body& body) const {
    const std::uint32_t parts = gather_parts<Body>(n);
    accumulate_all<is_wide<Body>>(n, [&body, parts](std::uint64_t i, const CpuAdder& add) {
      body.finish(i, sum_of(body, i, parts), add);
    });
  }

  static constexpr bool lists = false;
  template <class Body>
  void select(std::uint64_t, const Body&, std::uint32_t*) const {}

  template <class Body>
  void gather_listed(std::uint64_t n, const std::uint32_t*, const Body& body) const {
    const auto one = [&body](std::uint64_t i) {
      if (body.wanted(i)) body.finish(i, sum_of(body, i, listed<Body>::parts));
    };
    for_all<is_wide<Body>>(n, one, few_sums);
  }

  template <class R, class Body, class Last = Nothing>
  void reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) {
    if (stopped()) return;
    const std::uint64_t chunks = (n + reduced - 1) / reduced;
    static_assert(alignof(R) <= alignof(std::max_align_t) && sizeof(R) <= largest_result);
    partial_.resize(std::max(partial_.size(), static_cast<std::size_t>(chunks) * sizeof(R)));
    R* partial = reinterpret_cast<R*>(partial_.data());
    each_part(n, reduced, [&](std::uint64_t begin, std::uint64_t end) {
      R r{};
      const CpuAdder add;
      for (std::uint64_t i = begin; i < end; ++i) r = R::combine(r, result_of(body, i, add));
      new (partial + begin / reduced) R(r);
    });
    R r{};
    for (std::uint64_t c = 0; c < chunks; ++c) r = R::combine(r, partial[c]);
    *out = r;
    last(*out);
  }

  template <class R, class Body, class Last = Nothing>
  void gather_reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) {
    CpuExec::reduce(n, Finishing<Body>{body, gather_parts<Body>(n)}, out, last);
  }

  template <class Body, class Count>
  void scan(std::uint64_t n, const Body& body, Count* out) {
    if (n == 0 || stopped()) return;
    const std::uint64_t chunks = (n + chunk - 1) / chunk;
    sums_.assign(static_cast<std::size_t>(chunks) + 1, 0);
    each_part(
        n, chunk,
        [&](std::uint64_t begin, std::uint64_t end) {
          Count s = 0;
          for (std::uint64_t i = begin; i < end; ++i) out[i] = s += body(i);
          sums_[static_cast<std::size_t>(begin / chunk) + 1] = s;
        },
        chunk);
    for (std::uint64_t c = 1; c <= chunks; ++c) sums_[c] += sums_[c - 1];
    each_part(
        n, chunk,
        [&](std::uint64_t begin, std::uint64_t end) {
          const auto before = static_cast<Count>(sums_[static_cast<std::size_t>(begin / chunk)]);
          for (std::uint64_t i = begin; i < end; ++i) out[i] += before;
        },
        chunk);
  }

  /// Least-significant-digit radix sort, 11 bits a pass; each chunk of the input keeps its own histogram.
  void sort(std::uint64_t n, std::uint32_t bits, std::uint64_t* keys, std::uint32_t* values,
            std::uint64_t* keys_out, std::uint32_t* values_out) {
    if (n == 0) return;
    const std::uint32_t passes = std::max(1u, (bits + digit_bits - 1) / digit_bits);
    const std::uint64_t part = std::max<std::uint64_t>(chunk, (n + threads_ - 1) / threads_);
    std::uint64_t *from_k = keys, *to_k = keys_out;
    std::uint32_t *from_v = values, *to_v = values_out;
    for (std::uint32_t pass = 0; pass < passes; ++pass) {
      const std::uint32_t shift = pass * digit_bits;
      sort_pass(
          n, part, [&](std::uint64_t i) { return from_k[i] >> shift; },
          [&](std::uint64_t i, std::uint32_t to) {
            to_k[to] = from_k[i];
            to_v[to] = from_v[i];
          });
      std::swap(from_k, to_k);
      std::swap(from_v, to_v);
    }
    if (from_k != keys_out) {
      copy(n, from_k, keys_out);
      copy(n, from_v, values_out);
    }
  }

  static constexpr std::uint64_t count_room(std::uint64_t m) { return m + 1; }
  /// A counting sort. (By digits it took longer on 16 threads than on 4: a histogram for each, one after another.)
  template <class Body>
  void bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
              std::uint32_t* begin, std::uint32_t* order, std::uint32_t* counts) {
    if (stopped()) return;
    CpuExec::for_each(std::uint64_t{m} + 1, [=](std::uint64_t b) { counts[b] = 0; });
    CpuExec::accumulate(n, [&body, bucket_of, counts](std::uint64_t i, const CpuAdder& add) {
      add.count(counts, bucket_of[i] = body(i));
    });
    CpuExec::begin_buckets(m, counts, begin, Nothing{});
    CpuExec::fill_buckets(n, bucket_of, begin, order, counts);
  }
  template <class First>
  void begin_buckets(std::uint32_t m, const std::uint32_t* counts, std::uint32_t* begin, const First& first) {
    scan(
        std::uint64_t{m} + 1, [counts](std::uint64_t b) { return b == 0 ? 0u : counts[b - 1]; }, begin);
    if (!stopped()) first(0);
  }
  /// Neighbouring items mostly go to one bucket: they ask for their places together. Counts run down to 0 meanwhile.
  void fill_buckets(std::uint64_t n, const std::uint32_t* bucket_of, const std::uint32_t* begin,
                    std::uint32_t* order, std::uint32_t* counts) const {
    if (stopped()) return;
    each_part(n, part, [&](std::uint64_t i, std::uint64_t end) {
      while (i < end) {
        const std::uint32_t b = bucket_of[i];
        std::uint64_t next = i + 1;
        while (next < end && bucket_of[next] == b) ++next;
        std::uint32_t place =
            begin[b] + __atomic_sub_fetch(counts + b, static_cast<std::uint32_t>(next - i), __ATOMIC_RELAXED);
        for (; i < next; ++i) order[place++] = static_cast<std::uint32_t>(i);
      }
    });
  }

  template <class Body>
  void accumulate(std::uint64_t n, const Body& body) const {
    accumulate_all<is_wide<Body>>(n, body);
  }

  template <class Body>
  void sum_by_row(std::uint64_t n, const Body& body, typename Body::Sum* rows) const {
    using Sum = typename Body::Sum;
    constexpr std::uint32_t none = 0xffffffffu;
    if (n == 0 || stopped()) return;
    each_part(n, 4 * part, [&](std::uint64_t begin, std::uint64_t end) {
      std::uint32_t row = none;
      std::uint64_t sum[Sum::words] = {};  // unsigned: wraps where it overflows
      const auto send = [&] {
        if (row == none) return;
        auto* to = reinterpret_cast<std::int64_t*>(rows + row);
        for (int k = 0; k < Sum::words; ++k)
          __atomic_fetch_add(to + k, static_cast<std::int64_t>(sum[k]), __ATOMIC_RELAXED);
      };
      for (std::uint64_t i = begin; i < end; ++i) {
        Sum s;
        const std::uint32_t to = body(i, s);
        if (to == none) continue;
        if (to != row) {
          send();
          row = to;
          std::fill(sum, sum + Sum::words, 0u);
        }
        std::uint64_t words[Sum::words];
        std::memcpy(words, &s, sizeof words);
        for (int k = 0; k < Sum::words; ++k) sum[k] += words[k];
      }
      send();
    });
  }

  /// Positions by coordinate, for bodies that work on lanes.
  template <class T>
  LanePositions<T> split(std::uint64_t n, const Vec4<T>* from) {
    const std::uint64_t stride = n + meltsim::core::lanes;
    if (split_.size() < split_bytes<T>(n)) split_.resize(split_bytes<T>(n));
    T* to = reinterpret_cast<T*>(split_.data());
    CpuExec::for_each(stride, [=](std::uint64_t i) {
      const Vec4<T> v = i < n ? from[i] : Vec4<T>{};
      to[i] = v.x;
      to[stride + i] = v.y;
      to[2 * stride + i] = v.z;
      to[3 * stride + i] = v.w;
    });
    return {to, to + stride, to + 2 * stride, to + 3 * stride};
  }

  template <class V>
  void copy(std::uint64_t n, const V* from, V* to) const {
    if (n != 0 && !stopped()) std::memcpy(to, from, static_cast<std::size_t>(n) * sizeof(V));
  }

  template <class V>
  void fill(std::uint64_t n, const V& value, V* to) const {
    if (!stopped()) std::fill(to, to + n, value);
  }

  // --- for the engine ---
  template <class Enqueue>
  void repeat(const RepeatKey&, const Enqueue& enqueue) {
    enqueue();
  }
  template <class First, class Enqueue>
  void repeat(const RepeatKey&, const First& first, const Enqueue& enqueue) {
    first();
    enqueue();
  }
  void forget_repeats() {}
  bool host_captures() const { return false; }
  std::uint64_t captures() const { return 0; }
  static constexpr Backend backend = Backend::cpu;
  /// 64-byte aligned, or null.
  void* allocate(std::uint64_t bytes) const {
    return std::aligned_alloc(64, static_cast<std::size_t>((bytes + 63) / 64 * 64));
  }
  void release(void* p) const { std::free(p); }
  void upload(void* to, const void* from, std::uint64_t bytes) const {
    if (bytes != 0) std::memcpy(to, from, static_cast<std::size_t>(bytes));
  }
  void download(void* to, const void* from, std::uint64_t bytes) const {
    if (bytes != 0) std::memcpy(to, from, static_cast<std::size_t>(bytes));
  }
  /// Shared among threads, since the system clears each page that is new before.
  void zero(void* p, std::uint64_t bytes) const {
    constexpr std::uint64_t piece = std::uint64_t{1} << 21;
    const auto clear = [p](std::uint64_t begin, std::uint64_t end) {
      std::memset(static_cast<char*>(p) + begin, 0, static_cast<std::size_t>(end - begin));
    };
    each_part(bytes, piece, clear, piece);
  }
  void synchronize() const {}
  /// Whether the host may read what allocate() gave.
  static constexpr bool in_host_memory = true;
  // Copies have ended when they are enqueued.
  void* allocate_pinned(std::uint64_t bytes) const { return allocate(bytes); }
  void release_pinned(void* p) const { release(p); }
  void* make_mark() const { return nullptr; }
  void release_mark(void*) const {}
  void begin_copies() const {}
  void copy_out(void* to, const void* from, std::uint64_t bytes) const { download(to, from, bytes); }
  void end_copies(void*) const {}
  bool reached(void*) const { return true; }
  void wait_for_mark(void*) const {}
  void pace() const {}
  /// A CPU has no streams: returns the error text.
  std::string wait_for_event(void*) const { return no_events; }
  std::string signal_event(void*) const { return no_events; }
  static constexpr const char* no_events =
      "this World is on the CPU, where nothing is enqueued; leave the call out";
  /// Flag by which the host asks to stop; long stages read it between their parts.
  void watch(const std::atomic<bool>* asked) { asked_ = asked; }
  bool asked_to_stop() const { return asked_ != nullptr && asked_->load(std::memory_order_relaxed); }
  /// Bytes that may still be allocated: a system that promises more than it has ends processes later.
  std::uint64_t free_bytes() const { return available_memory(); }
  bool reserve(std::uint64_t n) {
    partial_.reserve(static_cast<std::size_t>(n / reduced + 2) * largest_result);
    sums_.reserve(static_cast<std::size_t>(n / chunk + 2));
    histogram_.reserve(static_cast<std::size_t>(threads_ + 1) << digit_bits);
    return true;
  }
  template <class T>
  void reserve_split(std::uint64_t n) {
    split_.resize(split_bytes<T>(n));
  }
  std::uint64_t reserved_bytes() const {
    return partial_.capacity() + split_.capacity() + histogram_.capacity() * sizeof(std::uint32_t) +
           sums_.capacity() * sizeof(std::uint64_t);
  }
  void* native_stream() const { return nullptr; }
  std::string fault() const { return {}; }
  /// A recorded stage of the host's has run.
  void ended_recorded(const std::string&) const {}

  void begin_stage(int, const char*) { started_ = std::chrono::steady_clock::now(); }
  void end_stage(int index) {
    const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - started_;
    timings_.add(index, ms.count());
  }
  const Timings& collect() { return timings_; }

 private:
  /// One stable pass over the low digit of key(i): place(i, where it goes).
  template <class Key, class Place>
  void sort_pass(std::uint64_t n, std::uint64_t part, const Key& key, const Place& place) {
    constexpr std::uint32_t digits = 1u << digit_bits;
    const auto parts = static_cast<std::int64_t>((n + part - 1) / part);
    histogram_.assign(static_cast<std::size_t>(parts) * digits, 0);
    each_part(
        n, part,
        [&](std::uint64_t begin, std::uint64_t end) {
          std::uint32_t* h = histogram_.data() + static_cast<std::size_t>(begin / part) * digits;
          for (std::uint64_t i = begin; i < end; ++i) ++h[key(i) & (digits - 1)];
        },
        part);
    // First of a digit, then of its parts; along the rows of the table, as parts may be many.
    std::uint32_t first[digits] = {};
    for (std::int64_t p = 0; p < parts; ++p)
      for (std::uint32_t d = 0; d < digits; ++d)
        first[d] += histogram_[static_cast<std::size_t>(p) * digits + d];
    std::uint32_t offset = 0;
    for (std::uint32_t& f : first) offset += std::exchange(f, offset);
    for (std::int64_t p = 0; p < parts; ++p)
      for (std::uint32_t d = 0; d < digits; ++d)
        first[d] += std::exchange(histogram_[static_cast<std::size_t>(p) * digits + d], first[d]);
    each_part(
        n, part,
        [&](std::uint64_t begin, std::uint64_t end) {
          std::uint32_t* h = histogram_.data() + static_cast<std::size_t>(begin / part) * digits;
          for (std::uint64_t i = begin; i < end; ++i) place(i, h[key(i) & (digits - 1)]++);
        },
        part);
  }

 private:
  static constexpr std::uint32_t digit_bits = 11;     // of a radix pass
  static constexpr std::size_t largest_result = 160;  // of a reduction [bytes]
  // Fixed: the shape of a sum may not depend on threads.
  static constexpr std::uint64_t chunk = 4096;   // of a scan
  static constexpr std::uint64_t reduced = 256;  // of a reduction
  template <class T>
  static std::size_t split_bytes(std::uint64_t n) {
    return static_cast<std::size_t>(4 * (n + meltsim::core::lanes)) * sizeof(T);
  }
  // Number of items that is not worth waking threads for; and if each item is a sum.
  static constexpr std::uint64_t few = 1024, few_sums = 256;
  static constexpr std::uint64_t part = 64;  // least number of items that a thread takes
  template <bool Wide, class Body>
  void run(const Body& body, std::uint64_t begin, std::uint64_t end) const {
    if constexpr (Wide)
      if (wide_) return run_wide(body, begin, end);
    for (std::uint64_t i = begin; i < end; ++i) body(i);
  }
  template <class Body>
  MELTSIM_WIDE static void run_wide(const Body& body, std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) body(i);
  }
  template <bool Wide, class Body>
  void accumulate_all(std::uint64_t n, const Body& body) const {
    if (n == 0 || stopped()) return;
    each_part(n, part, [&](std::uint64_t begin, std::uint64_t end) {
      const CpuAdder add;
      run<Wide>([&](std::uint64_t i) { body(i, add); }, begin, end);
    });
  }
  template <bool Wide, class Body>
  void for_all(std::uint64_t n, const Body& body, std::uint64_t alone) const {
    if (n == 0 || stopped()) return;
    each_part(
        n, part, [&](std::uint64_t begin, std::uint64_t end) { run<Wide>(body, begin, end); }, alone);
  }
  /// run(begin, end) over pieces of [0, n); up to `alone` items by this thread.
  template <class Run>
  void each_part(std::uint64_t n, std::uint64_t size, const Run& run, std::uint64_t alone = few) const {
    const auto parts = static_cast<std::int64_t>((n + size - 1) / size);
    const auto one = [&](std::int64_t c) {
      const std::uint64_t begin = static_cast<std::uint64_t>(c) * size;
      run(begin, std::min(n, begin + size));
    };
    if (threads_ > 1 && n > alone) return shares_.each(parts, one);
    for (std::int64_t c = 0; c < parts; ++c) one(c);
  }
  int threads_;
  mutable Shares shares_;
  bool wide_ = wide_instructions();
  const std::uint32_t* guard_ = nullptr;
  const std::atomic<bool>* asked_ = nullptr;
  std::chrono::steady_clock::time_point started_;
  Timings timings_;
  std::vector<unsigned char> partial_;
  std::vector<unsigned char> split_;
  std::vector<std::uint64_t> sums_;
  std::vector<std::uint32_t> histogram_;  // keeps its capacity between steps
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
