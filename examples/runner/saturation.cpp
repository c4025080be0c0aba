// SPDX-License-Identifier: Apache-2.0
#include "saturation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "expect.hpp"
#include "meltsim/physics/property_table.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

/// w_s at a temperature [degrees Celsius].
double solubility_at(const meltsim::MaterialDesc& m, double temperature) {
  if (m.solubility_points.empty()) return m.solubility;
  meltsim::physics::PropertyTable<double> table;
  for (const meltsim::PropertyPoint& p : m.solubility_points) {
    table.temperature[table.points] = p.temperature;
    table.value[table.points++] = p.value;
  }
  return meltsim::physics::property_at(table, temperature);
}

/// Whether the amount of liquid changes.
bool is_open(const Scene& scene) {
  const meltsim::DomainDesc& domain = scene.world.domain;
  return !scene.emitters.empty() || !domain.bounded ||
         std::any_of(domain.faces.begin(), domain.faces.end(),
                     [](meltsim::Face f) { return f == meltsim::Face::open; });
}

/// Pure solvent in the liquid [kg], and its mean temperature; what the species holds and what its bodies do.
void add_up(const meltsim::ParticleData& p, std::size_t k, std::size_t species_row, std::size_t solvent_row,
            Saturation& s, double& solvent, double& heat) {
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const std::size_t row = meltsim::material_of(p.tag[i]);
    if (meltsim::is_solid(p.tag[i]) && row == species_row) s.crystals += p.mass[i] * p.fractions[k][i];
    if (!meltsim::is_fluid(p.tag[i]) || row != solvent_row) continue;
    double solutes = 0;
    for (const std::vector<double>& fraction : p.fractions) solutes += fraction[i];
    s.dissolved += p.mass[i] * p.fractions[k][i];
    solvent += p.mass[i] * (1 - solutes);
    heat += p.mass[i] * (1 - solutes) * p.temperature[i];
  }
}

}  // namespace

double Saturation::share() const {
  return crystals > 0 ? std::clamp((holds - dissolved) / crystals, 0.0, 1.0) : 1;
}

std::vector<Saturation> saturations(const Scene& scene, Built& built) {
  std::vector<Saturation> all;
  if (is_open(scene) || !built.dissolves) return all;
  const meltsim::ParticleData p = expect(built.world.particles());
  for (std::size_t k = 0; k < p.species.size(); ++k) {
    const meltsim::MaterialDesc m = built.world.material(p.species[k]);
    Saturation s;
    s.species = m.name;
    s.solvent = built.world.material(m.dissolves_in).name;
    double solvent = 0, heat = 0;
    add_up(p, k, p.species[k].index, m.dissolves_in.index, s, solvent, heat);
    if (!(s.crystals > 0) || !(solvent > 0)) continue;
    s.solubility = solubility_at(m, heat / solvent);
    if (!(s.solubility < 1)) continue;
    s.holds = s.solubility / (1 - s.solubility) * solvent;
    all.push_back(s);
  }
  return all;
}

std::string saturation_text(const Saturation& s) {
  const std::string what = fmt::format("{} in {}: saturated ({:.3g}) the liquid holds {:.3g} kg", s.species,
                                       s.solvent, s.solubility, s.holds);
  if (s.dissolved > s.holds * (1 + 1e-9))
    return fmt::format("{}, and has {:.3g}: what is too much settles on bodies", what, s.dissolved);
  if (s.share() >= 1) return what + ": everything can dissolve";
  return fmt::format("{} of the {:.3g} kg that there are: {} of the bodies can dissolve", what,
                     s.dissolved + s.crystals, percent_text(s.share()));
}

double most_that_goes(const Scene& scene, Built& built, double melts) {
  const std::vector<Saturation> all = saturations(scene, built);
  if (all.empty()) return built.dissolves ? 1 : melts;
  const meltsim::ParticleData p = expect(built.world.particles());
  double melting = 0, there = 0, goes = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (meltsim::is_solid(p.tag[i]) &&
        built.world.material(built.material_ids.at(meltsim::material_of(p.tag[i]))).melts_into)
      melting += p.mass[i];
  for (const Saturation& s : all) {
    there += s.crystals;
    goes += s.crystals * s.share();
  }
  return (melting * melts + goes) / (melting + there);
}

}  // namespace runner
