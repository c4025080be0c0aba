// SPDX-License-Identifier: Apache-2.0
// An executor that runs every body, and the stages of a sub-step as far as their schedule allows, in an order
// of its own, and remembers the frame it saw last: a body that reads what another of its calls writes gives
// different bits, and so do stages whose rows in the stage table do not say what they touch. The frame's
// pointers stay valid until the next upload, so tests look at any channel.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <type_traits>
#include <utility>
#include <vector>

#include "exec/exec_cpu.hpp"
#include "frame/frame.hpp"
#include "frame/reading_frame.hpp"
#include "frame/surface_frame.hpp"
#include "pipeline/schedule.hpp"

namespace test_support {

/// Whether a body works on a frame.
template <class Body, class = void>
inline constexpr bool has_frame = false;
template <class Body>
inline constexpr bool has_frame<Body, std::void_t<decltype(std::declval<const Body&>().w)>> = true;

enum class Order { forward, reversed, shuffled };

template <class T>
class PermutingExec : public meltsim::core::CpuExec {
  using Base = meltsim::core::CpuExec;

 public:
  explicit PermutingExec(Order order = Order::forward, bool fuses = false)
      : Base(1), order_(order), fuses_(fuses), frame_(std::make_shared<meltsim::core::Frame<T>>()) {}

  /// A device with so much memory; upload() asks before it allocates.
  void limit_memory(std::uint64_t bytes) { free_bytes_ = bytes; }
  std::uint64_t free_bytes() const { return free_bytes_; }

  /// Whether forces and integration are one sweep where they can be, as on a GPU.
  bool fuses() const { return fuses_; }

  /// Shared with every copy of this executor.
  const meltsim::core::Frame<T>& frame() const { return *frame_; }

  using Base::repeat;
  /// Runs what may be recorded, and looks whether it could have been: the same key, the same buffers.
  template <class First, class Enqueue>
  void repeat(const meltsim::core::RepeatKey& key, const First& first, const Enqueue& enqueue) {
    first();
    enqueue();
    const auto& w = *frame_;
    const Buffers now{
        w.f.position,  w.f.velocity,     w.f.enthalpy,      w.f.mass,          w.f.tag,
        w.f.id,        w.f.acceleration, w.before.position, w.before.velocity, w.before.enthalpy,
        w.before.mass, w.before.tag,     w.before.id,       w.next.position,   w.next.velocity};
    const auto known = repeats_->try_emplace(key, now);
    if (known.first->second != now) ++*wrong_repeats_;
  }
  /// How often a key stood for other buffers than the first time, since this executor was made.
  int wrong_repeats() const { return *wrong_repeats_; }

  // --- stages side by side: one after the other, later ones first or in any order
  void begin_tracks() const {}
  void enter_track(int) const {}
  void hurry(int) const {}
  void step_aside(unsigned) const {}
  void mark_stage(int) const {}
  void wait_for_stage(int) const {}
  std::array<int, meltsim::core::stage_count> stage_order(const meltsim::core::Schedule& plan) {
    constexpr int count = meltsim::core::stage_count;
    std::array<int, count> order{};
    std::vector<bool> done(count, false);
    const auto ready = [&](int s) {
      const auto at = static_cast<std::size_t>(s);
      for (int t = 0; t < s; ++t) {
        const auto before = static_cast<std::size_t>(t);
        const bool awaited = ((plan.waits[at] >> t) & 1u) != 0 || plan.track[before] == plan.track[at];
        if (awaited && plan.track[before] >= 0 && !done[before]) return false;
      }
      return true;
    };
    for (int& next : order) {
      std::vector<int> can;
      for (int s = 0; s < count; ++s)
        if (!done[static_cast<std::size_t>(s)] && (plan.track[static_cast<std::size_t>(s)] < 0 || ready(s)))
          can.push_back(s);
      next = order_ == Order::forward    ? can.front()
             : order_ == Order::reversed ? can.back()
                                         : can[engine_() % can.size()];
      done[static_cast<std::size_t>(next)] = true;
    }
    return order;
  }

  template <class Body>
  void for_each(std::uint64_t n, const Body& body) {
    if constexpr (has_frame<Body>) see(body.w);  // rows that the host sets between sub-steps need none
    each(n, body);
  }
  template <class Body>
  void accumulate(std::uint64_t n, const Body& body) {
    see(body.w);
    const meltsim::core::CpuAdder add;
    each(n, [&](std::uint64_t i) { body(i, add); });
  }
  template <class Body>
  void gather(std::uint64_t n, const Body& body) {
    see(body.w);
    const std::uint32_t parts = meltsim::core::gather_parts<Body>(n);
    each(n, [&](std::uint64_t i) { body.finish(i, meltsim::core::sum_of(body, i, parts)); });
  }
  template <class Body>
  void gather_adding(std::uint64_t n, const Body& body) {
    see(body.w);
    const std::uint32_t parts = meltsim::core::gather_parts<Body>(n);
    const meltsim::core::CpuAdder add;
    each(n, [&](std::uint64_t i) { body.finish(i, meltsim::core::sum_of(body, i, parts), add); });
  }
  template <class Body>
  void gather_listed(std::uint64_t n, const std::uint32_t*, const Body& body) {
    see(body.w);
    each(n, [&](std::uint64_t i) {
      if (body.wanted(i)) body.finish(i, meltsim::core::sum_of(body, i, meltsim::core::listed<Body>::parts));
    });
  }
  /// What is reduced in a step must not depend on order either: CheckResult and Count promise it.
  template <class R, class Body, class Last = meltsim::core::Nothing>
  void reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) {
    see(body.w);
    combine(n, body, out, last);
  }
  template <class R, class Body, class Last = meltsim::core::Nothing>
  void gather_reduce(std::uint64_t n, const Body& body, R* out, const Last& last = {}) {
    see(body.w);
    combine(n, meltsim::core::Finishing<Body>{body, meltsim::core::gather_parts<Body>(n)}, out, last);
  }
  /// Where the guard holds, begin is spoilt: on a GPU counts are added up whatever the guard says.
  template <class Body>
  void bucket(std::uint64_t n, std::uint32_t m, const Body& body, std::uint32_t* bucket_of,
              std::uint32_t* begin, std::uint32_t* order, std::uint32_t* counts) {
    see(body.w);
    std::fill_n(counts, std::size_t{m} + 1, 0u);
    if (!stopped())
      for (const std::uint64_t i : indices(n)) ++counts[bucket_of[i] = body(i)];
    begin_buckets(m, counts, begin, meltsim::core::Nothing{});
    fill_buckets(n, bucket_of, begin, order, counts);
  }
  template <class First>
  void begin_buckets(std::uint32_t m, std::uint32_t* counts, std::uint32_t* begin, const First& first) {
    std::uint32_t sum = 0;
    for (std::uint32_t b = 0; b <= m; ++b) {
      begin[b] = sum;
      sum += counts[b];
    }
    if (!stopped()) first(0);
  }
  void fill_buckets(std::uint64_t n, const std::uint32_t* bucket_of, const std::uint32_t* begin,
                    std::uint32_t* order, std::uint32_t* counts) {
    if (stopped()) return;
    for (const std::uint64_t i : indices(n))
      order[begin[bucket_of[i]] + --counts[bucket_of[i]]] = static_cast<std::uint32_t>(i);
  }
  template <class Body>
  void sum_by_row(std::uint64_t n, const Body& body, typename Body::Sum* rows) {
    see(body.w);
    const Permuted<Body> permuted{body, indices(n)};
    Base::sum_by_row(n, permuted, rows);
  }

 private:
  /// body(i) for all i in [0, n), in this executor's order. Not by the base's verbs, which would compile every body twice more.
  template <class Body>
  void each(std::uint64_t n, const Body& body) {
    if (stopped()) return;
    for (const std::uint64_t i : indices(n)) body(i);
  }
  template <class R, class Body, class Last>
  void combine(std::uint64_t n, const Body& body, R* out, const Last& last) {
    if (stopped()) return;
    R r{};
    {
      const meltsim::core::CpuAdder add;
      each(n, [&](std::uint64_t i) { r = R::combine(r, meltsim::core::result_of(body, i, add)); });
    }
    *out = r;
    last(*out);
  }
  template <class Body>
  struct Permuted {
    using Sum = typename Body::Sum;
    const Body& body;
    std::vector<std::uint64_t> order;
    std::uint32_t operator()(std::uint64_t k, Sum& s) const { return body(order[k], s); }
  };
  void see(const meltsim::core::Frame<T>& frame) { *frame_ = frame; }
  void see(const meltsim::core::SurfaceFrame<T>&) {}  // between steps, with a frame of its own
  void see(const meltsim::core::ReadingFrame<T>&) {}  // likewise
  std::vector<std::uint64_t> indices(std::uint64_t n) {
    std::vector<std::uint64_t> order(n);
    std::iota(order.begin(), order.end(), std::uint64_t{0});
    if (order_ == Order::reversed) std::reverse(order.begin(), order.end());
    if (order_ == Order::shuffled) std::shuffle(order.begin(), order.end(), engine_);
    return order;
  }
  using Buffers = std::array<const void*, 15>;
  std::shared_ptr<std::map<meltsim::core::RepeatKey, Buffers>> repeats_ =
      std::make_shared<std::map<meltsim::core::RepeatKey, Buffers>>();
  std::shared_ptr<int> wrong_repeats_ = std::make_shared<int>(0);
  Order order_;
  bool fuses_;
  std::uint64_t free_bytes_ = std::numeric_limits<std::uint64_t>::max();
  std::shared_ptr<meltsim::core::Frame<T>> frame_;
  std::mt19937 engine_{7};
};

}  // namespace test_support
