// SPDX-License-Identifier: Apache-2.0
// Liquid in a nozzle.
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
// A particle that appears with its full volume would compress its neighbours at once, and their pressure would scatter
// them. So the volume grows while the particle moves by one spacing.
// Gravity strains the emitted stream: dv/ds = g_s/v, hence u_r = -r/2 dv/ds. Without this radial velocity a falling
// stream would never narrow, because liquid without tension does not contract.
// Deviation: dv/ds is taken one radius downstream, where the stream is slender; so it stays finite for slow streams.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Share of its volume with which a particle enters a nozzle.
inline constexpr double entering_share = 1.0 / 64;

/// V after a step [m^3]: dx^3 after a distance of dx.
template <class T>
MELTSIM_HD T entering_volume(T volume, T spacing, T speed, T dt) {
  const T area = spacing * spacing;
  return minimum(volume + area * speed * dt, maximum(volume, area * spacing));
}

/// u_r as a vector [m/s], of a particle that leaves at `across` [m] from the axis.
template <class T>
MELTSIM_HD Vec3<T> converging_velocity(Vec3<T> across, T gravity_along, T speed, T radius) {
  const T v = std::sqrt(speed * speed + T(2) * std::fabs(gravity_along) * radius);
  return across * (T(-0.5) * gravity_along / v);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
