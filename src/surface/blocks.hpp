// SPDX-License-Identifier: Apache-2.0
// Cells of the particle grid, which are also the blocks of nodes, and the neighbours of each.
//
// Only blocks near the surface are listed. A group (an occupied cell) lists itself unless it is deep: all 27
// cells around it occupied, no surface particle in them. An empty cell beside groups is listed by the first
// of them. What is not listed is all inside or all outside. Cells belong to the block of their low corner, so
// the mesh is closed if no cell of an unlisted block needs triangles: nodes that such a cell reaches in the
// blocks above it are made to agree with it (`forced`). If surface particles were recognised correctly, that changes
// nothing.
#pragma once

#include "frame/surface_frame.hpp"
#include "spatial/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

using core::link_inside;
using core::link_outside;
using core::none;
using core::Range;
using core::SurfaceFrame;

/// Coordinates of a cell, a direction or a node.
struct Index3 {
  std::int32_t x = 0, y = 0, z = 0;
};

MELTSIM_HD Index3 operator+(Index3 a, Index3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

/// One of 27, 13 = none.
MELTSIM_HD Index3 direction(std::uint32_t d) {
  return {static_cast<std::int32_t>(d % 3u) - 1, static_cast<std::int32_t>(d / 3u % 3u) - 1,
          static_cast<std::int32_t>(d / 9u) - 1};
}
MELTSIM_HD std::uint32_t direction_number(Index3 d) {
  return static_cast<std::uint32_t>(13 + d.x + 3 * d.y + 9 * d.z);
}

template <class T>
MELTSIM_HD std::uint64_t key_of(const SurfaceFrame<T>& w, Index3 c) {
  return (static_cast<std::uint64_t>(c.z) * static_cast<std::uint64_t>(w.grid.ny) +
          static_cast<std::uint64_t>(c.y)) *
             static_cast<std::uint64_t>(w.grid.nx) +
         static_cast<std::uint64_t>(c.x);
}
template <class T>
MELTSIM_HD Index3 coordinates(const SurfaceFrame<T>& w, std::uint64_t key) {
  const auto split = [](auto k, auto nx, auto ny) {
    return Index3{static_cast<std::int32_t>(k % nx), static_cast<std::int32_t>(k / nx % ny),
                  static_cast<std::int32_t>(k / nx / ny)};
  };
  const auto nx = static_cast<std::uint32_t>(w.grid.nx), ny = static_cast<std::uint32_t>(w.grid.ny);
  // A GPU divides 32 bits several times faster.
  if (w.grid.key_bits <= 32u) return split(static_cast<std::uint32_t>(key), nx, ny);
  return split(key, std::uint64_t{nx}, std::uint64_t{ny});
}

/// Cell of a point, `margin` cells inside the grid at least: particles keep one, so that their neighbours
/// exist.
template <class T>
MELTSIM_HD Index3 cell_at(const SurfaceFrame<T>& w, Vec3<T> x, std::int32_t margin) {
  const auto along = [&](T at, T base, std::int32_t n) {
    const T c = std::floor((at - base) * w.grid.inv_edge) + T(w.grid.offset);
    return static_cast<std::int32_t>(clamp(c, T(margin), T(n - 1 - margin)));
  };
  return {along(x.x, w.grid.base.x, w.grid.nx), along(x.y, w.grid.base.y, w.grid.ny),
          along(x.z, w.grid.base.z, w.grid.nz)};
}

/// Where a node of a block is [m].
template <class T>
MELTSIM_HD Vec3<T> node_position(const SurfaceFrame<T>& w, Index3 block, Index3 node) {
  const auto along = [&](T base, std::int32_t b, std::int32_t n) {
    return base + T((b - w.grid.offset) * w.grid.side + n) * w.grid.cell;
  };
  return {along(w.grid.base.x, block.x, node.x), along(w.grid.base.y, block.y, node.y),
          along(w.grid.base.z, block.z, node.z)};
}

template <class T>
MELTSIM_HD std::uint32_t groups_of(const SurfaceFrame<T>& w) {
  return minimum(w.counts->groups, w.max_groups);
}
template <class T>
MELTSIM_HD std::uint32_t blocks_of(const SurfaceFrame<T>& w) {
  return minimum(w.counts->blocks, w.max_blocks);
}
template <class T>
MELTSIM_HD std::uint32_t vertices_of(const SurfaceFrame<T>& w) {
  return minimum(w.counts->vertices, w.max_vertices);
}

/// Keys of the row of cells beside c in x, from first to last; r in 0..8: its place in y and z.
struct KeyRow {
  std::uint64_t first = 1, last = 0;
};
template <class T>
MELTSIM_HD KeyRow key_row(const SurfaceFrame<T>& w, Index3 c, std::uint32_t r) {
  const Index3 at{c.x, c.y + static_cast<std::int32_t>(r % 3u) - 1,
                  c.z + static_cast<std::int32_t>(r / 3u) - 1};
  if (at.y < 0 || at.y >= w.grid.ny || at.z < 0 || at.z >= w.grid.nz) return {};
  return {key_of(w, {maximum(at.x - 1, 0), at.y, at.z}),
          key_of(w, {minimum(at.x + 1, w.grid.nx - 1), at.y, at.z})};
}

/// Groups of a row.
template <class T>
MELTSIM_HD Range groups_in(const SurfaceFrame<T>& w, KeyRow row) {
  const std::uint32_t groups = groups_of(w);
  if (row.first > row.last) return {};
  const std::uint32_t a = spatial::first_not_below(w.group_key, groups, row.first);
  std::uint32_t b = a;
  while (b < groups && w.group_key[b] <= row.last) ++b;  // three at most
  return {a, b};
}

/// Particles of a range of groups.
template <class T>
MELTSIM_HD Range particles_of(const SurfaceFrame<T>& w, Range groups) {
  if (groups.begin == groups.end) return {};
  return {w.group_begin[groups.begin], w.group_begin[groups.end]};
}

/// Group of a cell, or none.
template <class T>
MELTSIM_HD std::uint32_t group_at(const SurfaceFrame<T>& w, Index3 c) {
  const std::uint64_t key = key_of(w, c);
  const std::uint32_t g = spatial::first_not_below(w.group_key, groups_of(w), key);
  return g < groups_of(w) && w.group_key[g] == key ? g : none;
}

/// The first group beside an empty cell: the one that lists it; none where there is none.
template <class T>
MELTSIM_HD std::uint32_t owner_of(const SurfaceFrame<T>& w, Index3 c) {
  const std::uint32_t groups = groups_of(w);
  for (std::uint32_t r = 0; r < 9; ++r) {  // rows ascend in key
    const KeyRow row = key_row(w, c, r);
    if (row.first > row.last) continue;
    const std::uint32_t g = spatial::first_not_below(w.group_key, groups, row.first);
    if (g < groups && w.group_key[g] <= row.last) return g;
  }
  return none;
}

/// Whether entry k of `owns`, a running count by now, counted one.
template <class T>
MELTSIM_HD bool is_listed(const SurfaceFrame<T>& w, std::uint64_t k) {
  return w.owns[k] != (k == 0 ? 0u : w.owns[k - 1]);
}

/// Number of the block of a cell, or what all its nodes are.
template <class T>
MELTSIM_HD std::uint32_t link_to(const SurfaceFrame<T>& w, Index3 c) {
  if (c.x < 0 || c.y < 0 || c.z < 0 || c.x >= w.grid.nx || c.y >= w.grid.ny || c.z >= w.grid.nz)
    return link_outside;
  std::uint32_t g = group_at(w, c), d = 13;
  if (g != none) {
    if (w.group_deep[g] != 0u) return w.group_deep[g];
  } else {
    g = owner_of(w, c);
    if (g == none) return link_outside;
    const Index3 of = coordinates(w, w.group_key[g]);
    d = direction_number({c.x - of.x, c.y - of.y, c.z - of.z});
  }
  const std::uint32_t block = w.owns[std::uint64_t{27} * g + d] - 1u;
  return block < w.max_blocks ? block : link_outside;  // more than there is room for: done again
}

/// Number of a node of a block, coordinates in -side..2 side - 1, or what an unlisted block's nodes are.
template <class T>
MELTSIM_HD std::uint32_t node_at(const SurfaceFrame<T>& w, std::uint32_t block, Index3 n) {
  const std::int32_t side = w.grid.side;
  const auto step = [side](std::int32_t v) { return v < 0 ? -1 : v >= side ? 1 : 0; };
  const Index3 d{step(n.x), step(n.y), step(n.z)};
  const std::uint32_t number = direction_number(d);
  if (number != 13u) {
    block = w.block_link[std::uint64_t{27} * block + number];
    if (block >= link_inside) return block;
  }
  const Index3 local{n.x - d.x * side, n.y - d.y * side, n.z - d.z * side};
  return block * w.grid.volume + static_cast<std::uint32_t>((local.z * side + local.y) * side + local.x);
}

template <class T>
MELTSIM_HD bool is_inside(const SurfaceFrame<T>& w, std::uint32_t node) {
  return node >= link_inside ? node == link_inside : w.inside[node] == core::node_inside;
}
/// Neither in the liquid nor in a solid beside it. Always false where the mesh is closed at solids.
template <class T>
MELTSIM_HD bool is_open(const SurfaceFrame<T>& w, std::uint32_t node) {
  return node >= link_inside ? node == link_outside : w.inside[node] == core::node_outside;
}

MELTSIM_HD Index3 node_in_block(std::uint32_t number, std::int32_t side) {
  const auto n = static_cast<std::int32_t>(number);
  return {n % side, n / side % side, n / (side * side)};
}

/// The value that a node must have because of an unlisted block below it; 0 = free.
template <class T>
MELTSIM_HD std::uint32_t forced(const SurfaceFrame<T>& w, std::uint32_t block, Index3 n) {
  const std::uint32_t low = (n.x == 0 ? 1u : 0u) | (n.y == 0 ? 2u : 0u) | (n.z == 0 ? 4u : 0u);
  for (std::uint32_t mask = low; mask != 0u; mask = (mask - 1u) & low) {
    const Index3 d{-static_cast<std::int32_t>(mask & 1u), -static_cast<std::int32_t>(mask >> 1 & 1u),
                   -static_cast<std::int32_t>(mask >> 2)};
    const std::uint32_t link = w.block_link[std::uint64_t{27} * block + direction_number(d)];
    if (link >= link_inside) return link;
  }
  return 0;
}

/// Which coordinates are odd, a bit each.
MELTSIM_HD std::uint32_t corner_number(Index3 n) {
  return static_cast<std::uint32_t>((n.x & 1) | (n.y & 1) << 1 | (n.z & 1) << 2);
}

/// Corner offset of a cell.
MELTSIM_HD Index3 corner_offset(std::uint32_t c) {
  return {static_cast<std::int32_t>(c & 1u), static_cast<std::int32_t>(c >> 1 & 1u),
          static_cast<std::int32_t>(c >> 2 & 1u)};
}

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
