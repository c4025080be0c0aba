// SPDX-License-Identifier: Apache-2.0
// What the topology stages must find, by textbook searches over a list of coordinates.
#pragma once

#include <array>
#include <map>
#include <queue>
#include <set>
#include <tuple>

#include "modules/engine.hpp"

namespace modules_test {

using Point = std::array<int, 3>;

class LatticeOracle {
 public:
  LatticeOracle(const core::SceneLattice& l, const std::vector<std::uint32_t>& state) {
    for (std::uint32_t v = 0; v < l.vertex_site.size(); ++v) {
      const Vec3i p = l.vertex_coordinates[v];
      point_.push_back({p.x, p.y, p.z});
      body_.push_back(l.vertex_body[v]);
      if (state[v] == 1u) live_[{body_[v], point_[v]}] = v;
    }
  }
  bool live(std::uint32_t v) const { return live_.count({body_[v], point_[v]}) != 0; }

  /// Live direct neighbours, itself included; none of a vertex that is not live.
  std::uint32_t neighbour_mask(std::uint32_t v) const {
    std::uint32_t mask = 0;
    if (!live(v)) return mask;
    for (int bit = 0; bit < 27; ++bit)
      if (step(v, bit) != core::none) mask |= 1u << bit;
    return mask;
  }

  /// Breadth-first search of depth <= w; offsets of what it reaches.
  std::set<Point> region(std::uint32_t v, int w) const {
    std::set<Point> found;
    for (const auto& [u, depth] : search(v, w)) {
      static_cast<void>(depth);
      found.insert({point_[u][0] - point_[v][0], point_[u][1] - point_[v][1], point_[u][2] - point_[v][2]});
    }
    return found;
  }

  /// Smallest vertex connected to v.
  std::uint32_t piece(std::uint32_t v) const { return search(v, 1 << 30).begin()->first; }

 private:
  std::uint32_t step(std::uint32_t v, int bit) const {
    const Point& p = point_[v];
    const auto it = live_.find({body_[v], {p[0] + bit % 3 - 1, p[1] + bit / 3 % 3 - 1, p[2] + bit / 9 - 1}});
    return it == live_.end() ? core::none : it->second;
  }
  std::map<std::uint32_t, int> search(std::uint32_t v, int w) const {
    std::map<std::uint32_t, int> depth;
    if (!live(v)) return depth;
    std::queue<std::uint32_t> queue;
    queue.push(v);
    depth[v] = 0;
    while (!queue.empty()) {
      const std::uint32_t u = queue.front();
      queue.pop();
      if (depth[u] == w) continue;
      for (int bit = 0; bit < 27; ++bit) {
        const std::uint32_t n = step(u, bit);
        if (n == core::none || depth.count(n) != 0) continue;
        depth[n] = depth[u] + 1;
        queue.push(n);
      }
    }
    return depth;
  }
  std::vector<Point> point_;
  std::vector<std::uint32_t> body_;
  std::map<std::tuple<std::uint32_t, Point>, std::uint32_t> live_;
};

/// The offsets a region mask stands for.
inline std::set<Point> offsets(const core::LatticeMasks& m, std::uint32_t v, int w) {
  std::set<Point> found;
  for (std::uint32_t bit = 0; bit < m.region_words * 32; ++bit) {
    if (((m.region_mask[v * m.region_words + bit / 32] >> (bit % 32)) & 1u) == 0u) continue;
    const int side = 2 * w + 1, b = static_cast<int>(bit);
    found.insert({b % side - w, b / side % side - w, b / side / side - w});
  }
  return found;
}

}  // namespace modules_test
