// SPDX-License-Identifier: Apache-2.0
#include "heat_balance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "expect.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

/// Sums of one pass over the particles, against a common melting point.
struct Sums {
  double liquid_heat = 0;      ///< [J] above the melting point
  double liquid_capacity = 0;  ///< [J/K]
  double warming = 0;          ///< [J] to bring the solids to the melting point
  double latent = 0;           ///< [J]
  double melted_capacity = 0;  ///< [J/K] of the solids once they are liquid
  double solid_capacity = 0;   ///< [J/K]
};

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
  const meltsim::ParticleData data = expect(built.world.particles());
  Sums sums;
  for (std::size_t i = 0; i < data.id.size(); ++i) {
    const meltsim::MaterialDesc& material = table.at(meltsim::material_of(data.tag[i]));
    const double capacity = data.mass[i] * material.heat_capacity;
    if (meltsim::is_fluid(data.tag[i])) {
      sums.liquid_heat += capacity * (data.temperature[i] - *point);
      sums.liquid_capacity += capacity;
    } else if (meltsim::is_solid(data.tag[i]) && material.melts_into) {
      sums.warming += capacity * (*point - data.temperature[i]);
      sums.latent += data.mass[i] * material.latent_heat;
      sums.solid_capacity += capacity;
      sums.melted_capacity += data.mass[i] * built.world.material(material.melts_into).heat_capacity;
    }
  }
  HeatBalance balance;
  balance.melting_point = *point;
  balance.available = sums.liquid_heat;
  balance.needed = sums.warming + sums.latent;
  const double left = balance.available - balance.needed, spare = balance.available - sums.warming;
  if (left >= 0) {
    balance.melts = 1;
    balance.end_temperature = *point + left / (sums.liquid_capacity + sums.melted_capacity);
  } else if (spare >= 0) {
    balance.melts = sums.latent > 0 ? spare / sums.latent : 0;
    balance.end_temperature = *point;
  } else {
    balance.end_temperature = *point + spare / (sums.liquid_capacity + sums.solid_capacity);
  }
  return balance;
}

std::string heat_balance_text(const HeatBalance& balance) {
  const std::string end = balance.melts >= 1  ? "everything melts"
                          : balance.melts > 0 ? percent_text(balance.melts) + " of the solid melts"
                                              : "nothing melts";
  return fmt::format(
      "the liquid gives {:.3g} J down to {:g} C, melting takes {:.3g} J: {}, ending at {:.4g} C "
      "(insulated box, emitters not counted)",
      balance.available, balance.melting_point, balance.needed, end, balance.end_temperature);
}

}  // namespace runner
