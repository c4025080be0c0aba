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

inline bool is_rectangle(const EmitterDesc& e) { return e.width != 0 || e.height != 0; }
/// A [m^2].
inline double nozzle_area(const EmitterDesc& e) {
  constexpr double pi = 3.14159265358979323846;
  return is_rectangle(e) ? e.width * e.height : pi * e.radius * e.radius;
}
/// Radius of the circle around the opening [m].
inline double nozzle_reach_across(const EmitterDesc& e) {
  return is_rectangle(e) ? 0.5 * std::hypot(e.width, e.height) : e.radius;
}

/// One layer of a nozzle, and the distance from layer to layer. A layer is a part of a lattice whose pitches make the area
/// per point A/n, so that n particles of dx^3 per layer carry the flux A v of liquid of rest density.
struct NozzleLayer {
  std::vector<Vec3d> points;  ///< relative to the nozzle's centre
  double distance = 0;        ///< n dx^3/A [m]
};

/// Directions across a nozzle: those of the sides of a rectangle.
struct NozzleAxes {
  Vec3d across, upright;
};
inline NozzleAxes nozzle_axes(const EmitterDesc& e) {
  const Vec3d axis = unit(e.axis);
  const Vec3d helper = is_rectangle(e) ? e.up : std::fabs(axis.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d across = unit(cross(axis, helper));
  return {across, cross(axis, across)};
}

namespace detail {

struct DiscPoint {
  double s = 0, t = 0, r2 = 0;  ///< in pitches
};

/// Points of a square lattice with its origin at (offset_s, offset_t), by distance from the centre, to beyond R.
inline std::vector<DiscPoint> disc_points(double radius, double offset_s, double offset_t) {
  std::vector<DiscPoint> points;
  const int n = static_cast<int>(radius) + 2;
  for (int b = -n; b <= n; ++b)
    for (int a = -n; a <= n; ++a) {
      const double s = a + offset_s, t = b + offset_t, r2 = s * s + t * t;
      if (r2 <= (radius + 1) * (radius + 1)) points.push_back({s, t, r2});
    }
  std::stable_sort(points.begin(), points.end(),
                   [](const DiscPoint& p, const DiscPoint& q) { return p.r2 < q.r2; });
  return points;
}

}  // namespace detail

/// Layer of a rectangular nozzle: one point per spacing along each side, rounded.
inline NozzleLayer rectangle_layer(const EmitterDesc& e, double dx) {
  const auto [u, v] = nozzle_axes(e);
  const auto count = [dx](double side) { return static_cast<int>(std::max(1L, std::lround(side / dx))); };
  const int across = count(e.width), upright = count(e.height);
  NozzleLayer layer;
  for (int b = 0; b < upright; ++b)
    for (int a = 0; a < across; ++a)
      layer.points.push_back(u * (e.width * ((a + 0.5) / across - 0.5)) +
                             v * (e.height * ((b + 0.5) / upright - 0.5)));
  layer.distance = double(layer.points.size()) * dx * dx * dx / nozzle_area(e);
  return layer;
}

/// Layer of a round nozzle: among the sets of lattice points within a circle around a cell's centre, a point or an edge's centre, the one
/// whose number is nearest to pi R^2/dx^2. Each is its own mirror image, so its centroid is the centre.
inline NozzleLayer nozzle_layer(const EmitterDesc& e, double dx) {
  if (is_rectangle(e)) return rectangle_layer(e, dx);
  const auto [u, v] = nozzle_axes(e);
  constexpr double pi = 3.14159265358979323846;
  const double radius = e.radius / dx,
               area = pi * radius * radius;  // golden hashes depend on the order of products
  std::vector<detail::DiscPoint> best;
  double least = infinity;
  constexpr double offsets[][2] = {{0.5, 0.5}, {0, 0}, {0.5, 0}};
  for (const auto& offset : offsets) {
    const auto points = detail::disc_points(radius, offset[0], offset[1]);
    for (std::size_t n = 1; n < points.size(); ++n) {
      if (points[n].r2 - points[n - 1].r2 < 1e-9) continue;  // as far from the centre: both or none
      const double off = std::fabs(std::log(double(n) / area));
      if (off >= least - 1e-12) continue;
      least = off;
      best.assign(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(n));
    }
  }
  NozzleLayer layer;
  layer.distance = dx * double(best.size()) / area;
  const double pitch = dx * std::sqrt(area / double(best.size()));
  for (const auto& p : best) layer.points.push_back(u * (p.s * pitch) + v * (p.t * pitch));
  return layer;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
