// SPDX-License-Identifier: Apache-2.0
// A value of a scene together with where it stands: every reader either returns a checked value or fails with
// "file:line:column: path: what was expected, what was found".
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meltsim/types.hpp"

namespace runner {

/// What a scene was read from.
struct Document {
  std::string file;                              ///< as shown in messages
  std::string directory;                         ///< relative mesh paths start here
  std::map<std::string, std::string> overrides;  ///< path -> the --set text that gave it, shortened
};

/// The location of a mapping and of each of its keys, kept for errors that only the library can find.
struct Source {
  std::string path;                         ///< "bodies[0]"
  std::string where;                        ///< "fig4.yaml:14:3"
  std::map<std::string, std::string> keys;  ///< key -> "fig4.yaml:14:28"
};

class Node {
 public:
  Node(YAML::Node value, std::shared_ptr<const Document> document);

  const std::string& path() const { return path_; }
  std::string where() const;  ///< "fig4.yaml:14:28", or the --set option
  const Document& document() const { return *document_; }
  [[noreturn]] void fail(const std::string& message) const;  ///< "where: path: message"

  // Mappings.
  bool is_mapping() const { return value_.IsMap(); }
  /// Fails on keys that are not in `known` and on keys given twice. `instead` says of words that others may try what to write.
  void allow_keys(const std::vector<std::string>& known,
                  const std::map<std::string, std::string>& instead = {}) const;
  /// All entries in order; fails on keys given twice.
  std::vector<std::pair<std::string, Node>> entries() const;
  std::optional<Node> find(const std::string& key) const;
  Node require(const std::string& key, const std::string& meaning) const;
  Source source() const;

  // Lists.
  bool is_list() const { return value_.IsSequence(); }
  std::vector<Node> items(const std::string& of_what) const;

  // Scalars. Units are for the message only: scenes are in SI and degrees Celsius.
  double number(const std::string& unit) const;  ///< finite
  double number_or_infinite(const std::string& unit) const;
  double positive(const std::string& unit) const;
  std::int64_t integer(const std::string& expected = "a whole number") const;
  int small_integer(const std::string& expected = "a whole number") const;  ///< fits an int
  bool boolean(const std::string& expected = "true or false") const;
  std::string text(const std::string& meaning) const;
  std::string choice(const std::vector<std::string>& names) const;
  bool is_word(const std::string& word) const;  ///< exactly this text, in quotes (JSON) or not
  meltsim::Vec3d vector(const std::string& unit) const;

  /// For messages: `"heavy"`, `a list of 2`, `a mapping`, `nothing`.
  std::string found() const;

 private:
  Node(YAML::Node value, std::shared_ptr<const Document> document, std::string path, std::string option);
  Node child(const YAML::Node& value, const std::string& path) const;
  std::string key_where(const YAML::Node& key) const;
  std::string child_path(const std::string& key) const;

  YAML::Node value_;
  std::shared_ptr<const Document> document_;
  std::string path_;
  std::string option_;  ///< the --set text this value came from, or empty
};

}  // namespace runner
