// SPDX-License-Identifier: Apache-2.0
#include "temperature_table.hpp"

namespace view {

namespace {

using meltsim::MaterialDesc;
using meltsim::physics::EnthalpyCurve;

meltsim::physics::PropertyTable<double> capacity(const MaterialDesc& material) {
  meltsim::physics::PropertyTable<double> table;
  for (const meltsim::PropertyPoint& point : material.heat_capacity_points) {
    table.temperature[table.points] = point.temperature;
    table.value[table.points++] = point.value;
  }
  if (table.points == 0) table.value[table.points++] = material.heat_capacity;
  return table;
}

}  // namespace

std::vector<SubstanceCurve> substance_curves(const meltsim::World& world,
                                             const std::vector<meltsim::MaterialId>& materials) {
  const bool latent = world.desc().heat.model == meltsim::HeatModel::enthalpy;
  const auto curve = [&](const MaterialDesc& m) -> EnthalpyCurve {
    if (!m.melts_into) return meltsim::physics::make_enthalpy_curve(capacity(m));
    const MaterialDesc melt = world.material(m.melts_into);
    return meltsim::physics::make_enthalpy_curve(
        capacity(m), capacity(melt), {m.melting_point, m.melting_range, latent ? m.latent_heat : 0.0});
  };
  std::vector<SubstanceCurve> curves(materials.size());
  for (const meltsim::MaterialId id : materials) {
    const MaterialDesc material = world.material(id);
    curves.at(id.index) = {material.density, curve(material)};
  }
  // Liquid that freezes has the curve of the solid that it freezes to.
  for (const meltsim::MaterialId id : materials) {
    const MaterialDesc material = world.material(id);
    if (material.freezes && material.melts_into) curves.at(material.melts_into.index).curve = curve(material);
  }
  return curves;
}

}  // namespace view
