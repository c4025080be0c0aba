// SPDX-License-Identifier: Apache-2.0
// Marks lattice sites whose rows a region fill can skip: no vertex is there, and none will ever be near.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "engine/scene.hpp"
#include "exec/host_loops.hpp"
#include "frame/lattice.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// near[i] of sites in [begin, end): whether one within `widest` along x is marked. Boxes are padded: a row does not reach into the next.
inline void mark_near(const std::vector<std::uint8_t>& marked, std::int64_t widest, std::size_t begin,
                      std::size_t end, std::vector<std::uint8_t>& near) {
  const auto n = static_cast<std::int64_t>(marked.size()), first = static_cast<std::int64_t>(begin),
             beyond = static_cast<std::int64_t>(end);
  std::int64_t last = first - widest - 1;
  for (std::int64_t i = std::max<std::int64_t>(0, first - widest); i < beyond; ++i) {
    if (marked[static_cast<std::size_t>(i)] != 0) last = i;
    if (i >= first) near[static_cast<std::size_t>(i)] = i - last <= widest;
  }
  last = beyond + widest;
  for (std::int64_t i = std::min(n, beyond + widest); i-- > first;) {
    if (marked[static_cast<std::size_t>(i)] != 0) last = i;
    if (i < beyond && last - i <= widest) near[static_cast<std::size_t>(i)] = 1;
  }
}

/// site_vertex from `first_site` on, of the vertices from `first_vertex` on, with empty_row and empty_plane (frame/frame.hpp) instead of
/// `none` where they hold for half-widths up to that of the widest body.
inline std::vector<std::uint32_t> mark_empty_sites(const SceneLattice& l, const AddedBody& from,
                                                   const HostLoops& loops) {
  const auto first = static_cast<std::ptrdiff_t>(from.first_site);
  std::vector<std::uint32_t> sites;
  loops.make_room(sites, l.site_vertex.size() - from.first_site);
  sites.assign(l.site_vertex.begin() + first, l.site_vertex.end());
  std::int64_t widest = 0;
  for (const BodyRow& b : l.bodies) widest = std::max<std::int64_t>(widest, b.region_half_width);
  std::vector<std::uint8_t> here, beside_y, row, plane;
  for (auto* const marks : {&here, &beside_y, &row, &plane}) loops.resize(*marks, sites.size());
  const auto mark = [](std::uint8_t& m) { __atomic_store_n(&m, std::uint8_t{1}, __ATOMIC_RELAXED); };
  const std::size_t v0 = from.first_vertex;
  loops.pieces(l.vertex_site.size() - v0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = v0 + begin; v < v0 + end; ++v) {
      const BodyRow& b = l.bodies[l.vertex_body[v]];
      mark(here[l.vertex_site[v] - from.first_site]);
      for (int dy = -b.region_half_width; dy <= b.region_half_width; ++dy)
        mark(beside_y[site_at(l.vertex_site[v], b, 0, dy, 0) - from.first_site]);
    }
  });
  loops.pieces(sites.size(), [&](std::size_t begin, std::size_t end) {
    mark_near(here, widest, begin, end, row);
    mark_near(beside_y, widest, begin, end, plane);
    for (std::size_t i = begin; i < end; ++i)
      if (sites[i] == none && row[i] == 0) sites[i] = plane[i] == 0 ? empty_plane : empty_row;
  });
  return sites;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
