// SPDX-License-Identifier: Apache-2.0
// A push on a body as a whole: the change of velocity of its points by an impulse, or its motion set.
//
// Source: rigid-body impulse, Goldstein, Poole & Safko (2002), Classical Mechanics, ch. 5.
//
//   dv  = J/M + dw x (x - c)      change of velocity of a point at x       m/s
//   I dw = L                      I: inertia about the centre of mass c    kg m^2
//   J, L  impulse at c, angular impulse about c                            N s, N m s
//
// The body is deformable; a push changes its rigid motion and leaves what it does beside that.
#pragma once

#include "meltsim/physics/math.hpp"
#include "meltsim/physics/piece_motion.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Sums over particles at u [m] from a point of reference.
struct MassSums {
  double mass = 0;        ///< [kg]
  Vec3<double> first{};   ///< sum m u [kg m]
  Mat3<double> second{};  ///< sum m u u^T [kg m^2]
};

/// A rigid motion: velocity of the centre [m/s], angular velocity [rad/s], centre from the point of reference [m].
struct RigidPush {
  Vec3<double> velocity{};          ///< of the centre of mass [m/s]
  Vec3<double> angular_velocity{};  ///< about that [rad/s]
  Vec3<double> center{};            ///< of mass, from the point of reference [m]
};

/// What an impulse [N s] and an angular impulse [N m s] about the centre of mass change.
MELTSIM_HD RigidPush push_of(const MassSums& s, Vec3<double> impulse, Vec3<double> angular_impulse) {
  if (!(s.mass > 0)) return {};
  const Vec3<double> center = s.first * (1 / s.mass);
  return {impulse * (1 / s.mass),
          solve_symmetric(inertia_about_center(s.mass, center, s.second), angular_impulse), center};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
