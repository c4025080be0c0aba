// SPDX-License-Identifier: Apache-2.0
// A rigid piece of a body: six degrees of freedom, moved by the sums over its particles.
//
// Sources: Goldstein, Poole & Safko (2002), Classical Mechanics, chs. 4 and 5; Austin, Krishnaprasad & Wang (1993),
// J. Comput. Phys. 107:105, for the rotation.
//
//   symbol    meaning                                                                     unit
//   u         position relative to a reference point, in the middle of the sub-step       m
//   q         position in the lattice as built, relative to the reference vertex          m
//   v, v'     velocity of a particle before and after the kick, v' = v + a dt             m/s
//   M, c, c_q sum m, sum m u / M, sum m q / M                                             kg, m, m
//   P, P'     sum m v, sum m v'                                                           kg m/s
//   L, L'     sum m u x v - c x P, likewise of v'                                         kg m^2/s
//   J, K      inertia about c_q in the lattice as built; its inverse                      kg m^2
//   R         rotation of the piece                                                       -
//   omega     R K R^T L'                                                                  rad/s
//   m         R^T L, angular momentum in the frame of the lattice                         kg m^2/s
//
// The sub-step. Particles have drifted by v dt/2 to u when forces are known (integrate.hpp). A drift changes neither P nor
// sum m u x v, because (u + v t) x v = u x v, so sums taken there are those of the piece before and after the kick. R turns
// freely by dt/2 under L, then by dt/2 under L'; the centre moves by P'/M dt/2; then
//   x = c + R (q - c_q),  velocity = P'/M + omega x R (q - c_q).
// These have the momentum P' and the angular momentum L' exactly, whatever R is, and distances are those of the lattice:
// rounding does not add up, because R is state and q is exact.
//
// Free rotation over t: the angular velocity w in the frame of the lattice with
//   w = K (m + m_1)/2,  m_1 = exp(-t w) m,  R_1 = R exp(t w),
// by fixed-point iteration. R_1 m_1 = R m: the angular momentum stays. m_1 - m = h (m + m_1)/2 x w with
// h = 2 tan(|w| t/2)/|w|, so m_1.K m_1 - m.K m = (m_1 - m).K (m_1 + m) = 2 h ((m + m_1)/2 x w).w = 0: the energy stays as
// well. The source has h = t; with this h a steady spin about an axis of inertia turns by exactly |w| t. The rule is
// symmetric in time, of second order.
//
// Where K is singular (a row of particles turns about itself without inertia, a single particle about any axis), K is the
// pseudo-inverse: nothing turns about such an axis. Deviation: a row that spins and is kicked across its plane of spin loses
// a share of (omega dt)^3/24 of that kick's angular momentum, because the row has turned by atan(omega dt/2) in the drift.
#pragma once

#include "meltsim/physics/piece_motion.hpp"
#include "meltsim/physics/rigid_motion.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Sums over the particles of a rigid piece.
struct RigidPieceSums {
  double mass = 0;                                ///< sum m [kg]
  Vec3<double> first{};                           ///< sum m u [kg m]
  Vec3<double> rest_first{};                      ///< sum m q [kg m]
  Mat3<double> rest_second{};                     ///< sum m q q^T [kg m^2]
  Vec3<double> momentum{}, spin{};                ///< sum m v [kg m/s], sum m u x v [kg m^2/s]
  Vec3<double> kicked_momentum{}, kicked_spin{};  ///< the same of v'
};

/// A rigid piece at the end of a sub-step.
struct RigidPieceStep {
  double mass = 0;                  ///< M [kg]; 0: there is no piece
  Vec3<double> center{};            ///< of mass, from the reference point in the middle of the sub-step [m]
  Vec3<double> rest_center{};       ///< c_q [m]
  Quat<double> rotation{};          ///< R
  Vec3<double> velocity{};          ///< of the centre of mass [m/s]
  Vec3<double> angular_velocity{};  ///< omega [rad/s]
};

/// The inverse of an inertia; the pseudo-inverse of a singular one.
MELTSIM_HD Mat3<double> inverse_inertia(const Mat3<double>& inertia) {
  const Vec3<double> x = solve_symmetric(inertia, Vec3<double>{1, 0, 0}),
                     y = solve_symmetric(inertia, Vec3<double>{0, 1, 0}),
                     z = solve_symmetric(inertia, Vec3<double>{0, 0, 1});
  Mat3<double> k;
  const Vec3<double> columns[3] = {x, y, z};
  for (int j = 0; j < 3; ++j) {
    k.m[0][j] = columns[j].x;
    k.m[1][j] = columns[j].y;
    k.m[2][j] = columns[j].z;
  }
  return k;
}

/// R_1 from R, K and the angular momentum L in space, which stays, after t [s].
MELTSIM_HD Quat<double> turned_freely(const Mat3<double>& K, Quat<double> R, Vec3<double> L, double t) {
  constexpr double most_turn = 0.25;  // [rad] per iteration: it gains a factor of 8 or more each time
  constexpr int most_parts = 64, most_rounds = 40;
  const double angle = length(K * rotate(inverse(R), L)) * std::fabs(t);
  if (!(angle > 0) || !std::isfinite(angle)) return R;
  const int parts = static_cast<int>(clamp(std::ceil(angle / most_turn), 1.0, double(most_parts)));
  const double dt = t / parts;
  for (int part = 0; part < parts; ++part) {
    const Vec3<double> m = rotate(inverse(R), L);
    Vec3<double> w = K * m;
    for (int round = 0; round < most_rounds; ++round) {
      const Vec3<double> next = K * ((m + rotate(rotation_by(w * -dt), m)) * 0.5), change = next - w;
      w = next;
      if (!(dot(change, change) > 1e-31 * dot(w, w))) break;
    }
    R = composed(R, rotation_by(w * dt));
  }
  const double norm = std::sqrt(R.w * R.w + R.x * R.x + R.y * R.y + R.z * R.z);
  return {R.w / norm, R.x / norm, R.y / norm, R.z / norm};
}

/// Moves a piece with the rotation R at the beginning of a sub-step of dt [s] to its end.
MELTSIM_HD RigidPieceStep rigid_step(const RigidPieceSums& s, const Quat<double>& R, double dt) {
  RigidPieceStep step;
  if (!(s.mass > 0)) return step;
  const double share = 1 / s.mass;
  const Vec3<double> center = s.first * share;
  step.mass = s.mass;
  step.rest_center = s.rest_first * share;
  step.velocity = s.kicked_momentum * share;
  step.center = center + step.velocity * (0.5 * dt);
  const Mat3<double> K = inverse_inertia(inertia_about_center(s.mass, step.rest_center, s.rest_second));
  const Vec3<double> before = s.spin - cross(center, s.momentum),
                     after = s.kicked_spin - cross(center, s.kicked_momentum);
  step.rotation = turned_freely(K, turned_freely(K, R, before, 0.5 * dt), after, 0.5 * dt);
  step.angular_velocity = rotate(step.rotation, K * rotate(inverse(step.rotation), after));
  return step;
}

/// The point of a piece that is at q in the lattice as built; its position is from the reference point.
MELTSIM_HD RigidPoint point_of(const RigidPieceStep& s, Vec3<double> q) {
  const Vec3<double> arm = rotate(s.rotation, q - s.rest_center);
  return {s.center + arm, s.velocity + cross(s.angular_velocity, arm)};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
