// SPDX-License-Identifier: Apache-2.0
// fluids, bodies, emitters.
#include <fmt/format.h>

#include <algorithm>

#include "failure.hpp"
#include "load_heat.hpp"
#include "load_parts.hpp"
#include "load_shape.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

std::string load_material_name(const Node& item, const Scene& scene) {
  const Node node = item.require("material", "the name of a material");
  const std::string name = node.text("the name of a material");
  std::vector<std::string> names;
  for (const SceneMaterial& material : scene.materials) {
    if (material.desc.name == name) return name;
    names.push_back(material.desc.name);
  }
  node.fail(fmt::format("no material is named \"{}\"{}", name, suggestion(name, names, "materials")));
}

std::string load_name(const Node& item, const char* stem, std::size_t index) {
  const auto node = item.find("name");
  if (!node) return fmt::format("{}{}", stem, index);
  const std::string name = node->text("a name");
  // Names stand in CSV files.
  const bool plain = !name.empty() && name.find_first_of(",\"\n\r") == std::string::npos;
  if (!plain)
    node->fail(fmt::format("expected a name without commas, quotes or line breaks, got {}", node->found()));
  return name;
}

/// {name: mass fraction}
SceneFractions load_fractions(const Node& item, const Scene& scene) {
  SceneFractions fractions;
  const auto node = item.find("fractions");
  if (!node) return fractions;
  std::vector<std::string> names;
  for (const SceneMaterial& material : scene.materials) names.push_back(material.desc.name);
  for (const auto& [name, value] : node->entries()) {
    if (std::find(names.begin(), names.end(), name) == names.end())
      value.fail(fmt::format("no material is named \"{}\"{}", name, suggestion(name, names, "materials")));
    fractions.emplace_back(name, value.number("kg per kg of mixture, 0 to 1"));
  }
  return fractions;
}

double load_temperature(const Node& item, double by_default) {
  const auto node = item.find("temperature");
  if (!node) return by_default;
  const double value = node->number("degrees Celsius");
  if (value < meltsim::absolute_zero) {
    node->fail(fmt::format("expected at least {} (degrees Celsius, absolute zero), got {}",
                           meltsim::absolute_zero, node->found()));
  }
  return value;
}

}  // namespace

void load_fluids(const Node& node, Scene& scene) {
  for (const Node& item : node.items("fluids")) {
    item.allow_keys(keys::fluid);
    SceneFluid fluid;
    fluid.source = item.source();
    fluid.shape = load_shape(item.require("shape", "e.g. {box: [[0,0,0],[1,1,1]]} (m)"));
    fluid.material = load_material_name(item, scene);
    fluid.fractions = load_fractions(item, scene);
    fluid.desc.shape = fluid.shape.shape;
    fluid.desc.temperature = load_temperature(item, fluid.desc.temperature);
    if (const auto value = item.find("velocity")) fluid.desc.velocity = value->vector("m/s");
    scene.fluids.push_back(fluid);
  }
}

void load_bodies(const Node& node, Scene& scene) {
  for (const Node& item : node.items("bodies")) {
    item.allow_keys(keys::body);
    SceneBody body;
    body.source = item.source();
    body.desc.name = load_name(item, "body", scene.bodies.size() + 1);
    body.shape = load_shape(item.require("shape", "e.g. {box: [[0,0,0],[1,1,1]]} (m)"));
    body.material = load_material_name(item, scene);
    for (const SceneMaterial& material : scene.materials) {
      if (material.desc.name == body.material) scene.output.body_colors.push_back(material.color);
    }
    body.desc.shape = body.shape.shape;
    body.desc.temperature = load_temperature(item, body.desc.temperature);
    if (const auto value = item.find("density")) body.density = value->positive("kg/m^3");
    if (const auto value = item.find("velocity")) body.desc.velocity = value->vector("m/s");
    if (const auto value = item.find("angular_velocity")) body.desc.angular_velocity = value->vector("rad/s");
    if (const auto value = item.find("surface")) body.desc.surface = load_surface(*value);
    if (const auto value = item.find("heat_source")) body.desc.heat_source = value->number("W/m^3");
    if (const auto value = item.find("fixed")) body.desc.fixed = value->boolean();
    if (const auto value = item.find("held_until")) body.desc.held_until = value->number_or_infinite("s");
    if (const auto value = item.find("motion")) {
      const auto at = std::find(keys::motion.begin(), keys::motion.end(), value->choice(keys::motion));
      body.desc.motion = static_cast<meltsim::Motion>(at - keys::motion.begin());
    }
    if (const auto value = item.find("pivot")) body.desc.pivot = value->vector("m");
    if (const auto value = item.find("max_speed")) body.desc.max_speed = value->number("m/s");
    if (const auto value = item.find("carve")) body.desc.carve = value->boolean();
    if (const auto value = item.find("growth")) body.desc.growth = value->small_integer();
    scene.bodies.push_back(body);
  }
}

void load_emitters(const Node& node, Scene& scene) {
  for (const Node& item : node.items("emitters")) {
    item.allow_keys(keys::emitter);
    SceneEmitter emitter;
    emitter.source = item.source();
    meltsim::EmitterDesc& desc = emitter.desc;
    desc.name = load_name(item, "emitter", scene.emitters.size() + 1);
    const Node nozzle = item.require("nozzle", "{center, axis, radius} or {center, axis, width, height}");
    nozzle.allow_keys(keys::nozzle);
    desc.center = nozzle.require("center", "3 numbers [x, y, z] (m)").vector("m");
    if (const auto value = nozzle.find("axis")) desc.axis = value->vector("any length");
    if (nozzle.find("width") || nozzle.find("height")) {
      desc.width = nozzle.require("width", "a number (m)").positive("m");
      desc.height = nozzle.require("height", "a number (m)").positive("m");
      if (const auto value = nozzle.find("up")) desc.up = value->vector("any length");
      if (const auto value = nozzle.find("radius"))
        value->fail("an opening is a disc or a rectangle; drop this, or width and height");
    } else {
      desc.radius = nozzle.require("radius", "a number (m); of a rectangle width and height").positive("m");
    }
    if (const auto value = item.find("speed")) desc.speed = value->positive("m/s");
    emitter.material = load_material_name(item, scene);
    emitter.fractions = load_fractions(item, scene);
    desc.temperature = load_temperature(item, desc.temperature);
    if (const auto value = item.find("from")) desc.from = value->number("s");
    if (const auto value = item.find("until")) desc.until = value->number_or_infinite("s");
    if (const auto value = item.find("max_particles")) {
      const std::int64_t most = value->integer();
      if (most < 0) value->fail(fmt::format("expected 0 or more, got {}", value->found()));
      desc.max_particles = static_cast<std::uint64_t>(most);
    }
    scene.emitters.push_back(emitter);
  }
}

}  // namespace runner
