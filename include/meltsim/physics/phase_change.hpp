// SPDX-License-Identifier: Apache-2.0
// When a lattice particle becomes liquid.
//
// Source: Shao & Yu (2017), sec. 2: a surface boundary particle (SBP, fewer than 27 direct neighbours) that
// reaches its melting point turns liquid; an internal one (IBP) never does, so solids melt from the outside
// in. Deviation: with latent heat the criterion is liquid fraction 1; an IBP may hold more than that and
// leaves as soon as it is exposed. L = 0 reproduces the paper's T >= T_melt. Mass, momentum and enthalpy are
// untouched; the rest volume goes over to m/rho0 of the liquid, smoothly, so that a solid much denser than
// its liquid does not explode.
#pragma once

#include "meltsim/physics/heat.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

template <class T>
MELTSIM_HD bool melts(const MaterialRow<T>& m, bool surface, double h) {
  return m.melts != 0u && surface && liquid_fraction(m, h) >= 1.0;
}

/// Freezing is the inverse: liquid beside a free site of the lattice that holds no melting enthalpy any more.
template <class T>
MELTSIM_HD bool freezes(const MaterialRow<T>& m, double h) {
  return m.freezes != 0u && liquid_fraction(m, h) <= 0.0;
}

/// Rest volume on its way to m/rho0 [m^3]; share = dt / relaxation time. Once within rounding it is exact.
template <class T>
MELTSIM_HD T relaxed_volume(T volume, T target, T share) {
  const T gap = target - volume;
  if (std::fabs(gap) <= T(1e-5) * target) return target;
  return volume + gap * minimum(share, T(1));
}

/// Relaxation time in units of H/c: a tenfold change of volume then moves the surroundings far below the
/// sound speed.
inline constexpr double volume_relaxation = 40.0;

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
