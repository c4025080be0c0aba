// SPDX-License-Identifier: Apache-2.0
// Marching cubes: the triangles in a cell for each of the 256 ways its corners can be inside. Not a table
// that was published: traced by the rule below, so that neighbouring cells agree by construction.
//
//   corner c of a cell    offset (c & 1, c >> 1 & 1, c >> 2) from its low node
//   edge 4 a + k          along axis a from the corner with bit 0 of k in axis a + 1 and bit 1 in axis a + 2
//   rule                  on a face with two crossings they are joined; on one with four, two corners that
//   face each
//                         other are inside and are cut off one by one
//
// Every crossing then lies on two lines, one on each face beside its edge; they close to loops, which are cut
// into triangles without a diagonal on a face of the cell: such a diagonal could be the neighbour's, too, and
// an edge of four triangles. That is possible in all cases (tests/modules/cube_table_test.cpp), with five
// triangles at most.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "meltsim/physics/hd.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Triangles of a cell; corners are edges of the cell.
struct CubeCase {
  std::uint8_t triangles = 0;
  std::uint8_t edge[15] = {};
};

/// Low corner and axis of an edge of the cell.
struct CubeEdge {
  std::uint32_t corner = 0, axis = 0;
};
MELTSIM_HD CubeEdge cube_edge(std::uint32_t edge) {
  const std::uint32_t axis = edge >> 2, u = axis == 2u ? 0u : axis + 1u, v = u == 2u ? 0u : u + 1u;
  return {((edge & 1u) << u) | (((edge >> 1) & 1u) << v), axis};
}

/// Corners of a face in order: A, B, C, D; AB is crossed. Which other edge its crossing is joined with: 1 =
/// BC, 2 = CD, 3 = DA.
MELTSIM_HD int joined_edge(bool a, bool b, bool c, bool d) {
  if (b != c && c != d) return a ? 3 : 1;  // four crossings
  return b != c ? 1 : c != d ? 2 : 3;
}

namespace cube {

inline std::uint32_t edge_between(std::uint32_t a, std::uint32_t b) {
  for (std::uint32_t e = 0; e < 12; ++e) {
    const CubeEdge edge = cube_edge(e);
    const std::uint32_t other = edge.corner | (1u << edge.axis);
    if ((edge.corner == a && other == b) || (edge.corner == b && other == a)) return e;
  }
  return 12;
}

/// Corners of face 2 a + s, counter-clockwise seen from outside the cell.
inline std::array<std::uint32_t, 4> face(std::uint32_t number) {
  const std::uint32_t axis = number / 2, side = number % 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
  const std::uint32_t s = side << axis;
  if (side == 1) return {s, s | (1u << u), s | (1u << u) | (1u << v), s | (1u << v)};
  return {s, s | (1u << v), s | (1u << u) | (1u << v), s | (1u << u)};
}

inline bool share_a_face(std::uint32_t e, std::uint32_t f) {
  const CubeEdge a = cube_edge(e), b = cube_edge(f);
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    if (axis != a.axis && axis != b.axis && ((a.corner ^ b.corner) >> axis & 1u) == 0u) return true;
  return false;
}

/// Cuts corners first..last of a loop into triangles; false where every way has a diagonal on a face.
inline bool cut(const std::vector<std::uint32_t>& loop, std::size_t first, std::size_t last, CubeCase& c) {
  if (last < first + 2) return true;
  const auto diagonal_fits = [&](std::size_t i, std::size_t k) {
    return k == i + 1 || (i == 0 && k + 1 == loop.size()) || !share_a_face(loop[i], loop[k]);
  };
  for (std::size_t k = first + 1; k < last; ++k) {
    if (!diagonal_fits(first, k) || !diagonal_fits(k, last)) continue;
    const CubeCase before = c;
    if (c.triangles < 5 && cut(loop, first, k, c) && cut(loop, k, last, c) && c.triangles < 5) {
      const std::size_t at = std::size_t{3} * c.triangles++;
      c.edge[at] = static_cast<std::uint8_t>(loop[first]);
      c.edge[at + 1] = static_cast<std::uint8_t>(loop[last]);
      c.edge[at + 2] = static_cast<std::uint8_t>(loop[k]);
      return true;
    }
    c = before;
  }
  return false;
}

/// The edge that follows each on its loop, clockwise seen from outside the set; 12 where none is
/// crossed.
inline std::array<std::uint32_t, 12> followers(std::uint32_t inside) {
  std::array<std::uint32_t, 12> next;
  next.fill(12);
  const auto is_in = [inside](std::uint32_t corner) { return (inside >> corner & 1u) != 0u; };
  for (std::uint32_t f = 0; f < 6; ++f) {
    const auto corner = face(f);
    for (std::uint32_t k = 0; k < 4; ++k) {
      const auto at = [&](std::uint32_t n) { return corner[(k + n) % 4]; };
      if (!is_in(at(0)) || is_in(at(1))) continue;
      const auto to = static_cast<std::uint32_t>(joined_edge(true, false, is_in(at(2)), is_in(at(3))));
      next[edge_between(at(0), at(1))] = edge_between(at(to), at(to + 1));
    }
  }
  return next;
}

}  // namespace cube

/// Of one set of corners: bit c = corner c is inside. No triangles where a loop cannot be cut.
inline CubeCase make_cube_case(std::uint32_t inside) {
  CubeCase c;
  auto next = cube::followers(inside);
  for (std::uint32_t start = 0; start < 12; ++start) {
    std::vector<std::uint32_t> loop;
    for (std::uint32_t e = start; next[e] != 12;) {
      loop.push_back(e);
      const std::uint32_t to = next[e];
      next[e] = 12;
      e = to;
    }
    if (!loop.empty() && !cube::cut(loop, 0, loop.size() - 1, c)) return {};
  }
  return c;
}

inline std::array<CubeCase, 256> make_cube_table() {
  std::array<CubeCase, 256> table;
  for (std::uint32_t k = 0; k < 256; ++k) table[k] = make_cube_case(k);
  return table;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
