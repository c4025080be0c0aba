// SPDX-License-Identifier: Apache-2.0
// Lattice sites around a shape: where liquid may freeze onto a body. Host only, when a body is added.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Inclusive box of lattice sites.
struct SiteBox {
  std::int64_t low[3] = {}, high[3] = {};
  std::int64_t extent(int axis) const { return std::max<std::int64_t>(0, high[axis] - low[axis] + 1); }
  double sites() const { return double(extent(0)) * double(extent(1)) * double(extent(2)); }
};

inline SiteBox box_of(const std::vector<Vec3i>& points) {
  const Vec3i f = points.front();
  SiteBox b{{f.x, f.y, f.z}, {f.x, f.y, f.z}};
  for (const Vec3i& p : points) {
    const std::int64_t x[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; ++a) {
      b.low[a] = std::min(b.low[a], x[a]);
      b.high[a] = std::max(b.high[a], x[a]);
    }
  }
  return b;
}

/// Marks all sites within `steps` along one axis of a marked site.
inline void spread(std::vector<std::uint8_t>& marks, const std::int64_t n[3], int axis, std::int64_t steps) {
  const std::int64_t stride[3] = {1, n[0], n[0] * n[1]};
  const std::int64_t lines = n[(axis + 1) % 3], rows = n[(axis + 2) % 3], length = n[axis];
  std::vector<std::uint8_t> out(static_cast<std::size_t>(length));
  for (std::int64_t u = 0; u < lines; ++u)
    for (std::int64_t t = 0; t < rows; ++t) {
      const std::int64_t base = u * stride[(axis + 1) % 3] + t * stride[(axis + 2) % 3];
      const auto at = [&](std::int64_t k) -> std::uint8_t& {
        return marks[static_cast<std::size_t>(base + k * stride[axis])];
      };
      std::int64_t since = steps + 1;  // steps since the last mark
      for (std::int64_t k = 0; k < length; ++k) {
        since = at(k) != 0 ? 0 : std::min(since + 1, steps + 1);
        out[static_cast<std::size_t>(k)] = since <= steps ? 1 : 0;
      }
      since = steps + 1;
      for (std::int64_t k = length; k-- > 0;) {
        since = at(k) != 0 ? 0 : std::min(since + 1, steps + 1);
        if (since <= steps) out[static_cast<std::size_t>(k)] = 1;
      }
      for (std::int64_t k = 0; k < length; ++k) at(k) = out[static_cast<std::size_t>(k)];
    }
}

/// Sites within `steps` lattice steps (diagonal ones count as one) of the points and inside the box, without
/// the points; x fastest.
inline std::vector<Vec3i> growth_sites(const std::vector<Vec3i>& points, std::int64_t steps,
                                       const SiteBox& box) {
  const std::int64_t n[3] = {box.extent(0), box.extent(1), box.extent(2)};
  std::vector<std::uint8_t> marks(static_cast<std::size_t>(n[0] * n[1] * n[2]), 0);
  const auto index = [&](const Vec3i& p) {
    return static_cast<std::size_t>((p.x - box.low[0]) +
                                    n[0] * ((p.y - box.low[1]) + n[1] * (p.z - box.low[2])));
  };
  for (const Vec3i& p : points) marks[index(p)] = 1;
  for (int axis = 0; axis < 3; ++axis) spread(marks, n, axis, steps);
  for (const Vec3i& p : points) marks[index(p)] = 0;
  std::vector<Vec3i> sites;
  for (std::int64_t z = 0; z < n[2]; ++z)
    for (std::int64_t y = 0; y < n[1]; ++y)
      for (std::int64_t x = 0; x < n[0]; ++x)
        if (marks[static_cast<std::size_t>(x + n[0] * (y + n[1] * z))] != 0)
          sites.push_back({static_cast<std::int32_t>(x + box.low[0]),
                           static_cast<std::int32_t>(y + box.low[1]),
                           static_cast<std::int32_t>(z + box.low[2])});
  return sites;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
