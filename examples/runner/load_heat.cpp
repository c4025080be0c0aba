// SPDX-License-Identifier: Apache-2.0
// Heat through walls and through the surface of a body; properties that depend on temperature.
#include "load_heat.hpp"

#include <fmt/format.h>

#include <array>

#include "load_parts.hpp"
#include "numbers.hpp"

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

void load_timed(const Node& value, const char* unit, double& first,
                std::vector<meltsim::TimedValue>& points) {
  points.clear();
  if (!value.is_list()) {
    first = value.number(unit);
    return;
  }
  for (const Node& item : value.items("points [[time, value], ...]")) {
    const auto pair = item.is_list() ? item.items("a point") : std::vector<Node>{};
    if (pair.size() != 2)
      item.fail(fmt::format("expected [time, value] (s, {}), got {}", unit, item.found()));
    points.push_back({pair[0].number("s"), pair[1].number(unit)});
    if (points.size() > 1 && !(points.back().time > points[points.size() - 2].time))
      pair[0].fail(fmt::format("{:g} s is not after the point before it, at {:g} s; times must ascend",
                               points.back().time, points[points.size() - 2].time));
  }
  if (points.empty())
    value.fail(fmt::format("expected a number ({}) or points [[time, value], ...], got an empty list", unit));
  first = points.front().value;
}

namespace {
/// The rows of a path, whose times ascend; what is not given is 0.
std::vector<std::array<double, 5>> load_rows(const Node& value, std::size_t most, const char* expected) {
  std::vector<std::array<double, 5>> rows;
  for (const Node& item : value.items("points [[time, x, y, z], ...]")) {
    const auto row = item.is_list() ? item.items("a point") : std::vector<Node>{};
    if (row.size() < 4 || row.size() > most)
      item.fail(fmt::format("expected {}, got {}", expected, item.found()));
    std::array<double, 5> x{row[0].number("s")};
    if (!rows.empty() && !(x[0] > rows.back()[0]))
      row[0].fail(fmt::format("{:g} s is not after the point before it, at {:g} s; times must ascend", x[0],
                              rows.back()[0]));
    for (std::size_t k = 1; k < row.size(); ++k) x[k] = row[k].number(k < 4 ? "m" : "degrees");
    rows.push_back(x);
  }
  return rows;
}
}  // namespace

std::vector<meltsim::PathPoint> load_path(const Node& value) {
  std::vector<meltsim::PathPoint> path;
  for (const auto& x : load_rows(value, 4, "[time, x, y, z] (s, m)"))
    path.push_back({x[0], {x[1], x[2], x[3]}});
  return path;
}

std::vector<meltsim::PosePoint> load_poses(const Node& value) {
  std::vector<meltsim::PosePoint> path;
  for (const auto& x : load_rows(value, 5, "[time, x, y, z] or [time, x, y, z, angle] (s, m, degrees)"))
    path.push_back({x[0], {x[1], x[2], x[3]}, x[4] / degrees});
  return path;
}

void load_wall_heat(const Node& node, meltsim::DomainDesc& domain) {
  node.allow_keys(keys::faces);
  for (const auto& [key, value] : node.entries())
    for (const std::size_t i : face_indices(key)) domain.heat[i] = load_surface(value);
}

}  // namespace runner
