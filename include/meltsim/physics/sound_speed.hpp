// SPDX-License-Identifier: Apache-2.0
// A sound speed that follows what moves, and the work that its changes do on compressed liquid.
//
// Sources: Monaghan (1994), J. Comput. Phys. 110:399, sec. 2.2: c is at least ten times the largest speed, so that density
// varies by 1 % (stagnation pressure rho v^2/2 = rho c^2 e; a column at rest rho g h = rho c^2 e); Price (2012), J. Comput.
// Phys. 231:759, sec. 2.2: internal energy of a barotropic gas, du = P/rho^2 drho.
//
//   symbol  meaning                                                             unit
//   B       specific head v^2/2 + g z of a particle, z above the lowest place   m^2/s^2
//   e       compression that is allowed, WorldDesc::density_error               -
//   c       sound speed, sqrt(B_max / e)                                        m/s
//   phi     volume fraction rho/rho0                                            -
//   u       specific internal energy: the Tait equation of fluid.hpp integrated
//           from rho0, c^2 (phi^6/6 + 1/phi - 7/6)/7; c^2 (phi - 1)^2/2 near 1  J/kg
//   W       work that a change of c does: sum of m u/c^2 over liquid, times
//           the change of c^2                                                   J
//
// Spray, particles with hardly a neighbour, does not count: what it hits is compressed where it hits, by up to 1/16 of its
// own head over least_sound_share^2 e.
// B is the same at every place of a free fall, so c has its value before what falls arrives: Bernoulli's theorem bounds the
// speed and the pressure that it can have. A jet that a closing gap throws out may exceed it, as it may exceed the speed
// that the derived sound speed goes by.
// Deviations: Monaghan's c is constant. Here it falls and rises in times that are several times as long as sound takes
// through the scene, so that liquid follows through states of rest; each particle's density then changes by no more than e.
#pragma once

#include <cmath>

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Least share of the derived sound speed that it falls to.
inline constexpr double least_sound_share = 0.25;
/// Passages of sound through the scene in which c grows e-fold.
inline constexpr double sound_rise = 4;
/// Passages of sound through the scene in which c falls e-fold: slower than it grows, for a splash cannot wait.
inline constexpr double sound_fall = 16;
/// Volume fraction below which liquid is spray: three particles beside each other have 0.36, a sheet of one layer 0.6.
inline constexpr double spray_filling = 0.4;
/// Sub-steps get longer by this factor at once, not less: a GPU records a sub-step anew for every length.
inline constexpr double sound_level = 1.0905077326652577;  // 2^(1/8)
/// Sub-steps between two looks at what moves.
inline constexpr unsigned sound_interval = 32;

/// v^2/2 - g.x [m^2/s^2]: the head of a particle, 0 at rest at the origin of x.
MELTSIM_HD double specific_head(Vec3<double> v, Vec3<double> gravity, Vec3<double> x) {
  return 0.5 * dot(v, v) - dot(gravity, x);
}

/// u/c^2 [-]; for phi below `lowest` liquid is not strained (fluid.hpp: tait_pressure).
MELTSIM_HD double compression_share(double phi, double lowest) {
  const double p = maximum(phi, lowest);
  if (!(p > 0)) return 0;
  return (p * p * p * p * p * p / 6 + 1 / p - 7.0 / 6) / 7;
}

/// c at which liquid of that head is compressed by no more than e [m/s]; 0 below the lowest place.
inline double sound_speed_of_head(double head, double density_error) {
  return head > 0 ? std::sqrt(head / density_error) : 0.0;
}

/// c a sub-step of dt later, on its way to `target` [m/s]; length: of the scene [m].
inline double approach(double c, double target, double dt, double length) {
  if (target > c) return std::fmin(target, c * (1 + c * dt / (sound_rise * length)));
  return std::fmax(target, c * (1 - std::fmin(0.5, c * dt / (sound_fall * length))));
}

/// The least of the speeds `highest` / sound_level^k that is no less than c [m/s].
inline double sound_level_of(double c, double highest) {
  if (!(c < highest)) return highest;
  const double k = std::floor(std::log(highest / c) / std::log(sound_level) * (1 + 1e-12));
  return std::fmax(c, highest * std::pow(sound_level, -k));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
