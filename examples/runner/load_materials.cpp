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

/// "never" reads better in a scene than an infinite temperature.
double melting_point(const Node& node) {
  return node.is_word("never") ? meltsim::infinity : node.number_or_infinite("degrees Celsius, or never");
}

std::array<double, 3> color_of(const Node& node) {
  const meltsim::Vec3d color = node.vector("red, green, blue: 0 to 1");
  for (const double c : {color.x, color.y, color.z}) {
    if (c < 0 || c > 1) node.fail(fmt::format("expected red, green and blue from 0 to 1, got {:g}", c));
  }
  return {color.x, color.y, color.z};
}

SceneMaterial load_material(const std::string& name, const Node& node) {
  node.allow_keys(keys::material);
  SceneMaterial material;
  material.source = node.source();
  meltsim::MaterialDesc& desc = material.desc;
  desc.name = name;
  const auto number = [&node](const char* key, const char* unit, double& to) {
    if (const auto value = node.find(key)) to = value->number(unit);
  };
  load_property(node, "density", "kg/m^3", desc.density, desc.density_points);
  if (!desc.density_points.empty()) desc.density = desc.density_points.front().value;
  load_property(node, "viscosity", "Pa s", desc.viscosity, desc.viscosity_points);
  load_property(node, "conductivity", "W/(m K)", desc.conductivity, desc.conductivity_points);
  load_property(node, "heat_capacity", "J/(kg K)", desc.heat_capacity, desc.heat_capacity_points);
  if (const auto value = node.find("diffusivity")) desc.diffusivity = value->number("m^2/s");
  number("latent_heat", "J/kg", desc.latent_heat);
  number("stiffness", "0 to 1", desc.stiffness);
  number("youngs_modulus", "Pa", desc.youngs_modulus);
  number("damping", "0 to 1", desc.damping);
  number("friction", "Coulomb coefficient", desc.friction);
  number("surface_tension", "N/m", desc.surface_tension);
  number("contact_angle", "degrees", desc.contact_angle);
  load_property(node, "yield_stress", "Pa", desc.yield_stress, desc.yield_stress_points);
  if (!desc.yield_stress_points.empty()) desc.yield_stress = desc.yield_stress_points.front().value;
  number("flow_index", "below 1 thins", desc.flow_index);
  number("regularisation", "s", desc.regularisation);
  if (const auto value = node.find("K")) {
    if (node.find("diffusivity")) value->fail("K is another name of diffusivity; give one of the two");
    desc.diffusivity = value->number("m^2/s");
  }
  if (const auto value = node.find("youngs_modulus"); value && node.find("stiffness"))
    value->fail("youngs_modulus replaces stiffness; give one of the two");
  if (const auto value = node.find("melting_point")) desc.melting_point = melting_point(*value);
  if (const auto value = node.find("region_half_width")) desc.region_half_width = value->small_integer();
  if (const auto value = node.find("becomes")) material.becomes = value->text("the name of a material");
  if (const auto value = node.find("dissolves_in"))
    material.dissolves_in = value->text("the name of a material");
  load_property(node, "solubility", "kg per kg of solution, 0 to 1", desc.solubility, desc.solubility_points);
  if (!desc.solubility_points.empty()) desc.solubility = desc.solubility_points.front().value;
  number("diffusivity_in", "m^2/s", desc.diffusivity_in);
  number("heat_of_solution", "J/kg", desc.heat_of_solution);
  if (const auto value = node.find("transfer_coefficient")) desc.transfer_coefficient = value->number("m/s");
  if (const auto value = node.find("freezes")) desc.freezes = value->boolean();
  if (const auto value = node.find("color")) material.color = color_of(*value);
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
