// SPDX-License-Identifier: Apache-2.0
#include "node.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "failure.hpp"
#include "numbers.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

std::string mark_text(const std::string& file, const YAML::Mark& mark) {
  if (mark.is_null()) return file;
  return fmt::format("{}:{}:{}", file, mark.line + 1, mark.column + 1);
}

/// Long or binary text is cut: the message is for reading.
std::string quoted(const std::string& text) {
  std::string shown;
  for (const char c : text.substr(0, 60)) shown += static_cast<unsigned char>(c) < 32 ? ' ' : c;
  if (text.size() > 60) shown += "...";
  return "\"" + shown + "\"";
}

bool is_plain(const YAML::Node& node) { return node.IsScalar() && node.Tag() != "!"; }

}  // namespace

Node::Node(YAML::Node value, std::shared_ptr<const Document> document)
    : value_(std::move(value)), document_(std::move(document)) {}

Node::Node(YAML::Node value, std::shared_ptr<const Document> document, std::string path, std::string option)
    : value_(std::move(value)),
      document_(std::move(document)),
      path_(std::move(path)),
      option_(std::move(option)) {}

Node Node::child(const YAML::Node& value, const std::string& path) const {
  const auto set = document_->overrides.find(path);
  return {value, document_, path, set == document_->overrides.end() ? option_ : set->second};
}

std::string Node::child_path(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

std::string Node::where() const {
  if (!option_.empty()) return "--set " + option_;
  return mark_text(document_->file, value_.Mark());
}

std::string Node::key_where(const YAML::Node& key) const {
  const auto set = document_->overrides.find(child_path(key.Scalar()));
  if (set != document_->overrides.end()) return "--set " + set->second;
  if (!option_.empty()) return "--set " + option_;
  return mark_text(document_->file, key.Mark());
}

void Node::fail(const std::string& message) const {
  const std::string subject = path_.empty() ? "" : path_ + ": ";
  throw Failure(ExitCode::scene, fmt::format("{}: {}{}", where(), subject, message));
}

std::string Node::found() const {
  if (value_.IsScalar()) return quoted(value_.Scalar());
  if (value_.IsSequence()) return fmt::format("a list of {}", value_.size());
  if (value_.IsMap()) return "a mapping";
  return "nothing";
}

std::vector<std::pair<std::string, Node>> Node::entries() const {
  if (!value_.IsMap()) fail("expected a mapping {key: value}, got " + found());
  std::vector<std::pair<std::string, Node>> list;
  std::map<std::string, int> first_line;
  const std::string parent = path_.empty() ? "the scene" : path_;
  for (const auto& entry : value_) {
    if (!entry.first.IsScalar()) fail("expected names as keys, got a key that is a list or a mapping");
    const std::string key = entry.first.Scalar();
    const auto [seen, fresh] = first_line.emplace(key, entry.first.Mark().line + 1);
    if (!fresh) {
      throw Failure(ExitCode::scene, fmt::format("{}: duplicate key {} in {}; first given on line {}",
                                                 key_where(entry.first), quoted(key), parent, seen->second));
    }
    list.emplace_back(key, child(entry.second, child_path(key)));
  }
  return list;
}

void Node::allow_keys(const std::vector<std::string>& known,
                      const std::map<std::string, std::string>& instead) const {
  entries();  // not a mapping, or a key given twice
  for (const auto& entry : value_) {
    const std::string key = entry.first.Scalar();
    bool is_known = false;
    for (const std::string& name : known) is_known = is_known || name == key;
    if (is_known) continue;
    const auto other = instead.find(key);
    throw Failure(ExitCode::scene, fmt::format("{}: unknown key {} in {}{}", key_where(entry.first),
                                               quoted(key), path_.empty() ? "the scene" : path_,
                                               other != instead.end() ? "; " + other->second
                                                                      : suggestion(key, known, "keys")));
  }
}

std::optional<Node> Node::find(const std::string& key) const {
  for (const auto& entry : value_) {
    if (entry.first.IsScalar() && entry.first.Scalar() == key) return child(entry.second, child_path(key));
  }
  return std::nullopt;
}

Node Node::require(const std::string& key, const std::string& meaning) const {
  if (auto node = find(key)) return *node;
  throw Failure(ExitCode::scene, fmt::format("{}: missing key \"{}\" in {}: {}", where(), key,
                                             path_.empty() ? "the scene" : path_, meaning));
}

Source Node::source() const {
  Source source{path_, where(), {}};
  for (const auto& entry : value_) {
    if (!entry.first.IsScalar()) continue;
    const std::string key = entry.first.Scalar();
    source.keys[key] = child(entry.second, child_path(key)).where();
  }
  return source;
}

std::vector<Node> Node::items(const std::string& of_what) const {
  if (!value_.IsSequence()) fail(fmt::format("expected a list of {}, got {}", of_what, found()));
  std::vector<Node> list;
  for (std::size_t i = 0; i < value_.size(); ++i) {
    list.push_back(child(value_[i], fmt::format("{}[{}]", path_, i)));
  }
  return list;
}

double Node::number_or_infinite(const std::string& unit) const {
  const std::string expected =
      unit.empty() ? "expected a number" : fmt::format("expected a number ({})", unit);
  auto value = value_.IsScalar() ? parse_number(value_.Scalar()) : std::nullopt;
  // JSON has no infinity, so there it is written as text; other numbers in quotes are mistakes.
  if (value && !is_plain(value_) && !std::isinf(*value)) value.reset();
  if (!value) {
    const bool in_quotes = value_.IsScalar() && !is_plain(value_) && parse_number(value_.Scalar());
    const bool in_hundredths = is_plain(value_) && !value_.Scalar().empty() && value_.Scalar().back() == '%';
    const auto share = in_hundredths ? parse_share(value_.Scalar()) : std::nullopt;
    fail(fmt::format("{}, got {}{}", expected, found(),
                     in_quotes ? "; remove the quotes"
                     : share   ? fmt::format("; write {:g}", *share)
                               : ""));
  }
  if (std::isnan(*value)) fail(fmt::format("{}, got {}", expected, found()));
  return *value;
}

double Node::number(const std::string& unit) const {
  const double value = number_or_infinite(unit);
  if (std::isinf(value)) fail(fmt::format("expected a finite number ({}), got {}", unit, found()));
  return value;
}

double Node::positive(const std::string& unit) const {
  const double value = number(unit);
  if (!(value > 0)) fail(fmt::format("expected a number above 0 ({}), got {}", unit, found()));
  return value;
}

std::int64_t Node::integer(const std::string& expected) const {
  const auto value = is_plain(value_) ? parse_integer(value_.Scalar()) : std::nullopt;
  if (!value) fail("expected " + expected + ", got " + found());
  return *value;
}

int Node::small_integer(const std::string& expected) const {
  const std::int64_t value = integer(expected);
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
    fail("expected a smaller whole number, got " + found());
  }
  return static_cast<int>(value);
}

bool Node::boolean(const std::string& expected) const {
  if (is_plain(value_) && is_word("true")) return true;
  if (is_plain(value_) && is_word("false")) return false;
  fail(fmt::format("expected {}, got {}", expected, found()));
}

std::string Node::text(const std::string& meaning) const {
  if (!value_.IsScalar()) fail(fmt::format("expected {}, got {}", meaning, found()));
  return value_.Scalar();
}

std::string Node::choice(const std::vector<std::string>& names) const {
  const std::string value = value_.IsScalar() ? value_.Scalar() : "";
  for (const std::string& name : names) {
    if (name == value) return name;
  }
  const std::string near = nearest(value, names);
  fail(fmt::format("expected {}, got {}{}", either_of(names), found(),
                   near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
}

bool Node::is_word(const std::string& word) const { return value_.IsScalar() && value_.Scalar() == word; }

meltsim::Vec3d Node::vector(const std::string& unit) const {
  if (!value_.IsSequence() || value_.size() != 3) {
    fail(fmt::format("expected 3 numbers [x, y, z] ({}), got {}", unit, found()));
  }
  const std::vector<Node> list = items("numbers");
  return {list[0].number(unit), list[1].number(unit), list[2].number(unit)};
}

}  // namespace runner
