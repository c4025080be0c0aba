// SPDX-License-Identifier: Apache-2.0
// Kernels that keep arrayR up to date: which rows of a lattice are live, what has changed around a region, and its fill,
// with rows of the lattice as bits of a word.
#pragma once

#include "topology/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

using core::row_changed;

/// Live vertices within w of a site along x: bit k of 2w+1 is the one at k - w. Of a site without a vertex of its own
/// that is not kept (row_live), and is looked up.
template <class T>
MELTSIM_HD std::uint32_t live_along_x(const Frame<T>& w, std::uint32_t site, int h) {
  std::uint32_t live = 0;
  for (int dx = -h; dx <= h; ++dx) {
    const std::uint32_t n = w.f.site_vertex[static_cast<std::int64_t>(site) + dx];
    if (n != none && w.f.vertex_state[n] == vertex_live) live |= 1u << (dx + h);
  }
  return live;
}

/// Who is live in the row about a vertex, melted or not; and whether that is news.
template <class T>
struct RowLiveBody {
  Frame<T> w;
  bool all;  ///< none was known before (when the scene is uploaded)
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!all && w.f.status->died == 0 && w.f.status->born == 0u) return;
    const std::uint32_t live =
        live_along_x(w, w.f.vertex_site[v], w.f.bodies[w.f.vertex_body[v]].region_half_width);
    const bool news = !all && live != (w.f.row_live[v] & ~row_changed);
    w.f.row_live[v] = live | (news ? row_changed : 0u);
  }
};

/// Whether a row within w of a site along y has changed. Rows without a vertex in the middle are looked through.
template <class T>
MELTSIM_HD bool has_plane_changed(const Frame<T>& w, std::uint32_t site, const BodyRow& b) {
  const int h = b.region_half_width;
  std::uint32_t changed = 0;
  for (int dy = -h; dy <= h; ++dy) {
    const std::uint32_t row = core::site_at(site, b, 0, dy, 0), middle = w.f.site_vertex[row];
    if (middle != none) {
      changed |= w.f.row_live[middle] & row_changed;
      continue;
    }
    for (int dx = -h; dx <= h; ++dx) {
      const std::uint32_t n = w.f.site_vertex[static_cast<std::int64_t>(row) + dx];
      if (n != none && (w.f.vertex_state[n] == vertex_died || was_born(w, n))) changed = row_changed;
    }
  }
  return changed != 0u;
}

/// The same of every vertex. A region lies within w of its vertex: what changes it is in such a plane within w along z.
template <class T>
struct PlaneChangedBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.status->died == 0 && w.f.status->born == 0u) return;
    w.f.plane_changed[v] = has_plane_changed(w, w.f.vertex_site[v], w.f.bodies[w.f.vertex_body[v]]) ? 1u : 0u;
  }
};

/// The rows of a region's box, first along y: those live, and those inside as far as the fill has come. For half-widths
/// up to Most.
template <int Most>
struct RegionRows {
  static constexpr int sides = 2 * Most + 1;
  static constexpr std::uint32_t unknown =
      0x80000000u;  ///< in live: nobody knows this row by a vertex in its middle
  std::uint32_t live[sides * sides], inside[sides * sides];
};

/// One round of the fill: the live ones among the 26 neighbours of what is inside, axis by axis.
template <int Most>
MELTSIM_HD void spread(RegionRows<Most>& rows, int side) {
  constexpr int most = RegionRows<Most>::sides;
  const auto wide = [&](int r) { return rows.inside[r] | rows.inside[r] << 1 | rows.inside[r] >> 1; };
  std::uint32_t below[most], here[most];  // layers as they were, spread along x and y
  const auto layer = [&](int z, std::uint32_t(&to)[most]) {
    for (int y = 0; y < side; ++y) {
      to[y] = wide(z * side + y);
      if (y > 0) to[y] |= wide(z * side + y - 1);
      if (y + 1 < side) to[y] |= wide(z * side + y + 1);
    }
  };
  for (int y = 0; y < side; ++y) below[y] = 0u;
  layer(0, here);
  for (int z = 0; z < side; ++z) {
    std::uint32_t above[most] = {};
    if (z + 1 < side) layer(z + 1, above);
    for (int y = 0; y < side; ++y) {
      const int r = z * side + y;
      rows.inside[r] = (below[y] | here[y] | above[y]) & rows.live[r] & ~RegionRows<Most>::unknown;
      below[y] = here[y];
      here[y] = above[y];
    }
  }
}

/// Whether a region can be summed by planes of rows (lsm/boxes.hpp): every row of it is all that is live in the row
/// about a vertex with v's x, and no plane holds more. Not so where a live one in the box is out of reach, or where no
/// vertex ever was in the middle of a row or plane.
template <int Most>
MELTSIM_HD bool is_boxed(const RegionRows<Most>& rows, int side) {
  constexpr std::uint32_t unknown = RegionRows<Most>::unknown;
  bool boxed = true;
  for (int z = 0; z < side; ++z) {
    const bool plane = (rows.live[z * side + side / 2] & unknown) == 0u;
    for (int r = z * side; r < (z + 1) * side; ++r)
      boxed = boxed && rows.inside[r] == (plane && (rows.live[r] & unknown) == 0u ? rows.live[r] : 0u);
  }
  return boxed;
}

/// Fill of arrayR (Shao & Yu 2017, sec. 3.2, Fig. 3): the vertex itself, then w times the direct neighbours of what is
/// already there. A flood fill, not the box: a gap cuts. Neighbours are live vertices of the same body, so rows of bits
/// say what lists of links would. Half: w where the compiler may know it, so that rows stay in registers; 0: any up to
/// Most.
template <int Half, int Most, class T>
MELTSIM_HD void fill_region(const Frame<T>& w, std::uint32_t v, const BodyRow& b) {
  const std::uint32_t site = w.f.vertex_site[v];
  const int h = Half != 0 ? Half : minimum(b.region_half_width, Most), side = 2 * h + 1;
  RegionRows<Most> rows;
  for (int r = 0; r < side * side; ++r)
    rows.live[r] = w.f.site_vertex[core::site_at(site, b, 0, r % side - h, r / side - h)];
  for (int r = 0; r < side * side; ++r) {
    const std::uint32_t middle = rows.live[r];
    rows.live[r] = middle != none ? w.f.row_live[middle] & ~row_changed : RegionRows<Most>::unknown;
    rows.inside[r] = 0u;
  }
  for (int r = 0; r < side * side; ++r)
    if (rows.live[r] == RegionRows<Most>::unknown)
      rows.live[r] |= live_along_x(w, core::site_at(site, b, 0, r % side - h, r / side - h), h);
  rows.inside[h * side + h] = 1u << h;
  for (int round = 0; round < h; ++round) spread(rows, side);
  std::uint32_t* mask = w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words;
  std::uint64_t bits = 0;
  std::uint32_t members = 0, word = 0;
  int have = 0;
  for (int r = 0; r < side * side; ++r) {
    members += popcount(rows.inside[r]);
    bits |= static_cast<std::uint64_t>(rows.inside[r]) << have;
    have += side;
    if (have < 32) continue;
    mask[word++] = static_cast<std::uint32_t>(bits);
    bits >>= 32;
    have -= 32;
  }
  while (word < w.region_words) {
    mask[word++] = static_cast<std::uint32_t>(bits);
    bits = 0;
  }
  w.f.region_members[v] = members | (is_boxed(rows, side) ? core::boxed_region : 0u);
}

/// Fills anew what may have changed: work in proportion to that, the others ask for 2w+1 numbers. No region is wider
/// than Most.
template <class T, int Most>
struct RegionsBody {
  Frame<T> w;
  bool all;  ///< build every region (when the scene is uploaded)
  MELTSIM_HD bool is_stale(std::uint64_t v, const BodyRow& b) const {
    bool changed = false;
    for (int dz = -b.region_half_width; dz <= b.region_half_width; ++dz) {
      const std::uint32_t plane = core::site_at(w.f.vertex_site[v], b, 0, 0, dz),
                          middle = w.f.site_vertex[plane];
      changed =
          changed || (middle != none ? w.f.plane_changed[middle] != 0u : has_plane_changed(w, plane, b));
    }
    return changed;
  }
  MELTSIM_HD void operator()(std::uint64_t i) const {
    if (!all && w.f.status->died == 0 && w.f.status->born == 0u) return;
    const auto v = static_cast<std::uint32_t>(i);
    const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
    if (!all && !is_stale(v, b)) return;
    if (w.f.vertex_state[v] != vertex_live) {
      std::uint32_t* mask = w.f.region_mask + i * w.region_words;
      for (std::uint32_t k = 0; k < w.region_words; ++k) mask[k] = 0u;
      w.f.region_members[i] = 0u;
      return;
    }
    if (b.region_half_width == 1) fill_region<1, 1>(w, v, b);
    else if (b.region_half_width == 2) fill_region<2, 2>(w, v, b);
    else fill_region<0, Most>(w, v, b);
  }
};

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
