// SPDX-License-Identifier: Apache-2.0
#include "overrides.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "failure.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

/// One part of a path: a key or a position in a list.
struct Step {
  std::string key;
  std::optional<std::size_t> index;
};

[[noreturn]] void bad_option(const std::string& option, const std::string& why) {
  throw Failure(ExitCode::usage, fmt::format("--set {}: {}", option, why));
}

std::vector<Step> split_path(const std::string& path, const std::string& option) {
  const char* form = "expected path=value, e.g. heat.model=paper or bodies[0].temperature=-5";
  std::vector<Step> steps;
  std::size_t at = 0;
  while (at < path.size()) {
    if (path[at] == '[') {
      const std::size_t close = path.find(']', at);
      const auto index =
          close == std::string::npos ? std::nullopt : parse_integer(path.substr(at + 1, close - at - 1));
      if (!index || *index < 0) bad_option(option, form);
      steps.push_back({"", static_cast<std::size_t>(*index)});
      at = close + 1;
      if (at < path.size() && path[at] == '.') ++at;
      continue;
    }
    const std::size_t end = std::min(path.find_first_of(".[", at), path.size());
    if (end == at) bad_option(option, form);
    steps.push_back({path.substr(at, end - at), std::nullopt});
    at = end < path.size() && path[end] == '.' ? end + 1 : end;
  }
  if (steps.empty() || steps.front().index) bad_option(option, form);
  return steps;
}

YAML::Node parse_value(const std::string& text, const std::string& option) {
  try {
    YAML::Node value = YAML::Load(text);
    if (!value.IsDefined() || value.IsNull()) bad_option(option, "no value after \"=\"");
    return value;
  } catch (const YAML::Exception&) {
    bad_option(option, "the value is not valid YAML");
  }
}

/// Messages repeat the option; a list of a thousand things would drown what they say.
std::string shortened(const std::string& option) {
  constexpr std::size_t most = 70;
  return option.size() > most ? option.substr(0, most) + "..." : option;
}

void apply(YAML::Node root, const std::string& option, std::map<std::string, std::string>& overrides) {
  const std::size_t equals = option.find('=');
  if (equals == std::string::npos || equals == 0) {
    bad_option(option, "expected path=value, e.g. heat.model=paper or bodies[0].temperature=-5");
  }
  const std::string shown = shortened(option);
  const std::vector<Step> steps = split_path(option.substr(0, equals), option);
  const YAML::Node value = parse_value(option.substr(equals + 1), option);
  YAML::Node node = root;
  std::string path;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const bool last = i + 1 == steps.size();
    const std::string parent = path.empty() ? "the scene" : path;
    if (steps[i].index) {
      const std::size_t index = *steps[i].index;
      if (!node.IsSequence()) bad_option(option, parent + " is not a list");
      if (index >= node.size()) {
        bad_option(option, fmt::format("{} has {} entries, counted from 0", parent, node.size()));
      }
      path += fmt::format("[{}]", index);
      if (last) node[index] = value;
      else node.reset(node[index]);
    } else {
      const std::string& key = steps[i].key;
      if (!node.IsMap() && !node.IsNull()) bad_option(option, parent + " has no keys");
      path += (path.empty() ? "" : ".") + key;
      const bool exists = node.IsMap() && YAML::Node(node)[key].IsDefined();
      if (!exists) overrides[path] = shown;
      if (last) {
        node[key] = value;
      } else {
        if (!exists) node[key] = YAML::Node(YAML::NodeType::Map);
        node.reset(node[key]);
      }
    }
  }
  overrides[path] = shown;
}

}  // namespace

std::map<std::string, std::string> apply_overrides(YAML::Node& root,
                                                   const std::vector<std::string>& options) {
  std::map<std::string, std::string> overrides;
  for (const std::string& option : options) apply(root, option, overrides);
  return overrides;
}

}  // namespace runner
