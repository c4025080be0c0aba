// SPDX-License-Identifier: Apache-2.0
// Tables of the host, which are in double, rounded to the scalar of a World.
#pragma once

#include "engine/scene.hpp"
#include "frame/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class T>
physics::SurfaceCondition<T> round_condition(const physics::SurfaceCondition<double>& c) {
  return {static_cast<T>(c.temperature), static_cast<T>(c.flux), static_cast<T>(c.convection),
          static_cast<T>(c.emissivity), c.kind};
}

template <class T>
physics::ForceField<T> round_field(const physics::ForceField<double>& f) {
  physics::ForceField<T> r;
  r.on = f.on;
  r.kind = f.kind;
  r.region = f.region;
  r.liquid = f.liquid;
  r.bodies = f.bodies;
  r.power = f.power;
  r.center = cast<T>(f.center);
  for (int k = 0; k < 3; ++k) r.axes[k] = cast<T>(f.axes[k]);
  r.half = cast<T>(f.half);
  r.about = cast<T>(f.about);
  r.axis = cast<T>(f.axis);
  r.vector = cast<T>(f.vector);
  r.spin = cast<T>(f.spin);
  r.strength = static_cast<T>(f.strength);
  r.radius = static_cast<T>(f.radius);
  r.rate = static_cast<T>(f.rate);
  r.density = static_cast<T>(f.density);
  r.from = f.from;
  r.until = f.until;
  return r;
}

template <class T>
Inlet<T> round_inlet(const Inlet<double>& f) {
  Inlet<T> r;
  r.first_point = f.first_point;
  r.points = f.points;
  r.first_id = f.first_id;
  r.ids = f.ids;
  r.center = cast<T>(f.center);
  r.inwards = cast<T>(f.inwards);
  r.up = cast<T>(f.up);
  r.middle = static_cast<T>(f.middle);
  r.distance = static_cast<T>(f.distance);
  r.layer = static_cast<T>(f.layer);
  r.area = f.area;
  r.head = f.head;
  r.enthalpy = f.enthalpy;
  for (int k = 0; k < most_species; ++k) r.solute[k] = f.solute[k];
  r.mass = static_cast<T>(f.mass);
  r.volume = static_cast<T>(f.volume);
  r.tag = f.tag;
  r.on = f.on;
  r.velocity = cast<T>(f.velocity);
  r.due = f.due;
  return r;
}

template <class T>
physics::PropertyTable<T> round_table(const physics::PropertyTable<double>& p) {
  physics::PropertyTable<T> r;
  r.points = p.points;
  for (int k = 0; k < physics::property_points; ++k) {
    r.temperature[k] = static_cast<T>(p.temperature[k]);
    r.value[k] = static_cast<T>(p.value[k]);
  }
  return r;
}

template <class T>
physics::FlowCurve<T> round_curve(const physics::FlowCurve<double>& c) {
  return {static_cast<T>(c.yield_stress), static_cast<T>(c.index), static_cast<T>(c.regularisation),
          static_cast<T>(c.largest_rate)};
}

template <class T>
MaterialProperties<T> round_properties(const MaterialProperties<double>& p) {
  return {round_table<T>(p.conductivity), round_table<T>(p.liquid_conductivity), round_table<T>(p.viscosity),
          round_table<T>(p.density),      round_table<T>(p.yield_stress),        p.curve,
          round_curve<T>(p.flow)};
}

template <class T>
SpeciesRow<T> round_row(const SpeciesRow<double>& s) {
  return {s.solute,           s.solvent,        s.solubility,
          s.volume,           s.solvent_volume, s.diffusivity,
          s.heat_of_solution, s.log_viscosity,  static_cast<T>(s.surface_resistivity),
          s.saturation};
}

template <class T>
MaterialRow<T> round_row(const MaterialRow<double>& m) {
  MaterialRow<T> r;
  r.density = static_cast<T>(m.density);
  r.tait_stiffness = static_cast<T>(m.tait_stiffness);
  r.viscosity = static_cast<T>(m.viscosity);
  r.conductivity = static_cast<T>(m.conductivity);
  r.diffusivity = static_cast<T>(m.diffusivity);
  r.liquid_conductivity = static_cast<T>(m.liquid_conductivity);
  r.heat_capacity = m.heat_capacity;
  r.liquid_heat_capacity = m.liquid_heat_capacity;
  r.melting_point = m.melting_point;
  r.melting_range = m.melting_range;
  r.melting_enthalpy = m.melting_enthalpy;
  r.melting_heat = m.melting_heat;
  r.melting_slope = m.melting_slope;
  r.latent_heat = m.latent_heat;
  r.coldest = m.coldest;
  r.shape_stiffness = static_cast<T>(m.shape_stiffness);
  r.modulus_rate = static_cast<T>(m.modulus_rate);
  r.shape_damping = static_cast<T>(m.shape_damping);
  r.friction = static_cast<T>(m.friction);
  r.tension = static_cast<T>(m.tension);
  r.cohesion = static_cast<T>(m.cohesion);
  r.skin_viscosity = static_cast<T>(m.skin_viscosity);
  r.wetting = static_cast<T>(m.wetting);
  r.liquid = m.liquid;
  r.solid = m.solid;
  r.melts = m.melts;
  r.freezes = m.freezes;
  r.plateau = m.plateau;
  return r;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
