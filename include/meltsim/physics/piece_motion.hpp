// SPDX-License-Identifier: Apache-2.0
// A set of particles as one rigid body: its centre of mass, its inertia, and the motion that has its momentum and its
// angular momentum (Goldstein (1980), Classical Mechanics, secs. 1-2 and 5-3). Sums may be about any point o.
//
//   symbol  meaning                                        unit
//   u, v    position relative to o; velocity               m, m/s
//   q       position in the lattice as built, likewise     m
//   M       sum m                                          kg
//   c       sum m u / M                                    m
//   S       sum m u u^T                                    kg m^2
//   I       tr(S_c) 1 - S_c, S_c = S - M c c^T             kg m^2
//   L       sum m u x v - c x P, P = sum m v               kg m^2/s
//   omega   I^-1 L; 0 about axes without inertia           1/s
//   A       sum m (u - c) (q - c_q)^T                      kg m^2
#pragma once

#include "meltsim/physics/polar.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// I [kg m^2] from S.
MELTSIM_HD Mat3<double> inertia_about_center(double mass, Vec3<double> center, Mat3<double> second) {
  add_outer(second, -mass, center, center);
  const double trace = second.m[0][0] + second.m[1][1] + second.m[2][2];
  Mat3<double> inertia;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) inertia.m[i][j] = (i == j ? trace : 0.0) - second.m[i][j];
  return inertia;
}

/// omega [1/s] from sum m u x v and P.
MELTSIM_HD Vec3<double> angular_velocity_of(const Mat3<double>& inertia, Vec3<double> center,
                                            Vec3<double> momentum, Vec3<double> spin) {
  return solve_symmetric(inertia, spin - cross(center, momentum));
}

/// Rotation from the lattice as built, from sum m u q^T, sum m u and sum m q; where these leave it open, that of
/// `previous`.
MELTSIM_HD Quat<double> orientation_of(double mass, Mat3<double> products, Vec3<double> first,
                                       Vec3<double> rest, Quat<double> previous) {
  add_outer(products, -1.0 / mass, first, rest);
  return best_rotation(products, previous);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
