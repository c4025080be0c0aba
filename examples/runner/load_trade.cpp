// SPDX-License-Identifier: Apache-2.0
// trade: what matters in a scene, and how exactly.
#include <fmt/format.h>

#include <algorithm>

#include "load_parts.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

/// The word before an @ is one of the observables; what stands behind it only the World can tell.
std::string observable(const Node& node, const std::string& name) {
  const std::string word = name.substr(0, name.find('@'));
  if (std::count(keys::observables.begin(), keys::observables.end(), word) > 0) return name;
  const std::string near = nearest(word, keys::observables);
  node.fail(fmt::format("expected {}, got \"{}\"{}", either_of(keys::observables), name,
                        near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

std::vector<ExactPoint> exact(const Node& node) {
  if (!node.is_list()) return {{0, node.number("of the observable")}};
  std::vector<ExactPoint> points;
  for (const Node& item : node.items("pairs [time, value]")) {
    const std::vector<Node> pair = item.items("2 numbers [time, value]");
    if (pair.size() != 2) item.fail(fmt::format("expected 2 numbers [time, value], got {}", item.found()));
    points.push_back({pair[0].number("s"), pair[1].number("of the observable")});
    if (points.size() > 1 && !(points[points.size() - 2].time < points.back().time))
      item.fail("times must ascend");
  }
  if (points.empty()) node.fail("expected a number or a list of pairs [time, value], got an empty list");
  return points;
}

}  // namespace

void load_observe(const Node& node, Scene& scene) {
  scene.trade.observe_where = node.where();
  for (const Node& item : node.items("observables"))
    scene.trade.observe.push_back(observable(item, item.text("an observable")));
  if (scene.trade.observe.empty())
    node.fail("expected one observable at least; leave it out to have those that follow from the scene");
}

void load_exact(const Node& node, Scene& scene) {
  for (const auto& [name, value] : node.entries())
    scene.trade.exact.emplace_back(observable(value, name), exact(value));
}

Json exact_json(const Scene& scene) {
  Json json;
  for (const auto& [name, points] : scene.trade.exact) {
    if (points.size() == 1) json[name] = points.front().value;
    else
      for (const ExactPoint& point : points) json[name].push_back({point.time, point.value});
  }
  return json;
}

}  // namespace runner
