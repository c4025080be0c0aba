// SPDX-License-Identifier: Apache-2.0
// Rows of the material table, as the formulas need them.
#include <algorithm>
#include <cmath>

#include "description/validate.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/heat_boundary.hpp"
#include "meltsim/physics/surface_tension.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

namespace {

double conductivity_of(const MaterialDesc& d) {
  return d.diffusivity ? physics::conductivity_of(*d.diffusivity, d.density, d.heat_capacity)
                       : d.conductivity;
}

/// The points, or the constant as a table of one.
physics::PropertyTable<double> capacity_table(const MaterialDesc& d) {
  return d.heat_capacity_points.empty() ? table({{0, d.heat_capacity}}) : table(d.heat_capacity_points);
}

bool has_points(const MaterialDesc& d) {
  return !d.conductivity_points.empty() || !d.heat_capacity_points.empty() || !d.viscosity_points.empty() ||
         !d.density_points.empty() || shears(d);
}

bool has_tables(const physics::MaterialProperties<double>& p) {
  return p.conductivity.points != 0u || p.liquid_conductivity.points != 0u || p.viscosity.points != 0u ||
         p.density.points != 0u || p.yield_stress.points != 0u || p.curve.nodes != 0u || p.flow.index > 0;
}

}  // namespace

physics::FlowCurve<double> WorldImpl::flow_of(const MaterialDesc& m) const {
  if (!shears(m)) return {};
  return {largest_yield_stress(m), m.flow_index, m.regularisation,
          physics::largest_flow_rate(m.flow_index, sound_speed_, desc.spacing)};
}

/// The solid that material i freezes into; materials.size() if there is none.
std::size_t WorldImpl::freezes_into(std::size_t i) const {
  std::size_t s = 0;
  while (s < materials.size() && !(materials[s].freezes && materials[s].melts_into.index == i)) ++s;
  return s;
}

/// One per material, or none at all when no property depends on temperature or shear rate.
std::vector<physics::MaterialProperties<double>> WorldImpl::material_properties() const {
  std::vector<physics::MaterialProperties<double>> all;
  if (std::none_of(materials.begin(), materials.end(), has_points)) return all;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const bool freezes = freezes_into(i) < materials.size();
    const MaterialDesc& m = freezes ? materials[freezes_into(i)] : materials[i];  // whose curve it has
    const MaterialDesc& l = m.melts_into ? materials[m.melts_into.index] : m;
    physics::MaterialProperties<double> p;
    if (m.dissolves_in) {  // its heat capacity is the solvent's
      const MaterialDesc& solvent = materials[m.dissolves_in.index];
      p.conductivity = table(m.conductivity_points);
      if (!solvent.heat_capacity_points.empty())
        p.curve = physics::make_enthalpy_curve(capacity_table(solvent));
      all.push_back(p);
      continue;
    }
    p.conductivity = table(m.conductivity_points);
    p.liquid_conductivity = table(l.conductivity_points);
    p.viscosity = table(materials[i].viscosity_points);
    p.density = table(materials[i].density_points);
    if (shears(materials[i])) p.yield_stress = table(materials[i].yield_stress_points);
    p.flow = flow_of(materials[i]);
    if (!m.heat_capacity_points.empty() || !l.heat_capacity_points.empty()) {
      p.curve = m.melts_into
                    ? physics::make_enthalpy_curve(capacity_table(m), capacity_table(l), melting_of(m))
                    : physics::make_enthalpy_curve(capacity_table(m));
    }
    all.push_back(p);
  }
  return all;
}

/// The models without enthalpy have no latent heat.
physics::Melting WorldImpl::melting_of(const MaterialDesc& m) const {
  return {m.melting_point, m.melting_range, desc.heat.model == HeatModel::enthalpy ? m.latent_heat : 0.0};
}

/// What a material is as heat. m: whose enthalpy curve it has.
void WorldImpl::fill_heat(core::MaterialRow<double>& r, std::size_t i, const MaterialDesc& m) const {
  const MaterialDesc& own = materials[i];
  const MaterialDesc& l = m.melts_into ? materials[m.melts_into.index] : m;
  r.conductivity = conductivity_of(m);
  r.diffusivity = physics::diffusivity_of(conductivity_of(own), own.density, own.heat_capacity);
  r.liquid_conductivity = conductivity_of(l);
  const MaterialDesc& c = own.dissolves_in ? materials[own.dissolves_in.index] : m;
  r.heat_capacity = least_value(c.heat_capacity_points, c.heat_capacity);
  r.liquid_heat_capacity =
      own.dissolves_in ? r.heat_capacity : least_value(l.heat_capacity_points, l.heat_capacity);
  if (r.plateau != 0u) {
    const physics::Melting melting = melting_of(m);
    r.latent_heat = melting.latent_heat;
    r.melting_point = melting.point;
    r.melting_range = melting.range;
    r.melting_heat = physics::melting_heat(capacity_table(m), capacity_table(l), melting);
    r.melting_slope = melting.range > 0 ? melting.range / r.melting_heat : 0;
    r.melting_enthalpy =
        physics::capacity_integral(capacity_table(l), melting.point + melting.range) - r.melting_heat;
  }
  // A liquid that cannot freeze holds the latent heat of what melts into it none the less.
  for (const MaterialDesc& s : materials)
    if (r.plateau == 0u && r.latent_heat == 0 && s.melts_into && s.melts_into.index == i &&
        desc.heat.model == HeatModel::enthalpy)
      r.latent_heat = s.latent_heat;
}

core::MaterialRow<double> WorldImpl::material_row(std::size_t i) const {
  const MaterialDesc& own = materials[i];
  const bool freezes = freezes_into(i) < materials.size();
  core::MaterialRow<double> r;
  r.density = own.density;
  r.tait_stiffness = physics::tait_stiffness(own.density, sound_speed_);
  r.viscosity = own.viscosity;
  r.melts = own.melts_into ? 1u : 0u;
  r.freezes = freezes ? 1u : 0u;
  r.plateau = r.melts | r.freezes;
  r.liquid = own.melts_into     ? own.melts_into.index
             : own.dissolves_in ? own.dissolves_in.index
                                : static_cast<std::uint32_t>(i);
  r.solid = static_cast<std::uint32_t>(freezes ? freezes_into(i) : i);
  fill_heat(r, i, freezes ? materials[freezes_into(i)] : own);
  if (!properties_.empty() && has_tables(properties_[i])) r.tables = &properties_[i];
  r.coldest = physics::enthalpy_of(r, -physics::kelvin_offset);
  r.shape_stiffness = own.stiffness;
  r.modulus_rate = physics::modulus_rate(own.youngs_modulus, own.density, desc.spacing);
  r.shape_damping = own.damping;
  r.friction = own.friction;
  r.tension = own.surface_tension;
  r.cohesion = physics::cohesion_strength(own.surface_tension, core::support_of(desc));
  r.skin_viscosity = physics::skin_viscosity(own.surface_tension, own.density, desc.spacing);
  r.wetting = physics::wetting_cosine(own.contact_angle);
  return r;
}

std::vector<core::MaterialRow<double>> WorldImpl::material_rows() const {
  std::vector<core::MaterialRow<double>> rows;
  for (std::size_t i = 0; i < materials.size(); ++i) rows.push_back(material_row(i));
  return rows;
}

}  // namespace v0
}  // namespace meltsim
