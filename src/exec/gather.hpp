// SPDX-License-Identifier: Apache-2.0
// How a long sum is shared out; the same on every backend, so that the order of addition is.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

#include "meltsim/physics/hd.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Below this many items one thread per item would leave most of a large GPU idle, and the longest sum
/// decides.
inline constexpr std::uint64_t gather_few = 200000;

/// Parts of sums that are shared out.
inline constexpr std::uint32_t most_parts = 3;
constexpr std::uint32_t shared_parts(std::uint64_t n) { return n < gather_few ? most_parts : 1u; }

/// Parts that each of n sums of a body is made of. Body::shared: whether sharing out pays (measured).
template <class Body>
constexpr std::uint32_t gather_parts(std::uint64_t n) {
  return Body::shared ? shared_parts(n) : 1u;
}

/// Bodies whose sums are made in two passes: when all parts of i are done, join(i) puts together what they
/// stored, then every part goes on with more(i, k, parts, sum).
template <class Body, class = void>
struct joins : std::false_type {};
template <class Body>
struct joins<Body, std::void_t<decltype(&Body::join)>> : std::true_type {};

/// Bodies whose every call computes a sum, which takes 0.2 us or more.
template <class Body, class = void>
struct makes_sums : std::false_type {};
template <class Body>
struct makes_sums<Body, std::void_t<typename Body::Sum>> : std::true_type {};

/// The sum of i in one thread, in the order of addition of several threads.
template <class Body>
MELTSIM_HD typename Body::Sum sum_of(const Body& body, std::uint64_t i, std::uint32_t parts) {
  typename Body::Sum sum = body.part(i, 0u, parts);
  if constexpr (joins<Body>::value) {
    typename Body::Sum others[most_parts]{};
    for (std::uint32_t k = 1; k < parts; ++k) others[k] = body.part(i, k, parts);
    body.join(i);
    body.more(i, 0u, parts, sum);
    for (std::uint32_t k = 1; k < parts; ++k) {
      body.more(i, k, parts, others[k]);
      sum.add(others[k]);
    }
  } else {
    for (std::uint32_t k = 1; k < parts; ++k) sum.add(body.part(i, k, parts));
  }
  return sum;
}

/// Bodies with `static constexpr std::uint32_t resident_warps(parts)`: as many warps as a GPU should have in
/// place on a multiprocessor, where a compiler left alone would take more registers, or fewer (measured).
template <class Body, class = void>
struct resident {
  static constexpr std::uint32_t warps(std::uint32_t) { return 0; }
};
template <class Body>
struct resident<Body, decltype(static_cast<void>(Body::resident_warps(1u)))> {
  static constexpr std::uint32_t warps(std::uint32_t parts) { return Body::resident_warps(parts); }
};

/// Bodies with `static constexpr bool ends_first = true`: items at both ends of the order first. Sums beside
/// walls take longest, particles in order of their cells begin and end with layers at walls, and where not all
/// blocks are in place at once the last to start should not be the longest.
template <class Body, class = void>
struct ends_first {
  static constexpr bool value = false;
};
template <class Body>
struct ends_first<Body, decltype(static_cast<void>(Body::ends_first))> {
  static constexpr bool value = Body::ends_first;
};

/// Bodies with `static constexpr bool modest = true`: of stages that may have to step aside (pipeline/schedule.hpp).
template <class Body, class = void>
struct modest {
  static constexpr bool value = false;
};
template <class Body>
struct modest<Body, decltype(static_cast<void>(Body::modest))> {
  static constexpr bool value = Body::modest;
};

/// Bodies with `Item` and `Item read(i) const`: operands of one call may be loaded while another computes.
template <class Body, class = void>
struct reads_ahead {
  static constexpr bool value = false;
};
template <class Body>
struct reads_ahead<Body, decltype(static_cast<void>(sizeof(typename Body::Item)))> {
  static constexpr bool value = true;
};

struct Nothing {
  template <class R>
  MELTSIM_HD void operator()(const R&) const {}
};

template <class Body, class Add>
MELTSIM_HD auto result_of(const Body& body, std::uint64_t i, const Add& add) {
  if constexpr (reads_ahead<Body>::value) return body(i, body.read(i), add);
  else return body(i);
}

/// Executors with `bool fuses() const`: whether sph.advance pays.
template <class E, class = void>
inline constexpr bool can_fuse = false;
template <class E>
inline constexpr bool can_fuse<E, std::void_t<decltype(std::declval<const E&>().fuses())>> = true;
template <class E>
bool fuses(const E& ex) {
  if constexpr (can_fuse<E>) return ex.fuses();
  else return false;
}

/// Executors with gathers_two(n) and gather_two(n, left_over, body): a thread makes the sums of two items that follow each
/// other, for bodies with
///   std::uint32_t two(i, alone, sums)    parts of i and i + 1; how many they are of: 1 where i + 1 is left over, or alone
///   std::uint64_t left_over(k)           for k < left_over: an item that was left over, or one beyond all
///   bool unfinished(i)                   whether `more` adds to the sum of i
///   std::uint32_t resident_warps_of_two  as resident_warps
template <class E, class = void>
inline constexpr bool can_gather_two = false;
template <class E>
inline constexpr bool can_gather_two<E, std::void_t<decltype(std::declval<const E&>().gathers_two(1))>> =
    true;

/// A gather as the body of a reduction.
template <class Body>
struct Finishing {
  const Body& body;
  std::uint32_t parts;
  using Item = Nothing;
  MELTSIM_HD Item read(std::uint64_t) const { return {}; }
  template <class Add>
  MELTSIM_HD auto operator()(std::uint64_t i, Item, const Add& add) const {
    return body.finish(i, sum_of(body, i, parts), body.read(i), add).result();
  }
};

/// Parts that each sum over items of a list is made of: they are few.
inline constexpr std::uint32_t listed_parts = 9;

/// Bodies with `listed_parts` of their own: where nine would leave some with nothing to do, or eight more
/// sums per item are more shared memory than a block may have.
template <class Body, class = void>
struct listed {
  static constexpr std::uint32_t parts = listed_parts;
};
template <class Body>
struct listed<Body, decltype(static_cast<void>(Body::listed_parts))> {
  static constexpr std::uint32_t parts = Body::listed_parts;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
