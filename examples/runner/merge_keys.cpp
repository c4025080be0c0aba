// SPDX-License-Identifier: Apache-2.0
#include "merge_keys.hpp"

#include <fmt/format.h>

#include <set>
#include <utility>
#include <vector>

#include "failure.hpp"

namespace runner {

namespace {

const std::string merge_key = "<<";

bool is_key(const YAML::Node& key, const std::string& name) { return key.IsScalar() && key.Scalar() == name; }

bool has_key(const YAML::Node& map, const YAML::Node& key) {
  for (const auto& entry : map)
    if (key.IsScalar() && is_key(entry.first, key.Scalar())) return true;
  return false;
}

class Merges {
 public:
  explicit Merges(std::string file) : file_(std::move(file)) {}

  /// Visits each list and mapping once: aliases share them, and may lead back.
  void resolve(YAML::Node node) {
    if (!(node.IsMap() || node.IsSequence()) || !seen_.emplace(node.Mark().pos, node.IsMap()).second) return;
    if (node.IsMap()) merge(node);
    for (const auto& child : node) {
      if (node.IsMap()) resolve(child.second);
      else resolve(child);
    }
  }

 private:
  void merge(YAML::Node node) {
    std::vector<YAML::Node> sources;
    for (const auto& entry : node) {
      if (!is_key(entry.first, merge_key)) continue;
      if (!entry.second.IsSequence()) sources.push_back(entry.second);
      else
        for (const auto& source : entry.second) sources.push_back(source);
    }
    for (const YAML::Node& source : sources) take(node, source);
    while (node.remove(merge_key)) {
    }
  }

  void take(YAML::Node node, const YAML::Node& source) {
    if (!source.IsMap())
      throw Failure(
          ExitCode::scene,
          fmt::format("{}:{}:{}: <<: expected a mapping to merge or a list of them, got {}; name an "
                      "anchor of one, like *ice for &ice {{...}}",
                      file_, source.Mark().line + 1, source.Mark().column + 1,
                      source.IsScalar() ? "\"" + source.Scalar() + "\"" : "no mapping"));
    resolve(source);
    for (const auto& entry : source)
      if (!is_key(entry.first, merge_key) && !has_key(node, entry.first)) node[entry.first] = entry.second;
  }

  std::string file_;
  std::set<std::pair<int, bool>> seen_;  ///< where they stand; a mapping may begin where a list does
};

}  // namespace

void resolve_merge_keys(const YAML::Node& root, const std::string& file) { Merges(file).resolve(root); }

}  // namespace runner
