// SPDX-License-Identifier: Apache-2.0
// Temperature-dependent material properties: piecewise linear tables, constant beyond their ends, and the
// enthalpy curve to which heat capacities integrate.
//
// Source: h(T) = integral of c dT (any text on heat, e.g. Carslaw & Jaeger 1959, sec. 1.6); the plateau of
// width L at the melting point as in Voller & Cross (1981), Int. J. Heat Mass Transfer 24:545; the range in its place as in
// Voller & Swaminathan (1991), Numer. Heat Transfer B 19:175.
//
//   symbol  meaning                                  unit
//   T       temperature                              degrees Celsius
//   c       specific heat capacity                   J/(kg K)
//   h       specific enthalpy, 0 for liquid at 0 C   J/kg
//
// Within a segment c is linear in T, so h is quadratic and T(h) has a closed form.
#pragma once

#include "meltsim/physics/flow_curve.hpp"
#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {
/// Most points of a table.
inline constexpr int property_points = 8;
/// Values at ascending temperatures; linear in between, constant beyond the ends.
template <class T>
struct PropertyTable {
  std::uint32_t points = 0;                                          ///< 0: the table is not used
  T temperature[property_points] = {}, value[property_points] = {};  ///< of the points
};
/// The property at a temperature [degrees Celsius].
template <class T>
MELTSIM_HD T property_at(const PropertyTable<T>& p, T temperature) {
  const std::uint32_t last = p.points - 1u;
  if (!(temperature > p.temperature[0])) return p.value[0];
  if (temperature >= p.temperature[last]) return p.value[last];
  std::uint32_t k = 0;
  while (temperature >= p.temperature[k + 1]) ++k;
  const T share = (temperature - p.temperature[k]) / (p.temperature[k + 1] - p.temperature[k]);
  return p.value[k] + share * (p.value[k + 1] - p.value[k]);
}
/// Most nodes of a curve.
inline constexpr int curve_nodes = 2 * property_points + 2;

/// h(T) as nodes in ascending order; between two nodes c is linear, from `above` of the lower to `below` of the
/// upper node. Two nodes at one temperature are a plateau.
struct EnthalpyCurve {
  std::uint32_t nodes = 0;                                           ///< 0: the curve is not used
  double temperature[curve_nodes] = {}, enthalpy[curve_nodes] = {};  ///< [degrees Celsius]; h [J/kg]
  double below[curve_nodes] = {}, above[curve_nodes] = {};  ///< c on either side of a node [J/(kg K)]
};

/// T(h) [degrees Celsius].
MELTSIM_HD double curve_temperature(const EnthalpyCurve& c, double h) {
  const std::uint32_t last = c.nodes - 1u;
  if (!(h > c.enthalpy[0])) return c.temperature[0] + (h - c.enthalpy[0]) / c.below[0];
  if (h >= c.enthalpy[last]) return c.temperature[last] + (h - c.enthalpy[last]) / c.above[last];
  std::uint32_t k = 0;
  while (h >= c.enthalpy[k + 1]) ++k;
  const double width = c.temperature[k + 1] - c.temperature[k];
  if (!(width > 0.0)) return c.temperature[k];
  const double e = h - c.enthalpy[k], slope = (c.below[k + 1] - c.above[k]) / width;
  const double root = std::sqrt(maximum(c.above[k] * c.above[k] + 2.0 * slope * e, 0.0));
  return c.temperature[k] + 2.0 * e / (c.above[k] + root);
}

/// h(T) [J/kg]; at the temperature of a plateau its lower end.
MELTSIM_HD double curve_enthalpy(const EnthalpyCurve& c, double temperature) {
  const std::uint32_t last = c.nodes - 1u;
  if (!(temperature > c.temperature[0])) return c.enthalpy[0] + (temperature - c.temperature[0]) * c.below[0];
  if (temperature > c.temperature[last])
    return c.enthalpy[last] + (temperature - c.temperature[last]) * c.above[last];
  std::uint32_t k = 0;
  while (temperature > c.temperature[k + 1]) ++k;
  const double width = c.temperature[k + 1] - c.temperature[k], t = temperature - c.temperature[k];
  if (!(width > 0.0)) return c.enthalpy[k];
  return c.enthalpy[k] + t * (c.above[k] + 0.5 * (c.below[k + 1] - c.above[k]) * t / width);
}

/// Tables of a material, beside its row, if any of its properties depends on temperature or shear rate.
template <class T>
struct MaterialProperties {
  PropertyTable<T> conductivity;         ///< of the material's own phase [W/(m K)]
  PropertyTable<T> liquid_conductivity;  ///< of the liquid it becomes [W/(m K)]
  PropertyTable<T> viscosity;            ///< [Pa s]
  PropertyTable<T> density;              ///< rest density of a liquid [kg/m^3]
  PropertyTable<T> yield_stress;         ///< of a liquid [Pa]; in place of that of `flow`
  EnthalpyCurve curve;                   ///< in use when nodes > 0
  FlowCurve<T> flow;                     ///< in use when index > 0
};

/// Integral of c from 0 degrees to T (host) [J/kg].
inline double capacity_integral(const PropertyTable<double>& c, double temperature) {
  const double low = minimum(0.0, temperature), high = maximum(0.0, temperature);
  double sum = 0, at = low, value = property_at(c, low);
  for (std::uint32_t k = 0; k <= c.points; ++k) {
    const double next = k < c.points ? clamp(c.temperature[k], low, high) : high;
    if (!(next > at)) continue;
    const double v = property_at(c, next);
    sum += 0.5 * (value + v) * (next - at);
    at = next;
    value = v;
  }
  return temperature < 0 ? -sum : sum;
}

/// The curve of a substance that stays in its phase (host).
inline EnthalpyCurve make_enthalpy_curve(const PropertyTable<double>& c) {
  EnthalpyCurve e;
  for (std::uint32_t k = 0; k < c.points; ++k) {
    e.temperature[k] = c.temperature[k];
    e.enthalpy[k] = capacity_integral(c, c.temperature[k]);
    e.below[k] = e.above[k] = c.value[k];
  }
  e.nodes = c.points;
  return e;
}

/// At which temperatures a substance melts, and what that takes.
struct Melting {
  double point = 0;        ///< T_s, where it begins [degrees Celsius]
  double range = 0;        ///< T_l - T_s [K], 0 where it begins and ends at one temperature
  double latent_heat = 0;  ///< L [J/kg]
};

/// What melting takes from T_s to T_l (host) [J/kg]: L, and what warms a substance that is half solid and half liquid in the mean.
inline double melting_heat(const PropertyTable<double>& solid, const PropertyTable<double>& liquid,
                           const Melting& m) {
  if (m.range == 0) return m.latent_heat;
  const auto over_range = [&m](const PropertyTable<double>& c) {
    return capacity_integral(c, m.point + m.range) - capacity_integral(c, m.point);
  };
  return m.latent_heat + 0.5 * (over_range(solid) + over_range(liquid));
}

/// The curve of a substance that melts: solid capacity up to T_s, melting, liquid capacity from T_l on (host).
inline EnthalpyCurve make_enthalpy_curve(const PropertyTable<double>& solid,
                                         const PropertyTable<double>& liquid, const Melting& m) {
  EnthalpyCurve e;
  const double end = m.point + m.range, melted = capacity_integral(liquid, end);
  const double heat = melting_heat(solid, liquid, m);
  const auto add = [&e](double t, double h, double below, double above) {
    e.temperature[e.nodes] = t;
    e.enthalpy[e.nodes] = h;
    e.below[e.nodes] = below;
    e.above[e.nodes++] = above;
  };
  const double shift = melted - heat - capacity_integral(solid, m.point);
  for (std::uint32_t k = 0; k < solid.points; ++k)
    if (solid.temperature[k] < m.point)
      add(solid.temperature[k], shift + capacity_integral(solid, solid.temperature[k]), solid.value[k],
          solid.value[k]);
  const double c_solid = property_at(solid, m.point), c_liquid = property_at(liquid, end);
  const double within = m.range > 0 ? heat / m.range : 0;  // a plateau has no capacity, and none is asked for
  add(m.point, melted - heat, c_solid, m.range > 0 ? within : c_solid);
  add(end, melted, m.range > 0 ? within : c_liquid, c_liquid);
  for (std::uint32_t k = 0; k < liquid.points; ++k)
    if (liquid.temperature[k] > end)
      add(liquid.temperature[k], capacity_integral(liquid, liquid.temperature[k]), liquid.value[k],
          liquid.value[k]);
  return e;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
