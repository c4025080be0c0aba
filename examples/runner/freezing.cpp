// SPDX-License-Identifier: Apache-2.0
#include "freezing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "check_heat.hpp"
#include "expect.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

// Liquid at its melting point gives off latent heat; what is colder by as much has none left.
constexpr double colder = 1e-3;  // K

const char* const cure =
    "keep some of it solid: a larger or colder body, one at what cools, or a part of it that one of "
    "heat.regions holds cold";

bool has_bodies(const Scene& scene, const std::string& material) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [&](const SceneBody& body) { return body.material == material; });
}

/// Whether something takes heat away down to temperatures below `point`.
bool cools_below(const Scene& scene, double point) {
  const auto cools = [point](const meltsim::SurfaceHeatDesc& s) {
    return fluxes_of(s).least < 0 ||
           ((s.temperature || s.convection > 0 || s.emissivity > 0) && temperatures_of(s).least < point);
  };
  const auto& walls = scene.world.domain.heat;
  const auto cold = [point](const SceneHeatRegion& r) {
    return r.desc.source < 0 || (r.desc.temperature && *r.desc.temperature < point);
  };
  return cools(scene.world.heat.free_surface) || std::any_of(walls.begin(), walls.end(), cools) ||
         std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [&](const SceneBody& b) { return cools(b.desc.surface) || b.desc.heat_source < 0; }) ||
         std::any_of(scene.heat_regions.begin(), scene.heat_regions.end(), cold) ||
         std::any_of(scene.emitters.begin(), scene.emitters.end(),
                     [point](const SceneEmitter& e) { return e.desc.temperature < point; });
}

}  // namespace

std::vector<std::string> nothing_to_freeze_onto(const Scene& scene) {
  std::vector<std::string> warnings;
  for (const SceneMaterial& m : scene.materials)
    if (m.desc.freezes && !has_bodies(scene, m.desc.name))
      warnings.push_back(
          fmt::format("\"{}\" freezes onto bodies of \"{}\", and there is none: it stays liquid however "
                      "cold it is; add one, with `growth`",
                      m.becomes, m.desc.name));
  return warnings;
}

std::vector<std::string> melted_away(const Scene& scene, Built& built) {
  std::set<std::string> left;
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces()))
    if (piece.particles > 0) left.insert(scene.bodies.at(piece.body.index).material);
  std::vector<std::string> gone;
  for (const SceneMaterial& m : scene.materials)
    if (m.desc.freezes && has_bodies(scene, m.desc.name) && left.count(m.desc.name) == 0)
      gone.push_back(m.desc.name);
  return gone;
}

std::vector<std::string> will_not_freeze(const Scene& scene, const std::vector<std::string>& gone,
                                         bool cold_enough, const std::string& when) {
  std::vector<std::string> warnings;
  for (const SceneMaterial& m : scene.materials) {
    if (std::find(gone.begin(), gone.end(), m.desc.name) == gone.end()) continue;
    if (!cold_enough && !cools_below(scene, m.desc.melting_point)) continue;
    warnings.push_back(
        fmt::format("\"{}\" freezes onto bodies of \"{}\", and {} the last of them melted away: from then on "
                    "it stays liquid however cold it is; {}",
                    m.becomes, m.desc.name, when, cure));
  }
  return warnings;
}

std::vector<std::string> left_supercooled(const Scene& scene, Built& built) {
  std::vector<std::string> gone = melted_away(scene, built), warnings;
  for (const SceneMaterial& m : scene.materials)
    if (m.desc.freezes && !has_bodies(scene, m.desc.name)) gone.push_back(m.desc.name);
  if (gone.empty()) return warnings;
  const meltsim::ParticleData now = expect(built.world.particles());
  for (const SceneMaterial& m : scene.materials) {
    if (std::find(gone.begin(), gone.end(), m.desc.name) == gone.end()) continue;
    std::uint64_t all = 0, cold = 0;
    for (std::size_t i = 0; i < now.id.size(); ++i) {
      if (!meltsim::is_fluid(now.tag[i]) || built.materials.at(meltsim::material_of(now.tag[i])) != m.becomes)
        continue;
      ++all;
      cold += now.temperature[i] < m.desc.melting_point - colder ? 1 : 0;
    }
    if (cold == 0) continue;
    warnings.push_back(fmt::format(
        "{} of {} particles of \"{}\" ended liquid below {:g} C, where \"{}\" melts: there is "
        "no body of \"{}\" left that they could freeze onto; {}",
        count_text(cold), count_text(all), m.becomes, m.desc.melting_point, m.desc.name, m.desc.name, cure));
  }
  return warnings;
}

}  // namespace runner
