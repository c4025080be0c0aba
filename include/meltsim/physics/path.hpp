// SPDX-License-Identifier: Apache-2.0
// A path through points at given times: straight, at constant speed from one to the next, at rest before the first and after the last.
//
//   x(t) = x_k + (x_{k+1} - x_k) (t - t_k)/(t_{k+1} - t_k)    t_k <= t < t_{k+1}
//
//   x_k  displacement at point k    m
//   t_k  time of it                 s
//
// Bodies turn on it as well: by an angle about one axis, which goes from point to point as the displacement does.
//
// What moves along it spends a step at many places. It is looked for at places that are at most a given distance apart, each of which
// stands for its share of the time: the midpoint rule, per straight part of the path.
#pragma once

#include <cmath>
#include <cstdint>

#include "meltsim/physics/hd.hpp"
#include "meltsim/physics/rigid_motion.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Most places that one straight part of a path has in a step: however fast something is, that is over soon.
inline constexpr double most_places = 4096;

/// How many points of a path are at or before time t: x(t) lies behind the last of them. In ascending order of time.
template <class Point>
MELTSIM_HD std::uint32_t points_until(const Point* path, std::uint32_t points, double t) {
  std::uint32_t low = 0, high = points;  // those below low are, those from high on are not
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (path[middle].time <= t) low = middle + 1;
    else high = middle;
  }
  return low;
}

/// The same of values at times, of which there is at least one.
MELTSIM_HD double value_at(const TimedValue* values, std::uint32_t count, double t) {
  const std::uint32_t k = points_until(values, count, t);
  if (k == 0) return values[0].value;
  if (k == count) return values[count - 1].value;
  const TimedValue &a = values[k - 1], &b = values[k];
  return a.value + (b.value - a.value) * ((t - a.time) / (b.time - a.time));
}

/// x(t). path: at least one point.
MELTSIM_HD Vec3d displacement_at(const PathPoint* path, std::uint32_t points, double t) {
  const std::uint32_t k = points_until(path, points, t);
  if (k == 0) return path[0].displacement;
  if (k == points) return path[points - 1].displacement;
  const PathPoint &a = path[k - 1], &b = path[k];
  return a.displacement + (b.displacement - a.displacement) * ((t - a.time) / (b.time - a.time));
}

/// visit(displacement, share) for the places of a straight move that takes `share` of a step.
template <class Visit>
MELTSIM_HD void for_each_place_between(Vec3d first, Vec3d move, double share, double apart,
                                       const Visit& visit) {
  const double wanted = std::ceil(length(move) / apart), n = wanted < 1             ? 1
                                                             : wanted < most_places ? wanted
                                                                                    : most_places;
  for (double i = 0.5; i < n; i += 1) visit(first + move * (i / n), share / n);
}

/// visit(displacement, share) for the places that the path has from one time to another, at most `apart` [m] from each other; the shares
/// of the time add up to 1.
template <class Visit>
MELTSIM_HD void for_each_place(const PathPoint* path, std::uint32_t points, double from, double until,
                               double apart, const Visit& visit) {
  double t = from;
  for (std::uint32_t k = points_until(path, points, from); t < until; ++k) {
    const double next = k < points && path[k].time < until ? path[k].time : until,
                 share = (next - t) / (until - from);
    if (k == 0 || k >= points) {
      visit(path[k == 0 ? 0 : points - 1].displacement, share);
    } else {
      const PathPoint &a = path[k - 1], &b = path[k];
      const Vec3d move = b.displacement - a.displacement;
      const double whole = b.time - a.time;  // shares of it are finite, however short it is
      for_each_place_between(a.displacement + move * ((t - a.time) / whole), move * ((next - t) / whole),
                             share, apart, visit);
    }
    t = next;
  }
}

/// Motion of a body on a path about time t: from the point before t until the one after it, and on to the next. `built`: its pivot [m], from
/// where positions are counted; axis: of length 1.
MELTSIM_HD RigidMotion motion_on(const PosePoint* path, std::uint32_t points, Vec3d axis, Vec3d built,
                                 double t) {
  const auto place = [&](std::uint32_t k) {  // at point k, and its rates from there on
    RigidPlace p;
    p.position = built + path[k].displacement;
    p.orientation = rotation_by(axis * path[k].angle);
    if (k + 1 < points) {
      const double rate = 1 / (path[k + 1].time - path[k].time);
      p.velocity = (path[k + 1].displacement - path[k].displacement) * rate;
      p.angular_velocity = axis * ((path[k + 1].angle - path[k].angle) * rate);
    }
    return p;
  };
  const std::uint32_t k = points_until(path, points, t);
  RigidMotion m;
  m.from = path[k == 0 ? 0 : k - 1].time;
  m.until = path[k < points ? k : points - 1].time;
  m.first = place(k == 0 ? 0 : k - 1);
  m.then = place(k < points ? k : points - 1);
  if (k == 0) m.first.velocity = m.first.angular_velocity = {};  // it rests until the first point
  return m;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
