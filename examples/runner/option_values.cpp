// SPDX-License-Identifier: Apache-2.0
#include "option_values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "csv.hpp"
#include "failure.hpp"
#include "numbers.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

[[noreturn]] void bad(const std::string& option, const std::string& expected, const std::string& value,
                      const std::string& hint = "") {
  throw Failure(ExitCode::usage, fmt::format("{}: expected {}, got \"{}\"{}", option, expected, value, hint));
}

}  // namespace

double option_not_negative(const std::string& option, const std::string& value) {
  const auto number = parse_number(value);
  if (!number || !std::isfinite(*number) || *number < 0) bad(option, "a number of 0 or more", value);
  return *number;
}

double option_positive(const std::string& option, const std::string& value) {
  const auto number = parse_number(value);
  if (!number || !std::isfinite(*number) || *number <= 0) bad(option, "a number above 0", value);
  return *number;
}

double option_share(const std::string& option, const std::string& value) {
  const auto share = parse_share(value);
  if (!share) bad(option, "a share above 0 and up to 1, like 0.03 or 3%", value);
  return *share;
}

double option_milliseconds(const std::string& option, const std::string& value) {
  std::string text = value;
  double unit = 0;
  if (text.size() > 2 && text.compare(text.size() - 2, 2, "ms") == 0) {
    text.resize(text.size() - 2);
    unit = 1;
  } else if (text.size() > 1 && text.back() == 's') {
    text.pop_back();
    unit = 1000;
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  const auto number = parse_number(text);
  if (!number || !std::isfinite(*number) || *number <= 0)
    bad(option, "a time above 0 like 16ms or 0.016s", value);
  if (unit == 0)
    bad(option, "a time with its unit like 16ms or 0.016s", value,
        fmt::format("; did you mean {0:g}ms or {0:g}s?", *number));
  return *number * unit;
}

std::uint64_t option_count(const std::string& option, const std::string& value) {
  const auto number = parse_integer(value);
  if (!number || *number < 0) bad(option, "a whole number of 0 or more", value);
  return static_cast<std::uint64_t>(*number);
}

std::string option_choice(const std::string& option, const std::string& value,
                          const std::vector<std::string>& names) {
  if (std::count(names.begin(), names.end(), value) > 0) return value;
  // "gpu" is one letter from "cpu", but that is not what was meant.
  const bool means_cuda = value == "gpu" && std::count(names.begin(), names.end(), "cuda") > 0;
  const std::string near = means_cuda ? "cuda" : nearest(value, names);
  bad(option, either_of(names), value, near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
}

std::vector<std::string> option_list(const std::string& option, const std::string& value) {
  const char* const blanks = " \t";
  std::string line = value;
  std::replace(line.begin(), line.end(), '\n', ',');  // an option that is given twice has two lines
  std::vector<std::string> names;
  for (const std::string& given : split_commas(line)) {
    const std::size_t first = given.find_first_not_of(blanks), last = given.find_last_not_of(blanks);
    if (first == std::string::npos)
      bad(option, "names with one comma between each", line, "; take the empty name out");
    names.push_back(given.substr(first, last - first + 1));
  }
  return names;
}

std::vector<std::string> option_formats(const std::string& value) {
  std::vector<std::string> formats;
  const std::vector<std::string> names = option_list("--export", value);
  if (names == std::vector<std::string>{"none"}) return formats;
  for (const std::string& format : names) {
    option_choice("--export", format, keys::formats);
    if (std::count(formats.begin(), formats.end(), format) == 0) formats.push_back(format);
  }
  return formats;
}

int option_between(const std::string& option, const std::string& value, int least, int most) {
  const auto number = parse_integer(value);
  if (!number || *number < least || *number > most)
    bad(option, fmt::format("a whole number from {} to {}", least, most), value);
  return static_cast<int>(*number);
}

std::pair<int, int> option_size(const std::string& option, const std::string& value) {
  const std::size_t x = value.find('x');
  const auto width = parse_integer(value.substr(0, x)),
             height = parse_integer(x == std::string::npos ? "" : value.substr(x + 1));
  const auto fits = [](const std::optional<std::int64_t>& n) { return n && *n >= 16 && *n <= 8192; };
  if (!fits(width) || !fits(height)) bad(option, "WIDTHxHEIGHT, 16 to 8192 pixels each, e.g. 960x540", value);
  return {static_cast<int>(*width), static_cast<int>(*height)};
}

std::string shell_quoted(const std::string& word) {
  const char* safe = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
  if (!word.empty() && word.find_first_not_of(safe) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace runner
