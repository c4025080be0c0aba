// SPDX-License-Identifier: Apache-2.0
// Kernels that update arrayR: live rows of a lattice, changes around a region, and its fill,
// with rows of the lattice as bits of a word.
#pragma once

#include <cstdint>
#include <type_traits>

#include "topology/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

/// Live sites in the row about a vertex, melted or not. Runs when the scene is uploaded; later NeighbourMasksBody updates them.
template <class T>
struct RowLiveBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    w.f.row_live[v] = live_along_x(w, w.f.vertex_site[v], w.f.bodies[w.f.vertex_body[v]].region_half_width);
  }
};

/// Whether a row within w of a site along y has changed. Rows without a vertex in the middle are searched.
template <class T>
MELTSIM_HD bool has_plane_changed(const Frame<T>& w, std::uint32_t site, const BodyRow& b) {
  const int h = b.region_half_width;
  std::uint32_t changed = 0;
  bool all_known = true;
  for (int dy = -h; dy <= h; ++dy) {  // no branch: all of them at once
    const std::uint32_t middle = w.f.site_vertex[core::site_at(site, b, 0, dy, 0)];
    all_known = all_known && middle != none;
    changed |= core::is_vertex(middle) ? w.f.row_live[middle] & row_changed : 0u;
  }
  for (int dy = -h; !all_known && dy <= h; ++dy) {
    const std::uint32_t row = core::site_at(site, b, 0, dy, 0);
    if (w.f.site_vertex[row] != none) continue;
    for (int dx = -h; dx <= h; ++dx) {
      const std::uint32_t n = w.f.site_vertex[static_cast<std::int64_t>(row) + dx];
      if (core::is_vertex(n) && (w.f.vertex_state[n] == vertex_melted || was_born(w, n)))
        changed = row_changed;
    }
  }
  return changed != 0u;
}

/// The same for every vertex. A region lies within w of its vertex: a change to it is in such a plane within w along z.
template <class T>
struct PlaneChangedBody {
  Frame<T> w;
  struct Item {
    std::uint32_t site = 0, body = 0, changed = 0;
  };
  MELTSIM_HD Item read(std::uint64_t v) const {
    return {w.f.vertex_site[v], w.f.vertex_body[v], has_changed(w)};
  }
  MELTSIM_HD void operator()(std::uint64_t v) const { (*this)(v, read(v)); }
  MELTSIM_HD void operator()(std::uint64_t v, const Item& item) const {
    if (item.changed == 0u) return;
    w.f.plane_changed[v] = has_plane_changed(w, item.site, w.f.bodies[item.body]) ? 1u : 0u;
  }
};

/// A region's box, a plane to a word: bit (dx + w) + (2w + 2) (dy + w) of plane dz + w, so that no bit is shifted from one
/// row into the next. A narrow region is filled in a few instructions.
template <int H>
struct RegionPlanes {
  static constexpr int side = 2 * H + 1, row = side + 1;
  using Word = std::conditional_t<side * row <= 32, std::uint32_t, std::uint64_t>;
  static_assert(side * row <= 64);
  static constexpr Word full = (Word{1} << side) - 1;  ///< a row
  Word live[side], inside[side];
  Word known[side];  ///< rows with a vertex in their middle
};

/// One round of the fill, as below.
template <int H>
MELTSIM_HD void spread(RegionPlanes<H>& planes) {
  using Word = typename RegionPlanes<H>::Word;
  constexpr int side = RegionPlanes<H>::side, row = RegionPlanes<H>::row;
  Word below = 0, here = 0;
  for (int z = 0; z <= side; ++z) {
    Word above = 0;
    if (z < side) {
      above = planes.inside[z];
      above |= above << 1 | above >> 1;
      above |= above << row | above >> row;
    }
    if (z > 0) planes.inside[z - 1] = (below | here | above) & planes.live[z - 1];
    below = here;
    here = above;
  }
}

/// Rows of bits, one after the other, as words of arrayR.
struct MaskWriter {
  std::uint32_t* mask;
  std::uint64_t bits = 0;
  std::uint32_t members = 0, word = 0;
  int have = 0;
  MELTSIM_HD void add(std::uint32_t row, int side) {
    members += popcount(row);
    bits |= static_cast<std::uint64_t>(row) << have;
    have += side;
    if (have < 32) return;
    mask[word++] = static_cast<std::uint32_t>(bits);
    bits >>= 32;
    have -= 32;
  }
  MELTSIM_HD void close(std::uint32_t words) {
    while (word < words) {
      mask[word++] = static_cast<std::uint32_t>(bits);
      bits = 0;
    }
  }
};

/// Which sites of the box around a site are live.
template <int H, class T>
MELTSIM_HD void load_planes(const Frame<T>& w, std::uint32_t site, const BodyRow& b,
                            RegionPlanes<H>& planes) {
  using Word = typename RegionPlanes<H>::Word;
  constexpr int side = RegionPlanes<H>::side, row = RegionPlanes<H>::row;
  std::uint32_t middle[side][side];
  bool look = false;
  for (int z = 0; z < side; ++z)  // no branch here nor in the next: all loads at once
    for (int y = 0; y < side; ++y) {
      middle[z][y] = w.f.site_vertex[core::site_at(site, b, 0, y - H, z - H)];
      look = look || middle[z][y] == none;
    }
  for (int z = 0; z < side; ++z) {
    planes.live[z] = planes.known[z] = 0;
    for (int y = 0; y < side; ++y) {
      const bool known = core::is_vertex(middle[z][y]);
      const std::uint32_t live = known ? w.f.row_live[middle[z][y]] & ~row_changed : 0u;
      planes.live[z] |= static_cast<Word>(live) << (y * row);
      planes.known[z] |= known ? RegionPlanes<H>::full << (y * row) : Word{0};
    }
  }
  for (int z = 0; look && z < side; ++z)
    for (int y = 0; y < side; ++y)
      if (middle[z][y] == none)
        planes.live[z] |= static_cast<Word>(live_along_x(w, core::site_at(site, b, 0, y - H, z - H), H))
                          << (y * row);
}

/// fill_region for a half-width that is a compile-time constant.
template <int H, class T>
MELTSIM_HD void fill_planes(const Frame<T>& w, std::uint32_t v, const BodyRow& b) {
  using Word = typename RegionPlanes<H>::Word;
  constexpr int side = RegionPlanes<H>::side, row = RegionPlanes<H>::row;
  RegionPlanes<H> planes;
  load_planes(w, w.f.vertex_site[v], b, planes);
  for (Word& inside : planes.inside) inside = 0;
  planes.inside[H] = Word{1} << (H * row + H);
  for (int round = 0; round < H; ++round) spread(planes);
  MaskWriter mask{w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words};
  bool boxed = true;
  for (int z = 0; z < side; ++z) {
    const bool plane = (planes.known[z] >> (H * row) & 1u) != 0u;
    boxed = boxed && planes.inside[z] == (plane ? planes.live[z] & planes.known[z] : Word{0});
    for (int y = 0; y < side; ++y) {
      const auto inside = static_cast<std::uint32_t>(planes.inside[z] >> (y * row) & RegionPlanes<H>::full);
      mask.add(inside, side);
    }
  }
  mask.close(w.region_words);
  w.f.region_members[v] = mask.members | (boxed ? core::boxed_region : 0u);
}

/// The rows of a region's box, first along y: those live, and those inside as far as the fill has come. For half-widths
/// up to Most.
template <int Most>
struct RegionRows {
  static constexpr int sides = 2 * Most + 1;
  static constexpr std::uint32_t unknown = 0x80000000u;  ///< in live: no vertex is in the middle of this row
  std::uint32_t live[sides * sides], inside[sides * sides];
};

/// One round of the fill: adds the live sites among the 26 neighbours of those inside, axis by axis.
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

/// Fill of arrayR (Shao & Yu 2017, sec. 3.2, Fig. 3): the vertex itself, then w times the direct neighbours of the sites
/// already inside. A flood fill, not the box: it does not cross gaps. Neighbours are live vertices of the same body, so
/// rows of bits replace lists of links. For half-widths up to Most.
template <int Most, class T>
MELTSIM_HD void fill_region(const Frame<T>& w, std::uint32_t v, const BodyRow& b) {
  const std::uint32_t site = w.f.vertex_site[v];
  const int h = minimum(b.region_half_width, Most), side = 2 * h + 1;
  RegionRows<Most> rows;
  bool look = false;
  for (int r = 0; r < side * side; ++r)
    rows.live[r] = w.f.site_vertex[core::site_at(site, b, 0, r % side - h, r / side - h)];
  for (int r = 0; r < side * side; ++r) {
    const std::uint32_t middle = rows.live[r];
    rows.live[r] = core::is_vertex(middle) ? w.f.row_live[middle] & ~row_changed : RegionRows<Most>::unknown;
    look = look || middle == none;
    rows.inside[r] = 0u;
  }
  for (int r = 0; look && r < side * side; ++r)
    if (rows.live[r] == RegionRows<Most>::unknown)
      rows.live[r] |= live_along_x(w, core::site_at(site, b, 0, r % side - h, r / side - h), h);
  rows.inside[h * side + h] = 1u << h;
  for (int round = 0; round < h; ++round) spread(rows, side);
  MaskWriter mask{w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words};
  for (int r = 0; r < side * side; ++r) {
    mask.add(rows.inside[r], side);
  }
  mask.close(w.region_words);
  w.f.region_members[v] = mask.members | (is_boxed(rows, side) ? core::boxed_region : 0u);
}

/// Refills the regions that may have changed; others cost 2w+1 loads each. No region is wider than
/// Most.
template <class T, int Most>
struct FillRegionsBody {
  Frame<T> w;
  bool all;  ///< build every region (when the scene is uploaded)
  struct Item {
    std::uint32_t site = 0, body = 0, state = 0, changed = 0;
  };
  MELTSIM_HD Item read(std::uint64_t v) const {
    return {w.f.vertex_site[v], w.f.vertex_body[v], w.f.vertex_state[v], all ? 1u : has_changed(w)};
  }
  MELTSIM_HD bool is_stale(std::uint32_t site, const BodyRow& b) const {
    const int h = b.region_half_width;
    std::uint32_t changed = 0;
    bool unknown = false;
    for (int dz = -h; dz <= h; ++dz) {  // no branch: all of them at once
      const std::uint32_t middle = w.f.site_vertex[core::site_at(site, b, 0, 0, dz)];
      unknown = unknown || middle == none || middle == core::empty_row;
      changed |= core::is_vertex(middle) ? w.f.plane_changed[middle] : 0u;
    }
    for (int dz = -h; unknown && changed == 0u && dz <= h; ++dz) {
      const std::uint32_t plane = core::site_at(site, b, 0, 0, dz);
      if (!core::is_vertex(w.f.site_vertex[plane]) && has_plane_changed(w, plane, b)) changed = 1u;
    }
    return changed != 0u;
  }
  MELTSIM_HD void operator()(std::uint64_t i) const { (*this)(i, read(i)); }
  MELTSIM_HD void operator()(std::uint64_t i, const Item& item) const {
    if (item.changed == 0u) return;
    const auto v = static_cast<std::uint32_t>(i);
    const BodyRow b = w.f.bodies[item.body];
    if (!all && !is_stale(item.site, b)) return;
    if (item.state != vertex_live) {
      std::uint32_t* mask = w.f.region_mask + i * w.region_words;
      for (std::uint32_t k = 0; k < w.region_words; ++k) mask[k] = 0u;
      w.f.region_members[i] = 0u;
      return;
    }
    if (b.region_half_width == 0) return fill_planes<0>(w, v, b);
    if (b.region_half_width == 1) return fill_planes<1>(w, v, b);
    if (b.region_half_width == 2) return fill_planes<2>(w, v, b);
    if constexpr (Most > 2) {
      if (b.region_half_width == 3) fill_planes<3>(w, v, b);
      else fill_region<Most>(w, v, b);
    }
  }
};

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
