// SPDX-License-Identifier: Apache-2.0
// Mechanical and latent energy of one particle, the terms of the ledger and the totals.
//
// Source: a point mass in a uniform field, Landau & Lifshitz (1976), Mechanics, secs. 4-5; latent heat:
// Voller & Cross (1981), Int. J. Heat Mass Transfer 24:545. Always in double, whatever the precision of the
// state: the drift of the sums over a run is far smaller than the share of one particle.
//
//   symbol  meaning                                          unit
//   m       mass                                             kg
//   v, x    velocity; place                                  m/s, m
//   g       gravity                                          m/s^2
//   E_k     m v.v / 2                                        J
//   E_p     -m g.x: zero at x = 0                            J
//   E_l     m L f: latent heat taken up, f liquid fraction   J
//
// E_l is part of the enthalpy H = m h. A liquid has the L of the solid that melts into it, whether or not it can
// freeze; a material that neither melts nor results from melting has L = 0.
#pragma once

#include "meltsim/physics/heat.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// E_k [J].
MELTSIM_HD double kinetic_energy(double mass, Vec3<double> velocity) {
  return 0.5 * mass * dot(velocity, velocity);
}

/// E_p [J]. A shift of a body by s changes it by the E_p of a particle of the same mass at s.
MELTSIM_HD double potential_energy(double mass, Vec3<double> gravity, Vec3<double> place) {
  return -mass * dot(gravity, place);
}

/// E_l [J] at enthalpy H [J] of the particle.
template <class T>
MELTSIM_HD double latent_energy(const MaterialRow<T>& m, double mass, double enthalpy) {
  return mass * m.latent_heat * liquid_fraction(m, enthalpy / mass);
}
/// m L [J]: the same where all of it is liquid.
template <class T>
MELTSIM_HD double latent_energy_of_liquid(const MaterialRow<T>& m, double mass) {
  return mass * m.latent_heat;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
