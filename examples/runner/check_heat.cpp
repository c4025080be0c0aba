// SPDX-License-Identifier: Apache-2.0
#include "check_heat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "scene_options.hpp"

namespace runner {

namespace {

/// An `ambient` that nothing exchanges heat with.
void check_ambient(const std::optional<Node>& surface, Scene& scene) {
  if (!surface || !surface->is_mapping()) return;
  const auto ambient = surface->find("ambient");
  if (!ambient || surface->find("convection") || surface->find("emissivity")) return;
  const bool alone = !surface->find("temperature") && !surface->find("flux");
  scene.warnings.push_back(fmt::format(
      "{}: {}.ambient: {}alone moves no heat{}: add convection [W/(m^2 K)] or emissivity beside it, e.g. "
      "convection: 10 in still air, or leave it out",
      ambient->where(), surface->path(),
      ambient->is_list() ? "" : fmt::format("{:g} C ", ambient->number("degrees Celsius")),
      alone ? ", so this surface insulates" : ""));
}

/// "{convection: 500, ambient: 20}", as a scene has it.
std::string text_of(const meltsim::SurfaceHeatDesc& surface) {
  std::string text;
  const Json json = surface_json(surface);
  const bool exchanges = surface.convection != 0 || surface.emissivity != 0;
  for (const auto& [key, value] : json.items())
    if (key == "ambient" ? exchanges : value.is_array() || value.get<double>() != 0)
      text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", key,
                          value.is_array() ? value.dump() : fmt::format("{:g}", value.get<double>()));
  return "{" + text + "}";
}

/// Liquid that freezes takes no part in what goes through the liquid's free surface any more.
void check_frozen_surface(Scene& scene) {
  const meltsim::SurfaceHeatDesc& free = scene.world.heat.free_surface;
  if (!acts(free)) return;
  for (const SceneBody& body : scene.bodies) {
    const auto material = std::find_if(scene.materials.begin(), scene.materials.end(),
                                       [&](const SceneMaterial& m) { return m.desc.name == body.material; });
    if (material == scene.materials.end() || !material->desc.freezes || body.desc.growth <= 0 ||
        acts(body.desc.surface))
      continue;
    scene.warnings.push_back(fmt::format(
        "{}: {}.surface: none: heat.free_surface is of liquid alone, and what has frozen onto \"{}\" "
        "exchanges no heat with the air; give the body the same, surface: {}",
        body.source.where, body.source.path, body.desc.name, text_of(free)));
  }
}

/// Heat that is to melt a body through its own surface: melt that stays covers it. Where gravity takes the melt away only a flux is meant to go on, like that
/// of a lamp or a laser.
void check_covered_surface(Scene& scene) {
  if (acts(scene.world.heat.free_surface) || scene.world.heat.model == meltsim::HeatModel::none) return;
  const bool stays = length(scene.world.gravity) == 0;
  for (const SceneBody& body : scene.bodies) {
    const auto material = std::find_if(scene.materials.begin(), scene.materials.end(),
                                       [&](const SceneMaterial& m) { return m.desc.name == body.material; });
    if (material == scene.materials.end() || material->becomes.empty()) continue;
    const meltsim::SurfaceHeatDesc& s = body.desc.surface;
    const double melts = material->desc.melting_point;
    const bool warm =
        (s.temperature || s.convection > 0 || s.emissivity > 0) && temperatures_of(s).most > melts;
    const bool heats = fluxes_of(s).most > 0 || (stays && warm);
    if (!heats) continue;
    scene.warnings.push_back(
        fmt::format("{}: {}.surface: is of what is dry of \"{}\": what has melted and stays on it covers it, "
                    "and there no heat comes in "
                    "any more; for heat that goes on through the melt add heat.free_surface: {}",
                    body.source.where, body.source.path, body.desc.name, text_of(s)));
  }
}

/// Buoyancy that cannot keep up with heat: what rises and sinks does so at its own speed, whatever the time lapse of heat.
void check_convection(const Node& root, Scene& scene) {
  constexpr double most_lapse = 3;  // convection is weaker by more than its laws are uncertain
  const double lapse = scene.world.heat.time_scale;
  if (!(lapse > most_lapse) || length(scene.world.gravity) == 0) return;
  const auto expands = [](const SceneMaterial& m) {
    const auto [low, high] =
        std::minmax_element(m.desc.density_points.begin(), m.desc.density_points.end(),
                            [](const auto& a, const auto& b) { return a.value < b.value; });
    return low != high && high->value > low->value;
  };
  const auto material = std::find_if(scene.materials.begin(), scene.materials.end(), expands);
  if (material == scene.materials.end()) return;
  const auto heat = root.find("heat");
  const auto key = heat ? heat->find("time_scale") : std::nullopt;
  scene.warnings.push_back(fmt::format(
      "{}: heat.time_scale: heat is {:g} times as fast as motion, so liquid that rises and sinks "
      "by the density table of \"{}\" carries next to none of it; where that counts use "
      "time_scale: 1, or leave the table out and give the liquid a conductivity that stands for it",
      key ? key->where() : material->source.where, lapse, material->desc.name));
}

}  // namespace

void check_heat(const Node& root, Scene& scene) {
  if (const auto heat = root.find("heat")) {
    check_ambient(heat->find("free_surface"), scene);
    if (const auto walls = heat->find("walls"))
      for (const auto& entry : walls->entries()) check_ambient(entry.second, scene);
  }
  if (const auto bodies = root.find("bodies"))
    for (const Node& body : bodies->items("bodies")) check_ambient(body.find("surface"), scene);
  check_frozen_surface(scene);
  check_covered_surface(scene);
  check_convection(root, scene);
}

}  // namespace runner
