// SPDX-License-Identifier: Apache-2.0
// Liquids whose viscosity depends on how fast they are sheared: yield stress, shear thinning and thickening.
//
// Sources: Herschel & Bulkley (1926), Kolloid-Z. 39:291, tau = tau_y + K gd^n; Bingham (1922): n = 1. Papanastasiou (1987),
// J. Rheol. 31:385, the exponential that leaves the viscosity finite where nothing is sheared:
//
//   mu(gd) = K gd^(n-1) + tau_y (1 - exp(-m gd))/gd
//
//   gd      shear rate sqrt(2 D:D), D the deviatoric rate of strain (strain_rate.hpp)   1/s
//   K       consistency; of a Newtonian liquid its viscosity                            Pa s^n
//   n       flow index: below 1 thins as it is sheared, above 1 thickens                -
//   tau_y   yield stress                                                                Pa
//   m       regularisation: below gd = 1/m what does not yield creeps                   s
//
// Deviations: in gd^(n-1) the rate counts at least 1/m, so that n < 1 has a largest viscosity, too; and, for n > 1, at most
// `largest_rate`, so that a step has a bound. Both are exact in between.
#pragma once

#include <cmath>
#include <limits>

#include "meltsim/physics/elementary.hpp"
#include "meltsim/physics/hd.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// How the viscosity of a liquid depends on the shear rate.
template <class T>
struct FlowCurve {
  T yield_stress{};    ///< tau_y [Pa]
  T index{};           ///< n [-]; 0: the viscosity does not depend on the shear rate
  T regularisation{};  ///< m [s]
  T largest_rate{};    ///< [1/s]
};

/// Share of the yield stress per shear rate, (1 - exp(-m gd))/gd [s]: m where nothing is sheared.
template <class T>
MELTSIM_HD T yielding(T regularisation, T rate) {
  const T x = regularisation * rate;
  return x < T(1e-3) ? regularisation * (T(1) - T(0.5) * x)
                     : static_cast<T>(1.0 - exponential(-static_cast<double>(x))) / rate;
}

/// mu [Pa s] of a liquid of this consistency at a shear rate >= 0 [1/s].
template <class T>
MELTSIM_HD T flow_viscosity(const FlowCurve<T>& c, T consistency, T rate) {
  T mu = consistency;
  if (c.index != T(1)) {
    const T least = T(1) / c.regularisation;
    const T counted = rate > least ? (rate < c.largest_rate ? rate : c.largest_rate) : least;
    mu *= static_cast<T>(power(static_cast<double>(counted), static_cast<double>(c.index - T(1))));
  }
  return c.yield_stress > T(0) ? mu + c.yield_stress * yielding(c.regularisation, rate) : mu;
}

/// Largest rate that n > 1 counts [1/s]: that at which neighbours pass each other at a tenth of the speed of sound, which is
/// as fast as a scene should get. Infinite for n <= 1.
inline double largest_flow_rate(double index, double sound_speed, double spacing) {
  return index > 1 ? 0.1 * sound_speed / spacing : std::numeric_limits<double>::infinity();
}

/// Largest mu [Pa s] at any rate: what steps are made for.
inline double largest_flow_viscosity(const FlowCurve<double>& c, double consistency) {
  const double rest = flow_viscosity(c, consistency, 0.0);
  return c.index > 1 ? std::fmax(rest, flow_viscosity(c, consistency, c.largest_rate)) : rest;
}

/// A bound of mu [Pa s] from below, up to the rate `fastest` [1/s]: without the yield stress.
inline double least_flow_viscosity(const FlowCurve<double>& c, double consistency, double fastest) {
  FlowCurve<double> thin = c;
  thin.yield_stress = 0;
  return std::fmin(flow_viscosity(thin, consistency, 0.0), flow_viscosity(thin, consistency, fastest));
}

/// Bingham number tau_y/(K (v/L)^n) [-]: how much of a flow at speed v [m/s] over a length L [m] is yield stress.
inline double bingham_number(double yield_stress, double consistency, double index, double speed,
                             double length) {
  return yield_stress / (consistency * std::pow(speed / length, index));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
