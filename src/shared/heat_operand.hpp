// SPDX-License-Identifier: Apache-2.0
// Operands of a particle for the exchange of heat with its neighbours.
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/heat_boundary.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Marks the resistivity of a particle that changes phase, or is about to: so far below zero that its sum with any other is below zero, too,
/// except with infinity.
template <class T>
MELTSIM_HD T marked(T resistivity) {
  return -minimum(resistivity, T(0x1p40)) * T(0x1p80);
}
template <class T>
MELTSIM_HD T unmarked(T resistivity) {
  return resistivity < T(0) ? -resistivity * T(0x1p-80) : resistivity;
}

/// Temperature and resistivity at an enthalpy [J]; share: physics::conduction_share; at_front: a solid at its body's surface, where melting
/// begins, or liquid beside a body of what it freezes to, where freezing does.
template <class T>
MELTSIM_HD HeatOperand<T> operand_at(const MaterialRow<T>& m, double enthalpy, T mass, T share,
                                     bool at_front) {
  const double h = enthalpy / static_cast<double>(mass);
  const T temperature = static_cast<T>(physics::temperature_of(m, h));
  const T fraction = static_cast<T>(physics::liquid_fraction(m, h));
  const T r = share * physics::resistivity_of(physics::conductivity_at(m, fraction, temperature));
  const bool begins = at_front && (fraction < T(1) ? m.melts : m.freezes) != 0u;
  const bool changes = begins || (fraction > T(0) && fraction < T(1));
  return {temperature, changes ? marked(r) : r};
}

/// Whether a particle is solid and at the surface of its body.
MELTSIM_HD bool exposed(std::uint32_t tag) { return is_solid(tag) && (tag & tag_surface) != 0u; }

/// Heat through a surface into a particle at a depth [m] beneath it, of the conductivity k [W/(m K)] that its liquid fraction gives: where the
/// particle changes phase, of that towards the surface.
template <class T>
MELTSIM_HD physics::SurfaceRate<T> heat_through(const physics::SurfaceCondition<T>& c, T area, T depth,
                                                const MaterialRow<T>& m, const HeatOperand<T>& own, T k) {
  if (own.resistivity < T(0))
    k = physics::conductivity_toward(m, own.temperature,
                                     physics::facing_temperature(c, k / depth, own.temperature));
  return physics::surface_heat(c, area, depth, k, own.temperature);
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
