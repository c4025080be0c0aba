// SPDX-License-Identifier: Apache-2.0
// What every surface must be: closed, manifold, oriented, without degenerate triangles.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "meltsim/surface.hpp"

namespace test_support {

struct MeshCheck {
  std::size_t open_edges = 0;   ///< not traversed exactly once in each direction
  std::size_t unused = 0;       ///< vertices of no triangle
  std::size_t split = 0;        ///< vertices whose triangles are not one fan
  double smallest_area = 0;     ///< [m^2]
  double volume = 0, area = 0;  ///< [m^3], [m^2]
  double worst_normal = 1;      ///< smallest cosine between a vertex normal and its triangles' mean
  std::vector<int> euler;       ///< per component
  std::vector<double> volumes;  ///< per component
};

inline MeshCheck check_mesh(const meltsim::SurfaceMesh& m) {
  using namespace meltsim;
  MeshCheck r;
  const std::size_t n = m.position.size();
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  std::vector<std::uint32_t> root(n), valence(n, 0);
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  std::vector<Vec3d> sum(n);
  std::vector<std::map<std::uint32_t, std::uint32_t>> fan(n);  // around a vertex: from -> to
  r.smallest_area = INFINITY;
  for (std::size_t t = 0; t + 2 < m.triangles.size(); t += 3) {
    const std::uint32_t v[3] = {m.triangles[t], m.triangles[t + 1], m.triangles[t + 2]};
    for (int k = 0; k < 3; ++k) {
      ++directed[{v[k], v[(k + 1) % 3]}];
      root[find(v[k])] = find(v[(k + 1) % 3]);
      fan[v[k]][v[(k + 1) % 3]] = v[(k + 2) % 3];
      ++valence[v[k]];
    }
    const Vec3d a = cast<double>(m.position[v[0]]), b = cast<double>(m.position[v[1]]),
                c = cast<double>(m.position[v[2]]);
    const Vec3d normal = cross(b - a, c - a);
    r.smallest_area = std::min(r.smallest_area, 0.5 * length(normal));
    r.area += 0.5 * length(normal);
    for (const std::uint32_t k : v) sum[k] += normal;
  }
  for (const auto& [edge, count] : directed) {
    const auto other = directed.find({edge.second, edge.first});
    if (count != 1 || other == directed.end() || other->second != 1) ++r.open_edges;
  }
  std::map<std::uint32_t, std::size_t> number;
  for (std::uint32_t v = 0; v < n; ++v) {
    if (valence[v] == 0) {
      ++r.unused;
      continue;
    }
    std::uint32_t at = fan[v].begin()->first, steps = 0;
    do {
      const auto next = fan[v].find(at);
      if (next == fan[v].end()) break;
      at = next->second;
      ++steps;
    } while (at != fan[v].begin()->first && steps <= valence[v]);
    if (steps != valence[v]) ++r.split;
    const Vec3d normal = cast<double>(m.normal[v]);
    r.worst_normal = std::min(r.worst_normal, dot(normal, sum[v]) / length(sum[v]));
    number.try_emplace(find(v), number.size());
  }
  r.euler.assign(number.size(), 0);
  r.volumes.assign(number.size(), 0.0);
  for (std::uint32_t v = 0; v < n; ++v)
    if (valence[v] != 0) ++r.euler[number[find(v)]];
  for (const auto& [edge, count] : directed)
    if (edge.first < edge.second) --r.euler[number[find(edge.first)]];
  for (std::size_t t = 0; t + 2 < m.triangles.size(); t += 3) {
    const std::size_t c = number[find(m.triangles[t])];
    ++r.euler[c];
    const Vec3d a = cast<double>(m.position[m.triangles[t]]),
                b = cast<double>(m.position[m.triangles[t + 1]]),
                d = cast<double>(m.position[m.triangles[t + 2]]);
    r.volumes[c] += dot(a, cross(b, d)) / 6;
  }
  for (const double v : r.volumes) r.volume += v;
  return r;
}

/// Closed, one fan of triangles around every vertex, outward normals, no degenerate triangles. Vertices keep
/// 1/64 of a cell from its nodes: the smallest triangle cuts a corner off, 2e-4 cell^2, and smoothing makes
/// it larger; folds of thin films may make it smaller, hence 1e-5. worst_cosine: of a vertex normal and its
/// triangles.
inline MeshCheck expect_surface(const meltsim::SurfaceMesh& m, double cell, double worst_cosine = 0) {
  const MeshCheck c = check_mesh(m);
  EXPECT_EQ(m.position.size(), m.normal.size());
  EXPECT_EQ(m.position.size(), m.temperature.size());
  EXPECT_EQ(m.position.size(), m.liquid_fraction.size());
  EXPECT_EQ(m.position.size(), m.body.size());
  EXPECT_EQ(m.position.size(), m.material.size());
  EXPECT_FALSE(m.triangles.empty());
  EXPECT_EQ(c.open_edges, 0u);
  EXPECT_EQ(c.unused, 0u);
  EXPECT_EQ(c.split, 0u);
  EXPECT_GT(c.smallest_area, 1e-5 * cell * cell);
  EXPECT_GT(c.worst_normal, worst_cosine);
  for (const int euler : c.euler) EXPECT_TRUE(euler <= 2 && euler % 2 == 0) << euler;
  for (const meltsim::Vec3f& n : m.normal) EXPECT_NEAR(length(n), 1, 1e-5);  // single precision
  return c;
}

}  // namespace test_support
