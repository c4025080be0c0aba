// SPDX-License-Identifier: Apache-2.0
// fluids, bodies, emitters, force_fields, heat.regions: what their rows cannot say, such as names of other parts of the scene.
#include <fmt/format.h>

#include <algorithm>

#include "failure.hpp"
#include "load_parts.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

void check_material_name(const Node& node, const std::string& name, const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneMaterial& material : scene.materials) names.push_back(material.desc.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    node.fail(fmt::format("no material is named \"{}\"{}", name, suggestion(name, names, "materials")));
}

void check_fractions(const Node& item, const Scene& scene) {
  if (const auto node = item.find("fractions"))
    for (const auto& [name, value] : node->entries()) check_material_name(value, name, scene);
}

}  // namespace

void load_fluids(const Node& node, Scene& scene) {
  load_list(node, fluid_options(), scene.fluids, [&](const Node& item, SceneFluid& fluid) {
    check_material_name(*item.find("material"), fluid.material, scene);
    check_fractions(item, scene);
  });
}

void load_bodies(const Node& node, Scene& scene) {
  load_list(node, body_options(), scene.bodies, [&](const Node& item, SceneBody& body) {
    check_material_name(*item.find("material"), body.material, scene);
    for (const SceneMaterial& material : scene.materials)
      if (material.desc.name == body.material) scene.output.body_colors.push_back(material.color);
    scene.output.body_visible.push_back(body.visible);
  });
  number_names(scene.bodies, "body");
}

void load_nozzle(const Node& node, meltsim::EmitterDesc& desc) {
  load_options(node, nozzle_options(), desc);
  if (!node.find("width") && !node.find("height")) {
    node.require("radius", "a number (m); of a rectangle width and height");
    return;
  }
  for (const char* side : {"width", "height"}) node.require(side, "a number (m)");
  if (const auto value = node.find("radius"))
    value->fail("an opening is a disc or a rectangle; drop this, or width and height");
}

void load_emitters(const Node& node, Scene& scene) {
  load_list(node, emitter_options(), scene.emitters, [&](const Node& item, SceneEmitter& emitter) {
    check_material_name(*item.find("material"), emitter.material, scene);
    check_fractions(item, scene);
    const auto reservoir = item.find("reservoir");
    if (!reservoir)
      item.require("nozzle", "{center, axis, radius} or {center, axis, width, height}, or a reservoir");
    else if (item.find("nozzle")) reservoir->fail("an emitter is a nozzle or a reservoir; drop one of them");
    const std::string part = reservoir ? "reservoir" : "nozzle";
    for (const auto& [key, where] : item.find(part)->source().keys)
      emitter.source.keys[part + "." + key] = where;
  });
  number_names(scene.emitters, "emitter");
}

void load_force_fields(const Node& node, Scene& scene) {
  load_list(node, force_field_options(), scene.force_fields, [](const Node&, SceneForceField&) {});
  number_names(scene.force_fields, "field");
}

void load_heat_regions(const Node& node, Scene& scene) {
  load_list(node, heat_region_options(), scene.heat_regions, [](const Node&, SceneHeatRegion&) {});
  number_names(scene.heat_regions, "heat");
}

}  // namespace runner
