// SPDX-License-Identifier: Apache-2.0
// Heat through walls and through the surface of a body; properties that depend on temperature.
#include "load_heat.hpp"

#include <fmt/format.h>

#include "load_parts.hpp"

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
  const std::vector<Node> items = value.items(key);
  if (items.empty())
    value.fail(
        fmt::format("expected a number ({}) or points [[temperature, value], ...], got an empty list", unit));
  for (const Node& item : items) {
    const auto pair = item.is_list() ? item.items("a point") : std::vector<Node>{};
    if (pair.size() != 2)
      item.fail(
          fmt::format("expected [temperature, value] (degrees Celsius, {}), got {}", unit, item.found()));
    points.push_back({pair[0].number("degrees Celsius"), pair[1].number(unit)});
  }
}

void load_wall_heat(const Node& node, meltsim::DomainDesc& domain) {
  node.allow_keys(keys::faces);
  for (const auto& [key, value] : node.entries())
    for (const std::size_t i : face_indices(key)) domain.heat[i] = load_surface(value);
}

}  // namespace runner
