// SPDX-License-Identifier: Apache-2.0
// Walking a body's lattice: direct neighbours (arrayN) and regions (arrayR) as bit masks.
#pragma once

#include "core/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

inline constexpr std::uint32_t self_bit = 13;         ///< offset (0,0,0) among 27
inline constexpr std::uint32_t full_neighbours = 27;  ///< an IBP has all of them

MELTSIM_HD std::uint32_t neighbour_bit(int dx, int dy, int dz) {
  return static_cast<std::uint32_t>((dx + 1) + 3 * (dy + 1) + 9 * (dz + 1));
}

MELTSIM_HD std::uint32_t region_bit(int w, int dx, int dy, int dz) {
  const int side = 2 * w + 1;
  return static_cast<std::uint32_t>((dx + w) + side * ((dy + w) + side * (dz + w)));
}

MELTSIM_HD std::uint32_t words_for(int w) {
  const std::uint32_t side = static_cast<std::uint32_t>(2 * w + 1);
  return (side * side * side + 31u) / 32u;
}

MELTSIM_HD std::uint32_t site_at(std::uint32_t site, const BodyRow& b, int dx, int dy, int dz) {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(site) + dx +
                                    static_cast<std::int64_t>(dy) * b.stride_y +
                                    static_cast<std::int64_t>(dz) * b.stride_z);
}

/// visit(vertex, dx, dy, dz) for every member of v's region, v included, x fastest.
template <class T, class Visit>
MELTSIM_HD void for_each_member(const Frame<T>& w, std::uint32_t v, const Visit& visit) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  const std::uint32_t site = w.f.vertex_site[v];
  const std::uint32_t* mask = w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words;
  const int h = b.region_half_width;
  std::uint32_t bit = 0;
  for (int dz = -h; dz <= h; ++dz)
    for (int dy = -h; dy <= h; ++dy) {
      const std::uint32_t row = site_at(site, b, 0, dy, dz);
      for (int dx = -h; dx <= h; ++dx, ++bit)
        if ((mask[bit >> 5] >> (bit & 31u)) & 1u) visit(w.f.site_vertex[row + dx], dx, dy, dz);
    }
}

/// Members of v's region: |R_v|.
template <class T>
MELTSIM_HD std::uint32_t region_size(const Frame<T>& w, std::uint32_t v) {
  std::uint32_t n = 0;
  const std::uint32_t* mask = w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words;
  for (std::uint32_t k = 0; k < w.region_words; ++k) n += popcount(mask[k]);
  return n;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
