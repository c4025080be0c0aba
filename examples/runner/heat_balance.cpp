// SPDX-License-Identifier: Apache-2.0
#include "heat_balance.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "expect.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

/// Sums of one pass over the particles, against a common melting point.
struct Sums {
  double heat = 0;             ///< [J] above the melting point, of liquids and of bodies that do not melt
  double capacity = 0;         ///< [J/K] of the same
  double warming = 0;          ///< [J] to bring the solids to the melting point
  double latent = 0;           ///< [J]
  double melted_capacity = 0;  ///< [J/K] of the solids once they are liquid
  double solid_capacity = 0;   ///< [J/K]
  double freezing = 0;         ///< [J] that liquid gives off as it freezes
  double thawed_capacity = 0;  ///< [J/K] of that liquid
  double frozen_capacity = 0;  ///< [J/K] of it once it is frozen
};

/// Per material of the table: the one that its liquid freezes to, or null.
std::vector<const meltsim::MaterialDesc*> what_freezes(const std::vector<meltsim::MaterialDesc>& table) {
  std::vector<const meltsim::MaterialDesc*> solid(table.size(), nullptr);
  for (const meltsim::MaterialDesc& material : table)
    if (material.freezes && material.melts_into) solid.at(material.melts_into.index) = &material;
  return solid;
}

std::optional<double> common_melting_point(const std::vector<meltsim::MaterialDesc>& used) {
  std::optional<double> point;
  for (const meltsim::MaterialDesc& material : used) {
    if (!material.melts_into || std::isinf(material.melting_point)) continue;
    if (point && *point != material.melting_point) return std::nullopt;
    point = material.melting_point;
  }
  return point;
}

}  // namespace

std::optional<HeatBalance> heat_balance(Built& built) {
  if (built.meltable == 0) return std::nullopt;
  std::vector<meltsim::MaterialDesc> table;
  for (const meltsim::MaterialId id : built.material_ids) table.push_back(built.world.material(id));
  const auto point = common_melting_point(table);
  if (!point) return std::nullopt;
  const std::vector<const meltsim::MaterialDesc*> solid_of = what_freezes(table);
  const meltsim::ParticleData data = expect(built.world.particles());
  Sums sums;
  HeatBalance balance;
  for (std::size_t i = 0; i < data.id.size(); ++i) {
    const std::size_t row = meltsim::material_of(data.tag[i]);
    const meltsim::MaterialDesc& material = table.at(row);
    const double capacity = data.mass[i] * material.heat_capacity;
    const bool fluid = meltsim::is_fluid(data.tag[i]);
    if (fluid || (meltsim::is_solid(data.tag[i]) && !material.melts_into)) {
      sums.heat += capacity * (data.temperature[i] - *point);
      sums.capacity += capacity;
      (fluid ? balance.liquid : balance.bodies) = true;
      if (const meltsim::MaterialDesc* const solid = fluid ? solid_of.at(row) : nullptr) {
        sums.freezing += data.mass[i] * solid->latent_heat * data.liquid_fraction[i];
        sums.thawed_capacity += capacity;
        sums.frozen_capacity += data.mass[i] * solid->heat_capacity;
      }
    } else if (meltsim::is_solid(data.tag[i])) {
      sums.warming += capacity * (*point - data.temperature[i]);
      sums.latent += data.mass[i] * material.latent_heat;
      sums.solid_capacity += capacity;
      sums.melted_capacity += data.mass[i] * built.world.material(material.melts_into).heat_capacity;
    }
  }
  balance.melting_point = *point;
  balance.available = sums.heat;
  balance.needed = sums.warming + sums.latent;
  const double left = balance.available - balance.needed, spare = balance.available - sums.warming;
  if (left >= 0) {
    balance.melts = 1;
    balance.end_temperature = *point + left / (sums.capacity + sums.melted_capacity);
  } else if (spare >= 0) {
    balance.melts = sums.latent > 0 ? spare / sums.latent : 0;
    balance.end_temperature = *point;
  } else if (-spare < sums.freezing) {
    balance.freezes = -spare / sums.freezing;
    balance.end_temperature = *point;
  } else {
    balance.freezes = sums.freezing > 0 ? 1 : 0;
    balance.end_temperature = *point + (spare + sums.freezing) / (sums.capacity - sums.thawed_capacity +
                                                                  sums.frozen_capacity + sums.solid_capacity);
  }
  return balance;
}

std::string heat_balance_text(const HeatBalance& balance, const std::string& others) {
  if (!balance.liquid && !balance.bodies)
    return fmt::format("melting takes {:.3g} J, {}", balance.needed,
                       others.empty() ? "and nothing here brings heat" : "which has to come from " + others);
  const std::string who = !balance.bodies  ? "the liquid holds"
                          : balance.liquid ? "the liquid and what does not melt hold"
                                           : "what does not melt holds";
  const auto percent_of = [](double share, const char* rest) { return percent_text(share) + rest; };
  const std::string end = balance.melts >= 1     ? "everything melts"
                          : balance.melts > 0    ? percent_of(balance.melts, " of the solid melts")
                          : balance.freezes >= 1 ? "all that can freeze is frozen"
                          : balance.freezes > 0 ? percent_of(balance.freezes, " of what can freeze is frozen")
                                                : "nothing melts";
  return fmt::format("{} {:.2g} times what melting takes: in the end {} at {:.3g} C{}", who,
                     balance.needed > 0 ? std::max(0.0, balance.available / balance.needed) : 0, end,
                     balance.end_temperature, others.empty() ? "" : "; not counted: " + others);
}

std::string heat_sources_text(const Scene& scene) {
  std::vector<std::string> names;
  const auto acts = [](const meltsim::SurfaceHeatDesc& surface) {
    return surface.temperature || surface.flux != 0 || surface.convection != 0 || surface.emissivity != 0;
  };
  if (std::any_of(scene.world.domain.heat.begin(), scene.world.domain.heat.end(), acts))
    names.push_back("walls");
  if (acts(scene.world.heat.free_surface)) names.push_back("the liquid's free surface");
  for (const SceneBody& body : scene.bodies) {
    if (acts(body.desc.surface)) names.push_back(fmt::format("the surface of \"{}\"", body.desc.name));
    if (body.desc.heat_source != 0) names.push_back(fmt::format("the source in \"{}\"", body.desc.name));
  }
  for (const SceneHeatRegion& region : scene.heat_regions)
    names.push_back(fmt::format("region \"{}\"", region.desc.name));
  for (const SceneEmitter& emitter : scene.emitters)
    names.push_back(fmt::format("emitter \"{}\"", emitter.desc.name));
  constexpr std::size_t most = 3;
  if (names.size() > most) {
    const std::string rest = fmt::format("{} more", names.size() - most);
    names.resize(most);
    names.push_back(rest);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace runner
