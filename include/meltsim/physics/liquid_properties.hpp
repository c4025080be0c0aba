// SPDX-License-Identifier: Apache-2.0
// Properties of a liquid that depend on temperature: rest density, viscosity, flow curve. Tables: property_table.hpp, linear between
// their points, constant beyond them.
//
//   symbol  meaning                                         unit
//   h       specific enthalpy                               J/kg
//   T(h)    temperature (heat.hpp)                          degrees Celsius
//   rho0    density without pressure                        kg/m^3
//   mu      dynamic viscosity                               Pa s
//   tau_y   yield stress (flow_curve.hpp)                   Pa
#pragma once

#include "meltsim/physics/heat.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// rho0 [kg/m^3] of a liquid at specific enthalpy h; its variation is the source of buoyancy.
template <class T>
MELTSIM_HD T rest_density(const MaterialRow<T>& m, double h) {
  if (m.tables == nullptr || m.tables->density.points == 0u) return m.density;
  return property_at(m.tables->density, static_cast<T>(temperature_of(m, h)));
}

/// mu [Pa s] of a liquid at specific enthalpy h.
template <class T>
MELTSIM_HD T viscosity_at(const MaterialRow<T>& m, double h) {
  if (m.tables == nullptr || m.tables->viscosity.points == 0u) return m.viscosity;
  return property_at(m.tables->viscosity, static_cast<T>(temperature_of(m, h)));
}

/// Whether a liquid has a yield stress, at some temperature.
template <class T>
MELTSIM_HD bool yields(const MaterialRow<T>& m) {
  return m.tables != nullptr && m.tables->flow.yield_stress > T(0);
}

/// Flow curve of a liquid at specific enthalpy h: its yield stress is that at the temperature there. Of a material with tables.
template <class T>
MELTSIM_HD FlowCurve<T> flow_curve_at(const MaterialRow<T>& m, double h) {
  FlowCurve<T> flow = m.tables->flow;
  if (m.tables->yield_stress.points != 0u)
    flow.yield_stress = property_at(m.tables->yield_stress, static_cast<T>(temperature_of(m, h)));
  return flow;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
