// SPDX-License-Identifier: Apache-2.0
// Contents of species of a particle, and its saturation.
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/solute.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Mass fraction of species k at slot i [-].
template <class T>
MELTSIM_HD double fraction_at(const Frame<T>& w, std::uint32_t k, std::uint64_t i) {
  return solute_at(w, k, i) / static_cast<double>(w.f.mass[i]);
}

/// w_s of species k at the temperature of slot i [-]. Channels: species, and where that precipitates tag, enthalpy, mass,
/// materials, properties.
template <class T>
MELTSIM_HD double saturation_at(const Frame<T>& w, std::uint32_t k, std::uint64_t i) {
  const SpeciesRow<T>& s = w.f.species[k];
  if (!physics::precipitates(s)) return s.solubility;
  const double h = w.f.enthalpy[i] / static_cast<double>(w.f.mass[i]);
  return physics::saturation_at(s, physics::temperature_of(w.f.materials[material_of(w.f.tag[i])], h));
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
