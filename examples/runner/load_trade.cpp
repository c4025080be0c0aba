// SPDX-License-Identifier: Apache-2.0
// trade: what matters in a scene, and how exactly.
#include <fmt/format.h>

#include <algorithm>

#include "load_parts.hpp"
#include "numbers.hpp"
#include "scene_keys.hpp"
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

void load_trade(const Node& node, Scene& scene) {
  node.allow_keys(keys::trade);
  SceneTrade& trade = scene.trade;
  if (const auto list = node.find("observe")) {
    trade.observe_where = list->where();
    for (const Node& item : list->items("observables"))
      trade.observe.push_back(observable(item, item.text("an observable")));
    if (trade.observe.empty())
      list->fail("expected one observable at least; leave it out to have those that follow from the scene");
  }
  if (const auto value = node.find("max_error")) {
    trade.max_error_where = value->where();
    const auto share = parse_share(value->text("a share"));
    if (!share)
      value->fail(
          fmt::format("expected a share above 0 and up to 1, like 0.03 or 3%, got {}", value->found()));
    trade.max_error = share;
  }
  if (const auto answers = node.find("exact")) {
    for (const auto& [name, value] : answers->entries())
      trade.exact.emplace_back(observable(value, name), exact(value));
  }
}

}  // namespace runner
