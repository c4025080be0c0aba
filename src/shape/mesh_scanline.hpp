// SPDX-License-Identifier: Apache-2.0
// Where lines parallel to an axis cross a triangle. A line is named by its (u, v) in the plane across.
//
// Meshes stay watertight without exact arithmetic: a line of constant v crosses an edge if exactly one end
// lies above it, and where is computed from the lower end to the upper end, so that both triangles of an edge
// get the same bits. Along that line a triangle covers [left.u, right.u), and neighbours tile it exactly.
#pragma once

#include <utility>

#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

/// A corner seen along an axis: u, v across, w along.
struct Projected {
  double u, v, w;
};

template <int axis>
Projected project(Vec3d p) {
  if constexpr (axis == 0) return {p.y, p.z, p.x};
  if constexpr (axis == 1) return {p.z, p.x, p.y};
  if constexpr (axis == 2) return {p.x, p.y, p.z};
}

/// The piece of a line of constant v that a triangle covers, u in [left.u, right.u).
struct Span {
  double left_u, left_w, right_u, right_w;
  int facing;  ///< 1: its normal, by the order of its corners, points along w, else -1

  /// Depth at a u inside the piece.
  double depth(double u) const { return left_w + (u - left_u) / (right_u - left_u) * (right_w - left_w); }
};

/// False where the line misses the triangle.
inline bool scan(const Projected (&corner)[3], double v, Span& span) {
  double u[2] = {0, 0}, w[2] = {0, 0};
  bool up[2] = {false, false};
  int found = 0;
  for (int i = 0; i < 3; ++i) {
    const Projected &a = corner[i], &b = corner[i == 2 ? 0 : i + 1];
    if ((a.v > v) == (b.v > v)) continue;
    const Projected& low = a.v < b.v ? a : b;
    const Projected& high = a.v < b.v ? b : a;
    const double t = (v - low.v) / (high.v - low.v);
    u[found] = low.u + t * (high.u - low.u);
    w[found] = low.w + t * (high.w - low.w);
    up[found] = a.v < b.v;
    ++found;  // Signs around a triangle change zero times or twice.
  }
  if (found == 0) return false;
  const int left = u[1] < u[0] ? 1 : 0;
  span = {u[left], w[left], u[1 - left], w[1 - left], up[1 - left] ? 1 : -1};
  return true;
}

}  // namespace v0
}  // namespace meltsim
