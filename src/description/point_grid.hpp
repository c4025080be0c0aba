// SPDX-License-Identifier: Apache-2.0
// Host-side lookup "which points are nearer than a distance?", for building scenes. Not used in a step.
#pragma once

#include <algorithm>
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

/// Points with a number each, hashed by cells four times as wide as the distance of a query: most queries then meet one
/// cell.
class PointGrid {
 public:
  explicit PointGrid(double distance) : distance_(distance), inv_(0.25 / distance) {}
  PointGrid(const PointGrid&) = delete;
  PointGrid& operator=(const PointGrid&) = delete;
  std::size_t size() const { return size_; }
  void add(Vec3d p, std::uint32_t value) {
    const std::uint64_t where = key(cell(p.x), cell(p.y), cell(p.z));
    if (last_ == nullptr || where != last_key_) {  // neighbours in a row mostly share a cell
      last_ = &cells_[where];
      last_key_ = where;
    }
    last_->push_back({p, value});
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y), std::min(low_.z, p.z)};
    high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y), std::max(high_.z, p.z)};
    ++size_;
  }
  /// Calls visit(value) for every point nearer to p than the distance, until it returns true. Whether it did.
  template <class Visit>
  bool near(Vec3d p, const Visit& visit) const {
    if (outside(p)) return false;
    const double d = distance_;
    for (std::int64_t z = cell(p.z - d); z <= cell(p.z + d); ++z)
      for (std::int64_t y = cell(p.y - d); y <= cell(p.y + d); ++y)
        for (std::int64_t x = cell(p.x - d); x <= cell(p.x + d); ++x) {
          const auto found = cells_.find(key(x, y, z));
          if (found == cells_.end()) continue;
          for (const Entry& e : found->second) {
            const Vec3d r = e.point - p;
            if (dot(r, r) < d * d && visit(e.value)) return true;
          }
        }
    return false;
  }

 private:
  struct Entry {
    Vec3d point;
    std::uint32_t value;
  };
  /// Whether p is farther than the distance from the box of all points, where most points are that are asked for.
  bool outside(Vec3d p) const {
    const double d = 2 * distance_;  // rounding cannot bring it back
    return !(p.x > low_.x - d && p.y > low_.y - d && p.z > low_.z - d && p.x < high_.x + d &&
             p.y < high_.y + d && p.z < high_.z + d);
  }
  /// Points beyond 2^62 cells share the outermost one.
  std::int64_t cell(double x) const {
    constexpr double most = 4611686018427387904.0;
    return static_cast<std::int64_t>(std::max(-most, std::min(most, std::floor(x * inv_))));
  }
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    return (static_cast<std::uint64_t>(x) * 73856093u) ^ (static_cast<std::uint64_t>(y) * 19349663u) ^
           (static_cast<std::uint64_t>(z) * 83492791u);  // collisions only cost a few distance tests
  }
  double distance_, inv_;
  Vec3d low_{infinity, infinity, infinity}, high_{-infinity, -infinity, -infinity};
  std::size_t size_ = 0;
  std::unordered_map<std::uint64_t, std::vector<Entry>> cells_;
  std::vector<Entry>* last_ = nullptr;  ///< the cell of the point added last
  std::uint64_t last_key_ = 0;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
