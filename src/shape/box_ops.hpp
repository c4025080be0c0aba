// SPDX-License-Identifier: Apache-2.0
// Growing a box around points and boxes. A box with min > max holds nothing.
#pragma once

#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

inline Box empty_box() { return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}}; }

inline void grow(Box& box, Vec3d p) {
  box.min = {minimum(box.min.x, p.x), minimum(box.min.y, p.y), minimum(box.min.z, p.z)};
  box.max = {maximum(box.max.x, p.x), maximum(box.max.y, p.y), maximum(box.max.z, p.z)};
}

inline void grow(Box& box, const Box& other) {
  grow(box, other.min);
  grow(box, other.max);
}

inline Box around(Vec3d center, Vec3d half) { return {center - half, center + half}; }

inline bool inverted(const Box& box) {
  return box.min.x > box.max.x || box.min.y > box.max.y || box.min.z > box.max.z;
}

}  // namespace v0
}  // namespace meltsim
