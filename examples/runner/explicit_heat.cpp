// SPDX-License-Identifier: Apache-2.0
#include "explicit_heat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "meltsim/physics/heat.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

// Of the limit on the lattice: liquid that moves is crowded in places.
constexpr double safe_share = 0.7;

bool occurs(const Scene& scene, const std::string& name) {
  const auto is_of = [&](const auto& item) { return item.material == name; };
  return std::any_of(scene.fluids.begin(), scene.fluids.end(), is_of) ||
         std::any_of(scene.bodies.begin(), scene.bodies.end(), is_of) ||
         std::any_of(scene.emitters.begin(), scene.emitters.end(), is_of);
}

/// Of what is there or melts from it [m^2/s].
double largest_diffusivity(const Scene& scene) {
  double largest = 0;
  for (const SceneMaterial& material : scene.materials) {
    const meltsim::MaterialDesc& m = material.desc;
    const bool melt = std::any_of(
        scene.materials.begin(), scene.materials.end(),
        [&](const SceneMaterial& o) { return o.becomes == m.name && occurs(scene, o.desc.name); });
    if (!melt && !occurs(scene, m.name)) continue;
    largest = std::max(largest, m.diffusivity.value_or(meltsim::physics::diffusivity_of(
                                    m.conductivity, m.density, m.heat_capacity)));
  }
  return largest;
}

}  // namespace

double explicit_heat_dt(const Scene& scene, meltsim::World& world) {
  const meltsim::HeatDesc& heat = scene.world.heat;
  if (heat.model != meltsim::HeatModel::iwasaki) return meltsim::infinity;
  const double dx = scene.world.spacing,
               support = world.resolved().support_radius / world.desc().spacing * dx;
  const double rate =
      largest_diffusivity(scene) * heat.time_scale * meltsim::physics::lattice_laplacian_sum(support, dx);
  return rate > 0 ? 1 / rate : meltsim::infinity;
}

std::string explicit_heat_cure(const Scene& scene, meltsim::World& world) {
  const double dt = explicit_heat_dt(scene, world);
  if (!std::isfinite(dt)) return {};
  return fmt::format(
      "heat.model iwasaki is explicit, and stable in sub-steps of at most {:.2g} s at heat.time_scale {:g}: "
      "use "
      "time.dt {:g}, a lower heat.time_scale, or heat.model: enthalpy",
      dt, scene.world.heat.time_scale, rounded_down(safe_share * dt, 2));
}

std::string explicit_heat_warning(const Scene& scene, meltsim::World& world, double substep) {
  const double dt = explicit_heat_dt(scene, world);
  const double step = substep * std::max(1, scene.world.heat.interval);
  if (!(step > dt)) return {};
  return fmt::format(
      "heat.model: iwasaki in steps of {:.2g} s is likely to diverge: it is explicit, and stable up to "
      "{:.2g} "
      "s at heat.time_scale {:g}; use time.dt {:g}, heat.time_scale {:g}, or heat.model: enthalpy",
      step, dt, scene.world.heat.time_scale, rounded_down(safe_share * dt, 2),
      rounded_down(safe_share * dt / step * scene.world.heat.time_scale, 2));
}

}  // namespace runner
