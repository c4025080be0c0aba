// SPDX-License-Identifier: Apache-2.0
// Liquid on its way through a nozzle.
//
// Sources: continuity of a stream that is slender, A v = const with v dv/ds = g (Eggers & Villermaux 2008, Rep. Prog.
// Phys. 71:036601, sec. 2); the growing particle is a mass source in the density sum of Price (2012), J. Comput. Phys.
// 231:759, sec. 3.
//
//   symbol  meaning                                                        unit
//   V       volume of a particle in the nozzle                             m^3
//   v       speed of the nozzle                                            m/s
//   g_s     gravity along its axis                                         m/s^2
//   R       its radius                                                     m
//   r       distance from the axis                                         m
//
// A particle that appears at its full volume beside others compresses them at once, and what the equation of state makes
// of that is thrown about. So it grows while it moves on by one spacing, and others make room.
// What leaves is a stream that gravity strains: dv/ds = g_s/v, hence u_r = -r/2 dv/ds. Without it a falling stream
// never narrows, since liquid that may not pull cannot draw itself together.
// Deviation: dv/ds is that of one radius downstream, where the stream is slender, so that it stays finite for slow ones.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Share of its volume with which a particle enters a nozzle.
inline constexpr double entering_share = 1.0 / 64;

/// V a step later: the whole dx^3 after a way of dx.
template <class T>
MELTSIM_HD T entering_volume(T volume, T spacing, T speed, T dt) {
  const T area = spacing * spacing;
  return minimum(volume + area * speed * dt, maximum(volume, area * spacing));
}

/// u_r, as a vector, of a particle that leaves at `across` from the axis [m/s].
template <class T>
MELTSIM_HD Vec3<T> converging_velocity(Vec3<T> across, T gravity_along, T speed, T radius) {
  const T v = std::sqrt(speed * speed + T(2) * std::fabs(gravity_along) * radius);
  return across * (T(-0.5) * gravity_along / v);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
