// SPDX-License-Identifier: Apache-2.0
// Marks lattice sites whose rows a region fill can skip: no vertex is there, and none will ever be near.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "engine/scene.hpp"
#include "frame/lattice.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// site_vertex from `first_site` on, of the vertices from `first_vertex` on, with empty_row and empty_plane (frame/frame.hpp) instead of
/// `none` where they hold for half-widths up to that of the widest body.
inline std::vector<std::uint32_t> mark_empty_sites(const SceneLattice& l, const AddedBody& from) {
  const auto first = static_cast<std::ptrdiff_t>(from.first_site);
  std::vector<std::uint32_t> sites(l.site_vertex.begin() + first, l.site_vertex.end());
  std::int64_t widest = 0;
  for (const BodyRow& b : l.bodies) widest = std::max<std::int64_t>(widest, b.region_half_width);
  const auto n = static_cast<std::int64_t>(sites.size());
  // Sites within `widest` along x of one that is marked. Boxes are padded: a row does not reach into the next.
  const auto spread = [&](const std::vector<std::uint8_t>& marked) {
    std::vector<std::uint8_t> near(marked.size(), 0);
    std::int64_t last = -widest - 1;
    for (std::int64_t i = 0; i < n; ++i) {
      if (marked[static_cast<std::size_t>(i)] != 0) last = i;
      near[static_cast<std::size_t>(i)] = i - last <= widest;
    }
    last = n + widest;
    for (std::int64_t i = n; i-- > 0;) {
      if (marked[static_cast<std::size_t>(i)] != 0) last = i;
      if (last - i <= widest) near[static_cast<std::size_t>(i)] = 1;
    }
    return near;
  };
  std::vector<std::uint8_t> here(sites.size(), 0), beside_y(sites.size(), 0);
  for (std::size_t v = from.first_vertex; v < l.vertex_site.size(); ++v) {
    const BodyRow& b = l.bodies[l.vertex_body[v]];
    here[l.vertex_site[v] - from.first_site] = 1;
    for (int dy = -b.region_half_width; dy <= b.region_half_width; ++dy)
      beside_y[site_at(l.vertex_site[v], b, 0, dy, 0) - from.first_site] = 1;
  }
  const auto row = spread(here), plane = spread(beside_y);
  for (std::size_t i = 0; i < sites.size(); ++i)
    if (sites[i] == none && row[i] == 0) sites[i] = plane[i] == 0 ? empty_plane : empty_row;
  return sites;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
