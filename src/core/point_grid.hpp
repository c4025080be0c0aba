// SPDX-License-Identifier: Apache-2.0
// Host-side lookup "is there a point nearer than d?", for building scenes. Not used in a step.
#pragma once

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Particles closer than this share of the spacing occupy the same place.
inline constexpr double same_place = 0.9;

class PointGrid {
 public:
  explicit PointGrid(double cell) : inv_(1.0 / cell) {}
  void add(Vec3d p, std::uint32_t value) {
    cells_[key(cell(p.x), cell(p.y), cell(p.z))].push_back({p, value});
  }
  /// Value of a point nearer than d (d <= cell), or -1.
  std::int64_t near(Vec3d p, double d) const {
    for (std::int64_t z = cell(p.z) - 1; z <= cell(p.z) + 1; ++z)
      for (std::int64_t y = cell(p.y) - 1; y <= cell(p.y) + 1; ++y)
        for (std::int64_t x = cell(p.x) - 1; x <= cell(p.x) + 1; ++x) {
          const auto found = cells_.find(key(x, y, z));
          if (found == cells_.end()) continue;
          for (const Entry& e : found->second) {
            const Vec3d r = e.point - p;
            if (dot(r, r) < d * d) return e.value;
          }
        }
    return -1;
  }

 private:
  struct Entry {
    Vec3d point;
    std::uint32_t value;
  };
  std::int64_t cell(double x) const { return static_cast<std::int64_t>(std::floor(x * inv_)); }
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    return (static_cast<std::uint64_t>(x) * 73856093u) ^ (static_cast<std::uint64_t>(y) * 19349663u) ^
           (static_cast<std::uint64_t>(z) * 83492791u);  // collisions only cost a few distance tests
  }
  double inv_;
  std::unordered_map<std::uint64_t, std::vector<Entry>> cells_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
