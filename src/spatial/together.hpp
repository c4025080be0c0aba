// SPDX-License-Identifier: Apache-2.0
// Two interactions in one sweep over the neighbours.
#pragma once

#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// First, and what Second adds to the same sum. First says whose sum it is, which neighbours are skipped, what is rare and how the sum
/// ends; images in walls are those of each (sweep.hpp).
template <class First, class Second, bool Periodic>
struct Together : First {
  Second second;
  using Sum = typename First::Sum;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return sum_part<Periodic>(First::w, *this, i, k, parts);
  }
  MELTSIM_HD void operator()(std::uint64_t i) const { First::finish(i, part(i, 0, 1)); }

  struct Own : First::Own {
    typename Second::Own second;
  };
  struct Stored : First::Stored {
    typename Second::Stored second;
  };
  struct Other
      : std::decay_t<decltype(std::declval<const First&>().other(
            std::declval<const typename First::Own&>(), std::declval<const typename First::Stored&>()))> {
    typename Second::Stored second;
  };
  MELTSIM_HD Own own(std::uint64_t i) const { return {First::own(i), second.own(i)}; }
  MELTSIM_HD Stored stored(const Own& own, std::uint32_t j) const {
    return {First::stored(own, j), second.stored(own.second, j)};
  }
  MELTSIM_HD Other other(const Own& own, const Stored& s) const {
    return {First::other(own, s), second.other(own.second, s.second)};
  }
  template <class P, class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Other& other, const P& pair, Along along) const {
    First::add(sum, own, other, pair, along);
    second.add(sum, own.second, other.second, pair, NoImages{});
  }
  static constexpr bool each_image = Second::each_image;
  template <class P>
  MELTSIM_HD void add_image(Sum& sum, const Own& own, const Other& other, const P& image,
                            std::uint32_t mask) const {
    second.add_image(sum, own.second, other.second, image, mask);
  }
  struct Lanes {
    typename First::Lanes first;
    typename Second::Lanes second;
    Stored at(std::size_t k) const { return {first.at(k), second.at(k)}; }
    template <class T>
    void load(const Together& body, const Own& own, std::uint64_t i, const std::uint32_t* slots,
              std::uint32_t n, T* volume) {
      first.load(body, own, i, slots, n, volume);
      second.load(body.second, own.second, i, slots, n, volume);
    }
  };
};

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
