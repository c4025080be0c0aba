// SPDX-License-Identifier: Apache-2.0
// Sampled volumes and small meshes for the tests of shapes.
#pragma once

#include <cmath>
#include <vector>

#include "meltsim/shape.hpp"

namespace shape_tests {

using meltsim::Shape;
using meltsim::TriangleMesh;
using meltsim::Vec3d;
using meltsim::Vec3i;

inline const double pi = std::acos(-1.0);
/// A lattice origin with no relation to the shapes, so that no face falls onto a layer of sites.
inline const Vec3d generic_origin{0.0123, -0.0271, 0.0317};

inline double sampled_volume(const Shape& shape, double spacing) {
  return static_cast<double>(shape.lattice_points(generic_origin, spacing).size()) * spacing * spacing *
         spacing;
}

/// Sites are misjudged only where their cells are cut by the surface: about area / h^2 cells, each off by an
/// error spread evenly over +-1/2 cell (deviation 1/sqrt(12)) and nearly independent of its neighbours on a
/// surface that runs obliquely. Five deviations of the sum; cells meet an oblique surface up to sqrt(3) times
/// more often than its area suggests.
inline double volume_tolerance(double area, double spacing) {
  const double cells = std::sqrt(3.0) * area / (spacing * spacing);
  return 5 / std::sqrt(12.0) * std::sqrt(cells) * spacing * spacing * spacing;
}

/// The box as twelve triangles, outwards.
inline TriangleMesh cuboid(Vec3d lo, Vec3d hi) {
  TriangleMesh m;
  for (int c = 0; c < 8; ++c)
    m.vertices.push_back(
        {(c & 1) != 0 ? hi.x : lo.x, (c & 2) != 0 ? hi.y : lo.y, (c & 4) != 0 ? hi.z : lo.z});
  m.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5,   // -x, +x
               0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,   // -y, +y
               0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};  // -z, +z
  return m;
}

/// A torus around z with 2 * around * across triangles.
inline TriangleMesh torus_mesh(double major, double minor, std::uint32_t around, std::uint32_t across) {
  TriangleMesh m;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double a = 2 * pi * i / around, b = 2 * pi * j / across, r = major + minor * std::cos(b);
      m.vertices.push_back({r * std::cos(a), r * std::sin(a), minor * std::sin(b)});
      const std::uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
      const std::uint32_t p = i * across + j, q = i1 * across + j, r1 = i1 * across + j1, s = i * across + j1;
      m.indices.insert(m.indices.end(), {p, q, r1, p, r1, s});
    }
  return m;
}

inline bool same_sites(const std::vector<Vec3i>& a, const std::vector<Vec3i>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].x != b[i].x || a[i].y != b[i].y || a[i].z != b[i].z) return false;
  return true;
}

}  // namespace shape_tests
