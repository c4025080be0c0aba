// SPDX-License-Identifier: Apache-2.0
#include "description/material_values.hpp"

#include <algorithm>

namespace meltsim {
inline namespace v0 {

double least_value(const std::vector<PropertyPoint>& points, double otherwise) {
  for (const PropertyPoint& p : points)
    otherwise = &p == points.data() ? p.value : std::min(otherwise, p.value);
  return otherwise;
}

double largest_value(const std::vector<PropertyPoint>& points, double otherwise) {
  for (const PropertyPoint& p : points)
    otherwise = &p == points.data() ? p.value : std::max(otherwise, p.value);
  return otherwise;
}

physics::PropertyTable<double> table(const std::vector<PropertyPoint>& points) {
  physics::PropertyTable<double> t;
  for (const PropertyPoint& p : points) {
    t.temperature[t.points] = p.temperature;
    t.value[t.points++] = p.value;
  }
  return t;
}

bool shears(const MaterialDesc& m) { return largest_yield_stress(m) > 0 || m.flow_index != 1; }

double largest_yield_stress(const MaterialDesc& m) {
  return largest_value(m.yield_stress_points, m.yield_stress);
}
double largest_solubility(const MaterialDesc& m) { return largest_value(m.solubility_points, m.solubility); }
double least_solubility(const MaterialDesc& m) { return least_value(m.solubility_points, m.solubility); }
double largest_content(const MaterialDesc& m) { return m.solubility_points.empty() ? m.solubility : 1; }

}  // namespace v0
}  // namespace meltsim
