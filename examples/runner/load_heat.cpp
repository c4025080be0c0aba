// SPDX-License-Identifier: Apache-2.0
// Heat through walls, in regions and through the surface of a body; properties that depend on temperature.
#include "load_heat.hpp"

#include <fmt/format.h>

#include "echo.hpp"
#include "load_parts.hpp"
#include "load_shape.hpp"
#include "scene_keys.hpp"

namespace runner {

meltsim::SurfaceHeatDesc load_surface(const Node& node) {
  meltsim::SurfaceHeatDesc desc;
  load_options(node, surface_heat_options(), desc);
  return desc;
}

void load_property(const Node& value, const char* key, const char* unit, double& constant,
                   std::vector<meltsim::PropertyPoint>& points) {
  if (!value.is_list()) {
    constant = value.number(unit);
    return;
  }
  for (const Node& item : value.items(key)) {
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

void load_wall_heat(const Node& node, meltsim::DomainDesc& domain) {
  node.allow_keys(keys::faces);
  for (const auto& [key, value] : node.entries())
    for (const std::size_t i : face_indices(key)) domain.heat[i] = load_surface(value);
}

void load_heat_regions(const Node& node, Scene& scene) {
  for (const Node& item : node.items("regions"))
    scene.heat_regions.push_back(load_region(item, scene.heat_regions.size() + 1));
}

Json heat_regions_json(const Scene& scene) {
  Json json;
  for (const SceneHeatRegion& region : scene.heat_regions) {
    Json r = {{"name", region.desc.name}, {"shape", region.shape.echo}};
    if (region.desc.temperature) r["temperature"] = *region.desc.temperature;
    else r["source"] = region.desc.source;
    r["from"] = region.desc.from;
    r["until"] = echo_number(region.desc.until);
    json.push_back(r);
  }
  return json;
}

}  // namespace runner
