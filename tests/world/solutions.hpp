// SPDX-License-Identifier: Apache-2.0
// Worlds of a solvent and a species, for tests of species.
#pragma once

#include <functional>
#include <utility>

#include "scenes.hpp"

namespace meltsim_test {

struct Solution {
  World world;
  MaterialId water, salt;
};

constexpr double dx = 0.01;

/// A box of cells spacings without gravity. The step that sound allows is 0.01 s: for D of 1e-5 m^2/s, D dt/dx^2 is 1e-3 per unit of
/// time_scale.
inline WorldDesc box_of(Vec3i cells, double time_scale = 1,
                        Precision precision = Precision::double_precision) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = dx;
  d.sound_speed = 1;
  d.gravity = {0, 0, 0};
  d.artificial_viscosity = 0.05;
  d.domain.bounded = true;
  d.domain.max = {cells.x * dx, cells.y * dx, cells.z * dx};
  d.solute.time_scale = time_scale;
  d.solute.max_supersteps = 1000;
  return d;
}

/// Water, and a species as `of` describes it for that solvent.
inline Solution make_solution(const WorldDesc& d, const std::function<MaterialDesc(MaterialId)>& of,
                              const std::function<void(MaterialDesc&)>& change) {
  auto w = World::create(d);
  require(w);
  Solution s{std::move(*w), {}, {}};
  s.water = *s.world.add_material({});
  MaterialDesc m = of(s.water);
  if (change) change(m);
  const auto salt = s.world.add_material(m);
  require(salt);
  s.salt = *salt;
  return s;
}

/// Liquid between two corners [spacings] that holds this fraction of the species.
inline void fill(Solution& s, Vec3d low, Vec3d high, double fraction, FluidDesc f) {
  f.shape = Shape::box(low * dx, high * dx);
  f.material = s.water;
  if (fraction > 0) f.fractions = {{s.salt, fraction}};
  require(s.world.add_fluid(f));
}

}  // namespace meltsim_test
