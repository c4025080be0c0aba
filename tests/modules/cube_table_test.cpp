// SPDX-License-Identifier: Apache-2.0
// The traced table of marching cubes: all 256 cases, and that any two cells which share a face agree on it.
#include "frame/cube_table.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

namespace {

using namespace meltsim::core;

using Line = std::pair<std::uint32_t, std::uint32_t>;  // edges of the cell, from and to

/// Sides of triangles that no other triangle of the case has the other way round.
std::set<Line> border(const CubeCase& c) {
  std::set<Line> lines;
  for (std::uint32_t t = 0; t < c.triangles; ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Line side{c.edge[3 * t + k], c.edge[3 * t + (k + 1) % 3]};
      if (lines.erase({side.second, side.first}) != 0) continue;
      EXPECT_TRUE(lines.insert(side).second);
    }
  return lines;
}

bool on_face(std::uint32_t edge, std::uint32_t face) {
  const CubeEdge e = cube_edge(edge);
  return e.axis != face / 2 && (e.corner >> (face / 2) & 1u) == face % 2;
}

std::uint32_t corner_bits(std::uint32_t inside, std::uint32_t face) {
  std::uint32_t bits = 0, n = 0;
  for (std::uint32_t c = 0; c < 8; ++c)
    if ((c >> (face / 2) & 1u) == face % 2) bits |= (inside >> c & 1u) << n++;
  return bits;
}

TEST(CubeTable, EveryCrossedEdgeIsAVertexAndNoOther) {
  const auto table = make_cube_table();
  EXPECT_EQ(table[0].triangles, 0);
  EXPECT_EQ(table[255].triangles, 0);
  for (std::uint32_t inside = 1; inside < 255; ++inside) {
    ASSERT_GT(table[inside].triangles, 0) << inside;
    std::set<std::uint32_t> used, crossed;
    for (int k = 0; k < 3 * table[inside].triangles; ++k) used.insert(table[inside].edge[k]);
    for (std::uint32_t e = 0; e < 12; ++e) {
      const CubeEdge edge = cube_edge(e);
      if (((inside >> edge.corner ^ inside >> (edge.corner | 1u << edge.axis)) & 1u) != 0u) crossed.insert(e);
    }
    EXPECT_EQ(used, crossed) << inside;
  }
}

// What a case leaves on a face depends on the face's corners alone, and is the same line the other way round
// from the other side. So the meshes of neighbours fit whatever else they are.
TEST(CubeTable, NeighboursAgreeOnTheirFace) {
  const auto table = make_cube_table();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<Line>>
      of_face;  // axis, corners seen from the low cell
  for (std::uint32_t inside = 0; inside < 256; ++inside) {
    std::size_t on_faces = 0;
    const std::set<Line> lines = border(table[inside]);
    for (std::uint32_t face = 0; face < 6; ++face) {
      std::set<Line> here;
      for (const Line& l : lines) {
        if (!on_face(l.first, face) || !on_face(l.second, face)) continue;
        // As edges of the cell that has this face on its high side, from its point of view.
        const std::uint32_t axis = face / 2;
        const auto moved = [&](std::uint32_t edge) {
          const CubeEdge e = cube_edge(edge);
          const std::uint32_t corner = e.corner | 1u << axis;
          for (std::uint32_t k = 0; k < 12; ++k)
            if (cube_edge(k).axis == e.axis && cube_edge(k).corner == corner) return k;
          return 12u;
        };
        const Line same{moved(l.first), moved(l.second)};
        here.insert(face % 2 == 1 ? same : Line{same.second, same.first});
      }
      on_faces += here.size();
      const auto known = of_face.emplace(std::make_pair(face / 2, corner_bits(inside, face)), here);
      EXPECT_EQ(known.first->second, here) << inside << " face " << face;
    }
    EXPECT_EQ(on_faces, lines.size()) << inside;  // the border lies on faces
  }
}

// A diagonal on a face could be the neighbour's as well: an edge of four triangles.
TEST(CubeTable, NoDiagonalLiesOnAFace) {
  const auto table = make_cube_table();
  for (std::uint32_t inside = 0; inside < 256; ++inside) {
    const std::set<Line> lines = border(table[inside]);
    for (std::uint32_t t = 0; t < table[inside].triangles; ++t)
      for (std::uint32_t k = 0; k < 3; ++k) {
        const Line side{table[inside].edge[3 * t + k], table[inside].edge[3 * t + (k + 1) % 3]};
        if (lines.count(side) != 0) continue;
        EXPECT_FALSE(cube::share_a_face(side.first, side.second)) << inside;
      }
  }
}

// One corner: its triangle is counter-clockwise seen from outside, that is from the far corner.
TEST(CubeTable, TrianglesFaceOutward) {
  const CubeCase c = make_cube_case(1);
  ASSERT_EQ(c.triangles, 1);
  double p[3][3] = {};
  for (std::size_t k = 0; k < 3; ++k) p[k][cube_edge(c.edge[k]).axis] = 0.5;
  double det = 0;
  for (std::size_t k = 0; k < 3; ++k)
    det += p[0][k] * (p[1][(k + 1) % 3] * p[2][(k + 2) % 3] - p[1][(k + 2) % 3] * p[2][(k + 1) % 3]);
  EXPECT_GT(det, 0);
}

}  // namespace
