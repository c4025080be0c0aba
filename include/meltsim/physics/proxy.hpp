// SPDX-License-Identifier: Apache-2.0
// A proxy: a rigid body of the host's physics engine, with the mass and inertia that the host gives, moved in every
// sub-step by what acts on it here, so that the liquid meets a body that gives way.
//
// Sources: rigid body as rigid_piece.hpp. Why it moves within the host's step: a body that is held still for a step of the
// host and then given the impulse of that step diverges where the added mass of the liquid exceeds its own mass (Causin,
// Gerbeau & Nobile 2005, Comput. Methods Appl. Mech. Eng. 194:4506). Here the acceleration answers the force within the
// sub-step, as that of any rigid body here does, whatever the step of the host is.
//
//   symbol   meaning                                                                       unit
//   M, I     mass; inertia about the centre of mass in the lattice as built                kg, kg m^2
//   x, R     centre of mass, orientation relative to the body as built                     m, -
//   v, w     velocity of the centre of mass, angular velocity                              m/s, rad/s
//   J, L     impulse and angular impulse about x in a sub-step: pressure, viscosity,
//            contact, not gravity                                                          N s, N m s
//   g, a     gravity; acceleration by the host's own forces                               m/s^2
//   dx, dr   what the host's pose was ahead of the proxy's, over the step of the host      m/s, rad/s
//
//   M v' = M v + J + M (g + a) dt, and the rotation of rigid_piece.hpp under R I R^T w, then + L;
//   x' = x + (v + v') dt/2 + dx dt,  R' = exp(dr dt) R.
//
// A host that adds J/M, L and its own forces to its body gets v' and w'. Its pose differs from x', R' by what its
// integrator differs in, and by what its own contacts do; that gap is closed at constant rates over its next step. The
// rates move the body and are no part of its velocity. They move no point of it faster than a tenth of the sound speed,
// which is what liquid itself moves at most at; what is left of the gap then waits for the next state.
//
// RigidMotion holds the state of a proxy as: first = x, R, v, w; then.velocity, then.angular_velocity = dx, dr, until
// `until`; then.position = a.
#pragma once

#include "meltsim/physics/rigid_piece.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// What the speed at which a gap is closed is at most, over the sound speed [-].
inline constexpr double largest_closing_mach = 0.1;

/// The share of a sub-step of dt from `time` in which the gap to the host's pose is still closed [s].
MELTSIM_HD double closing_time(const RigidMotion& m, double time, double dt) {
  return clamp(m.until - time, 0.0, dt);
}

/// The step of a proxy; positions are relative to its centre of mass at the beginning. rest: that centre in the lattice as
/// built, from the vertex that those of its points are relative to [m].
MELTSIM_HD RigidPieceStep proxy_step(double mass, const Mat3<double>& inertia, Vec3<double> rest,
                                     const RigidMotion& m, Vec3<double> impulse, Vec3<double> angular_impulse,
                                     Vec3<double> gravity, double time, double dt) {
  const RigidPlace& p = m.first;
  const Vec3<double> middle = p.velocity * (0.5 * dt);
  RigidPieceSums s;
  s.mass = mass;
  s.first = middle * mass;
  s.rest_first = rest * mass;
  // Second moments about the reference vertex, of which the inertia about the centre is made again.
  const double trace = inertia.m[0][0] + inertia.m[1][1] + inertia.m[2][2];
  const double at[3] = {rest.x, rest.y, rest.z};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      s.rest_second.m[i][j] = (i == j ? 0.5 * trace : 0.0) - inertia.m[i][j] + mass * at[i] * at[j];
  const Vec3<double> turn =
      rotate(p.orientation, inertia * rotate(inverse(p.orientation), p.angular_velocity));
  s.momentum = p.velocity * mass;
  s.spin = turn + cross(middle, s.momentum);
  s.kicked_momentum = s.momentum + impulse + (gravity + m.then.position) * (mass * dt);
  s.kicked_spin = turn + angular_impulse + cross(middle, s.kicked_momentum);
  RigidPieceStep step = rigid_step(s, p.orientation, dt);
  const double closing = closing_time(m, time, dt);
  if (closing > 0) {
    step.center += m.then.velocity * closing;
    step.rotation = composed(rotation_by(m.then.angular_velocity * closing), step.rotation);
  }
  return step;
}

/// The motion at the end of the sub-step.
MELTSIM_HD RigidMotion proxy_after(const RigidMotion& m, const RigidPieceStep& step, double time, double dt) {
  RigidMotion after = m;
  after.from = time + dt;
  after.first.position = m.first.position + (m.first.velocity + step.velocity) * (0.5 * dt) +
                         m.then.velocity * closing_time(m, time, dt);
  after.first.orientation = step.rotation;
  after.first.velocity = step.velocity;
  after.first.angular_velocity = step.angular_velocity;
  return after;
}

/// The motion from now on, as the host has it: its pose and twist in first, its acceleration in then.position, the end of
/// its step in until. jumps: the proxy is there at once. Otherwise no point within `reach` [m] of its centre closes the gap
/// faster than at `most` [m/s]. period: of periodic axes, 0 of others [m]; the gap is to the nearest image, since hosts keep poses in one period.
MELTSIM_HD RigidMotion proxy_set(const RigidMotion& now, const RigidMotion& host, bool jumps, double reach,
                                 double most, Vec3<double> period) {
  RigidMotion m = host;
  m.then.velocity = m.then.angular_velocity = {};
  m.then.orientation = {};
  if (jumps) return m;
  m.first.position = now.first.position;
  m.first.orientation = now.first.orientation;
  const double dt = host.until - host.from;
  if (!(dt > 0)) return m;
  const auto nearest = [](double d, double length) {
    return length > 0 ? d - length * std::rint(d / length) : d;
  };
  const Vec3<double> ahead = host.first.position - now.first.position;
  const Vec3<double> gap{nearest(ahead.x, period.x), nearest(ahead.y, period.y), nearest(ahead.z, period.z)};
  const Vec3<double> turn = rotation_vector(composed(host.first.orientation, inverse(now.first.orientation)));
  const double way = length(gap) + length(turn) * reach;
  const double share = way > most * dt ? most * dt / way : 1.0;
  m.then.velocity = gap * (share / dt);
  m.then.angular_velocity = turn * (share / dt);
  return m;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
