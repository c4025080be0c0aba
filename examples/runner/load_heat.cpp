// SPDX-License-Identifier: Apache-2.0
// heat: the model, walls and regions; solute; the surface of a body; properties that depend on temperature.
#include "load_heat.hpp"

#include <fmt/format.h>

#include "load_parts.hpp"
#include "load_shape.hpp"
#include "scene_keys.hpp"

namespace runner {

meltsim::SurfaceHeatDesc load_surface(const Node& node) {
  node.allow_keys(keys::surface_heat);
  meltsim::SurfaceHeatDesc desc;
  if (const auto value = node.find("temperature")) desc.temperature = value->number("degrees Celsius");
  if (const auto value = node.find("flux")) desc.flux = value->number("W/m^2");
  if (const auto value = node.find("convection")) desc.convection = value->number("W/(m^2 K)");
  if (const auto value = node.find("emissivity")) desc.emissivity = value->number("0 to 1");
  if (const auto value = node.find("ambient")) desc.ambient = value->number("degrees Celsius");
  return desc;
}

void load_property(const Node& node, const char* key, const char* unit, double& constant,
                   std::vector<meltsim::PropertyPoint>& points) {
  const auto value = node.find(key);
  if (!value) return;
  if (!value->is_list()) {
    constant = value->number(unit);
    return;
  }
  for (const Node& item : value->items(key)) {
    const auto pair = item.is_list() ? item.items("a point") : std::vector<Node>{};
    if (pair.size() != 2)
      item.fail(
          fmt::format("expected [temperature, value] (degrees Celsius, {}), got {}", unit, item.found()));
    points.push_back({pair[0].number("degrees Celsius"), pair[1].number(unit)});
  }
}

namespace {

SceneHeatRegion load_region(const Node& item, std::size_t index) {
  item.allow_keys(keys::heat_region);
  SceneHeatRegion region;
  region.source = item.source();
  meltsim::HeatRegionDesc& desc = region.desc;
  desc.name = fmt::format("heat{}", index);
  if (const auto value = item.find("name")) desc.name = value->text("a name");
  region.shape = load_shape(item.require("shape", "e.g. {box: [[0,0,0],[1,1,1]]} (m)"));
  desc.shape = region.shape.shape;
  if (const auto value = item.find("temperature")) desc.temperature = value->number("degrees Celsius");
  if (const auto value = item.find("source")) desc.source = value->number("W/m^3");
  if (const auto value = item.find("from")) desc.from = value->number("s");
  if (const auto value = item.find("until")) desc.until = value->number_or_infinite("s");
  return region;
}

}  // namespace

void load_solute(const Node& node, Scene& scene) {
  node.allow_keys(keys::solute);
  scene.solute = node.source();
  meltsim::SoluteDesc& solute = scene.world.solute;
  if (const auto value = node.find("time_scale")) {
    constexpr double most = 1e12;
    solute.time_scale = value->number("a factor");
    if (solute.time_scale < 0 || solute.time_scale > most)
      value->fail(fmt::format("expected a factor from 0 to {:g}, got {}", most, value->found()));
  }
  if (const auto value = node.find("max_supersteps")) solute.max_supersteps = value->small_integer();
}

void load_heat(const Node& node, Scene& scene) {
  node.allow_keys(keys::heat);
  scene.heat = node.source();
  meltsim::HeatDesc& heat = scene.world.heat;
  if (const auto value = node.find("model")) {
    const std::string model = value->choice(keys::heat_model);
    heat.model = model == "paper"     ? meltsim::HeatModel::paper
                 : model == "iwasaki" ? meltsim::HeatModel::iwasaki
                 : model == "none"    ? meltsim::HeatModel::none
                                      : meltsim::HeatModel::enthalpy;
  }
  if (const auto value = node.find("time_scale")) {
    constexpr double most = 1e12;  // weeks of melting in a second are 1e6
    heat.time_scale = value->number("a factor");
    if (heat.time_scale < 0 || heat.time_scale > most)
      value->fail(fmt::format("expected a factor from 0 to {:g}, got {}", most, value->found()));
  }
  if (const auto value = node.find("interval")) {
    heat.interval = value->is_word("auto") ? 0 : value->small_integer();
  }
  if (const auto value = node.find("max_stages")) heat.max_stages = value->small_integer();
  if (const auto value = node.find("max_supersteps")) heat.max_supersteps = value->small_integer();
  if (const auto value = node.find("level_tolerance")) heat.level_tolerance = value->number("K");
  if (const auto surface = node.find("free_surface")) heat.free_surface = load_surface(*surface);
  if (const auto walls = node.find("walls")) {
    walls->allow_keys(keys::faces);
    for (const auto& [key, value] : walls->entries())
      for (const std::size_t i : face_indices(key)) scene.world.domain.heat[i] = load_surface(value);
  }
  if (const auto regions = node.find("regions"))
    for (const Node& item : regions->items("regions"))
      scene.heat_regions.push_back(load_region(item, scene.heat_regions.size() + 1));
}

}  // namespace runner
