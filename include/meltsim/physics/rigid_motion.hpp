// SPDX-License-Identifier: Apache-2.0
// Rigid motion of a kinematic body: where it is at a time, and how fast its points move.
//
// Source: constant twist, Goldstein, Poole & Safko (2002), Classical Mechanics, ch. 4: a body that turns at the angular
// velocity omega for a time t turns by the rotation vector omega t, exp(omega t / 2) as a unit quaternion.
//
//   x   position of the pivot                               m
//   q   orientation relative to the body as built           -
//   v   velocity of the pivot                               m/s
//   w   angular velocity about the pivot                    rad/s
//
// Two segments: until a time the body moves at (v, w) from (x, q); from then on at (v', w') from (x', q'). Positions
// follow from the time, so no rounding adds up over sub-steps.
#pragma once

#include <cmath>

#include "meltsim/physics/elementary.hpp"
#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Position of the pivot, orientation, and their rates of change.
struct RigidPlace {
  Vec3<double> position{};          ///< of the pivot [m]
  Quat<double> orientation{};       ///< relative to the body as built
  Vec3<double> velocity{};          ///< of the pivot [m/s]
  Vec3<double> angular_velocity{};  ///< [rad/s]
};

/// The motion of a body as a function of time.
struct RigidMotion {
  double from = 0;   ///< `first` is its place then [s]
  double until = 0;  ///< `then` is its place then, and holds from then on [s]
  RigidPlace first;  ///< place at `from`, rates until `until`
  RigidPlace then;   ///< place at `until`, rates from then on
};

/// a after b.
MELTSIM_HD Quat<double> composed(const Quat<double>& a, const Quat<double>& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// The rotation by a rotation vector [rad].
MELTSIM_HD Quat<double> rotation_by(Vec3<double> angle) {
  const double half = 0.5 * length(angle);
  // sin(half)/half to the last bit where the series' next term, half^4/120, is below it.
  const SineCosine turned = sine_cosine(half);
  const double share = half > 1e-4 ? turned.sine / half : 1.0 - half * half / 6.0;
  return {turned.cosine, 0.5 * share * angle.x, 0.5 * share * angle.y, 0.5 * share * angle.z};
}

/// The shortest rotation vector of a unit quaternion [rad].
MELTSIM_HD Vec3<double> rotation_vector(Quat<double> q) {
  if (q.w < 0) q = {-q.w, -q.x, -q.y, -q.z};
  const Vec3<double> n{q.x, q.y, q.z};
  const double sine = length(n);
  return n * (sine > 1e-12 ? 2.0 * angle_of({sine, q.w}) / sine : 2.0);
}

/// Place after a time t [s] at constant rates.
MELTSIM_HD RigidPlace moved_on(const RigidPlace& p, double t) {
  const Vec3<double> angle = p.angular_velocity * t;
  const bool turns = angle.x != 0 || angle.y != 0 || angle.z != 0;
  return {p.position + p.velocity * t, turns ? composed(rotation_by(angle), p.orientation) : p.orientation,
          p.velocity, p.angular_velocity};
}

/// Place at a time [s].
MELTSIM_HD RigidPlace place_at(const RigidMotion& m, double time) {
  return time < m.until ? moved_on(m.first, time - m.from) : moved_on(m.then, time - m.until);
}

/// A point of a body.
struct RigidPoint {
  Vec3<double> position{};  ///< Where it is [m].
  Vec3<double> velocity{};  ///< How fast it moves [m/s].
};

/// The point that was at `rest` [m] from the pivot as built.
MELTSIM_HD RigidPoint point_of(const RigidPlace& p, Vec3<double> rest) {
  const Vec3<double> arm = rotate(p.orientation, rest);
  return {p.position + arm, p.velocity + cross(p.angular_velocity, arm)};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
