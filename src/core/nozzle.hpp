// SPDX-License-Identifier: Apache-2.0
// Where a nozzle's particles come out.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "meltsim/desc.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// v / |v|, of any length that is not zero: squares of its components may be beyond a double.
inline Vec3d unit(Vec3d v) {
  const double m = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  v = {v.x / m, v.y / m, v.z / m};
  return v * (1.0 / length(v));
}

/// Points of one layer, relative to the nozzle's centre. They lie at half-integers: a disc of radius R then holds about
/// pi R^2/dx^2 of them.
inline std::vector<Vec3d> nozzle_points(const EmitterDesc& e, double dx) {
  const Vec3d axis = unit(e.axis);
  const Vec3d helper = std::fabs(axis.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d u = unit(cross(axis, helper)), v = cross(axis, u);
  std::vector<Vec3d> disc;
  const int n = static_cast<int>(e.radius / dx) + 1;
  for (int b = -n; b < n; ++b)
    for (int a = -n; a < n; ++a) {
      const double s = (a + 0.5) * dx, t = (b + 0.5) * dx;
      if (s * s + t * t <= e.radius * e.radius) disc.push_back(u * s + v * t);
    }
  return disc;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
