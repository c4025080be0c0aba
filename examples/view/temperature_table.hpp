// SPDX-License-Identifier: Apache-2.0
// Temperatures from what a custom stage sees of a particle: enthalpy and rest volume. Host and device.
#pragma once

#include <vector>

#include "meltsim/particle_tag.hpp"
#include "meltsim/physics/property_table.hpp"
#include "meltsim/world.hpp"

namespace view {

struct SubstanceCurve {
  double density = 1;  ///< [kg/m^3]; mass = density x rest volume
  meltsim::physics::EnthalpyCurve curve;
};

/// [degrees Celsius]
MELTSIM_HD double particle_temperature(const SubstanceCurve* curves, meltsim::ParticleTag tag,
                                       double enthalpy, double rest_volume) {
  const SubstanceCurve& s = curves[meltsim::material_of(tag)];
  return meltsim::physics::curve_temperature(s.curve, enthalpy / (s.density * rest_volume));
}

/// By the material index in a particle's tag.
std::vector<SubstanceCurve> substance_curves(const meltsim::World& world,
                                             const std::vector<meltsim::MaterialId>& materials);

}  // namespace view
