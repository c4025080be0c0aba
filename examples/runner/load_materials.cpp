// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "failure.hpp"
#include "load_heat.hpp"
#include "load_parts.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

/// What is no key because it is in the points of another.
void refuse_expansion(const Node& node) {
  for (const char* key : {"thermal_expansion", "thermal_expansion_coefficient", "expansion_coefficient"})
    if (const auto given = node.find(key))
      given->fail(
          "no key; what expands has a density by temperature, density: [[T1, rho1], [T2, rho2], ...] "
          "(degrees Celsius, kg/m^3)");
}

SceneMaterial load_material(const std::string& name, const Node& node) {
  refuse_expansion(node);
  SceneMaterial material;
  material.source = node.source();
  meltsim::MaterialDesc& desc = material.desc;
  desc.name = name;
  load_options(node, material_options(), material);
  if (const auto value = node.find("youngs_modulus"); value && node.find("stiffness"))
    value->fail("youngs_modulus replaces stiffness; give one of the two");
  // Of those that may be points, the first stands where one number is asked for.
  if (!desc.density_points.empty()) desc.density = desc.density_points.front().value;
  if (!desc.yield_stress_points.empty()) desc.yield_stress = desc.yield_stress_points.front().value;
  if (!desc.solubility_points.empty()) desc.solubility = desc.solubility_points.front().value;
  return material;
}

}  // namespace

void load_materials(const Node& node, Scene& scene) {
  std::vector<SceneMaterial> left;
  std::vector<std::string> names;
  for (const auto& [name, entry] : node.entries()) {
    left.push_back(load_material(name, entry));
    names.push_back(name);
  }
  for (const SceneMaterial& material : left) {
    for (const auto& [key, named] : {std::pair<const char*, const std::string&>{"becomes", material.becomes},
                                     {"dissolves_in", material.dissolves_in}}) {
      if (named.empty() || std::find(names.begin(), names.end(), named) != names.end()) continue;
      throw Failure(ExitCode::scene,
                    fmt::format("{}: {}.{}: no material is named \"{}\"{}", material.source.keys.at(key),
                                material.source.path, key, named, suggestion(named, names, "materials")));
    }
  }
  // A material is added after the one it becomes or dissolves in; what is left over turns in a circle.
  std::set<std::string> placed;
  while (!left.empty()) {
    const auto ready = std::find_if(left.begin(), left.end(), [&placed](const SceneMaterial& material) {
      return (material.becomes.empty() || placed.count(material.becomes) > 0) &&
             (material.dissolves_in.empty() || placed.count(material.dissolves_in) > 0);
    });
    if (ready == left.end()) {
      const SceneMaterial& first = left.front();
      if (first.becomes.empty() || placed.count(first.becomes) > 0)
        throw Failure(
            ExitCode::scene,
            fmt::format(
                "{}: {}.dissolves_in: \"{}\" leads back to \"{}\"; a solute dissolves in a liquid, which "
                "dissolves in nothing",
                first.source.keys.at("dissolves_in"), first.source.path, first.dissolves_in,
                first.desc.name));
      throw Failure(
          ExitCode::scene,
          fmt::format("{}: {}.becomes: \"{}\" leads back to \"{}\"; a solid becomes a "
                      "liquid, which becomes nothing",
                      first.source.keys.at("becomes"), first.source.path, first.becomes, first.desc.name));
    }
    placed.insert(ready->desc.name);
    scene.materials.push_back(*ready);
    left.erase(ready);
  }
}

}  // namespace runner
