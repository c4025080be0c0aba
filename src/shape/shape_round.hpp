// SPDX-License-Identifier: Apache-2.0
// Helpers of the curved primitives.
#pragma once

#include <cmath>

#include "shape/shape_node.hpp"

namespace meltsim {
inline namespace v0 {

inline double magnitude(Vec3d v) { return maximum(std::abs(v.x), maximum(std::abs(v.y), std::abs(v.z))); }

/// Half extents of the disc of the given radius across a unit axis.
inline Vec3d disc_extent(Vec3d unit_axis, double radius) {
  const auto across = [](double c) { return std::sqrt(maximum(0.0, 1 - c * c)); };
  return Vec3d{across(unit_axis.x), across(unit_axis.y), across(unit_axis.z)} * radius;
}

inline Vec3d unit(Vec3d v) { return v * (1 / length(v)); }

}  // namespace v0
}  // namespace meltsim
