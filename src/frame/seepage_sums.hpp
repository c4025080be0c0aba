// SPDX-License-Identifier: Apache-2.0
// Sums over the rims of the gaps between a piece and walls, and between pieces, in fixed point, which do not depend on the order of
// addition.
#pragma once

#include "frame/rigid_sums.hpp"
#include "meltsim/physics/gap.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Per axis: A in units of dx^2 2^-24, A p dt and A rho g.n dx dt in units of momentum.
struct RimSums {
  std::int64_t area[3] = {}, press[3] = {}, slope[3] = {};
};

/// The same of the gaps to other pieces, taken to the height of the label's particle; slope per length along gravity.
struct GapRimSums {
  std::int64_t area = 0, press = 0, slope = 0;
};

/// A particle of a body beside walls, per axis.
template <class T>
struct UnderSide {
  Vec3<T> area{};   ///< its side towards the near wall, where liquid may seep in [m^2]
  Vec3<T> force{};  ///< what liquid presses with there already, away from the wall [N]
};

/// The unit of area, in dx^2.
MELTSIM_HD SumUnit rim_area() { return {1.0 / 16777216, 16777216}; }

/// F_k . n of the gap at the wall of an axis [N].
template <class T>
MELTSIM_HD T seepage_of(const RimSums& s, const SumUnits& units, int axis, T under, T filled, T distance,
                        T spacing, T dt) {
  const double dx = static_cast<double>(spacing), force = units.momentum.size / static_cast<double>(dt);
  return physics::seepage_force(under, filled, static_cast<double>(s.area[axis]) * rim_area().size * dx * dx,
                                static_cast<double>(s.press[axis]) * force,
                                static_cast<double>(s.slope[axis]) * force / dx, distance, spacing);
}

/// Pressure [Pa] that a particle `below` [m] below the label's asks for in its pairs with other pieces.
template <class T>
MELTSIM_HD T gap_pressure_of(const GapRimSums& s, const SumUnits& units, T side, T filled, T below, T spacing,
                             T dt) {
  const double dx = static_cast<double>(spacing), force = units.momentum.size / static_cast<double>(dt);
  return physics::gap_pressure(side, filled, static_cast<double>(s.area) * rim_area().size * dx * dx,
                               static_cast<double>(s.press) * force,
                               static_cast<double>(s.slope) * force / dx, below);
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
