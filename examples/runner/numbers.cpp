// SPDX-License-Identifier: Apache-2.0
#include "numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace runner {

namespace {

/// What a scene may be written with: "nan(...)" is none of it.
bool looks_decimal(const std::string& text) {
  if (text.empty()) return false;
  return std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isdigit(c) != 0 || c == '+' || c == '-' || c == '.' || c == 'e' || c == 'E';
  });
}

/// A number beyond those of a double: what is too large is infinite, what is too small 0.
double out_of_range(const std::string& text) {
  const std::size_t e = text.find_first_of("eE");
  const bool small =
      e == std::string::npos ? text.find_first_of("123456789") > text.find('.') : text[e + 1] == '-';
  const double size = small ? 0 : std::numeric_limits<double>::infinity();
  return text[0] == '-' ? -size : size;
}

}  // namespace

std::optional<double> parse_number(const std::string& text) {
  const double inf = std::numeric_limits<double>::infinity();
  if (text == ".inf" || text == "+.inf" || text == "inf" || text == "infinity") return inf;
  if (text == "-.inf" || text == "-inf" || text == "-infinity") return -inf;
  if (text == ".nan" || text == "nan") return std::numeric_limits<double>::quiet_NaN();
  if (!looks_decimal(text)) return std::nullopt;
  // Not strtod, which stops at the point where the host has set a locale that writes a comma. That takes a plus, and what is too large
  // for infinity.
  const char *const begin = text.c_str() + (text[0] == '+' ? 1 : 0), *const end = text.c_str() + text.size();
  if (begin != text.c_str() && begin != end && *begin == '-') return std::nullopt;
  double value = 0;
  const auto read = std::from_chars(begin, end, value);
  if (read.ptr != end) return std::nullopt;
  if (read.ec == std::errc::result_out_of_range) return out_of_range(text);
  return read.ec == std::errc() ? std::optional<double>(value) : std::nullopt;
}

double typed(double value) {
  const std::string text = fmt::format("{:.6g}", value);
  return parse_number(text).value_or(value);
}

std::optional<std::int64_t> parse_integer(const std::string& text) {
  if (!looks_decimal(text)) return std::nullopt;
  char* end = nullptr;
  errno = 0;
  const long long value = std::strtoll(text.c_str(), &end, 10);
  if (errno != 0 || end != text.c_str() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> parse_share(const std::string& text) {
  const std::size_t last = text.find_last_not_of(' ');
  const bool percent = last != std::string::npos && text[last] == '%';
  std::string digits = percent ? text.substr(0, last) : text;
  while (percent && !digits.empty() && digits.back() == ' ') digits.pop_back();
  const auto number = parse_number(digits);
  if (!number) return std::nullopt;
  const double share = percent ? *number / 100 : *number;
  return share > 0 && share <= 1 ? std::optional<double>(share) : std::nullopt;
}

double rounded_down(double value, int digits) {
  const double last = std::pow(10, std::floor(std::log10(value)) - digits + 1);
  return std::floor(value / last * (1 + 1e-12)) * last;
}

std::string bytes_text(double bytes) {
  if (bytes < 1e3) return fmt::format("{:.0f} B", bytes);
  if (bytes < 1e6) return fmt::format("{:.1f} kB", bytes / 1e3);
  if (bytes < 1e9) return fmt::format("{:.1f} MB", bytes / 1e6);
  return fmt::format("{:.1f} GB", bytes / 1e9);
}

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const auto total = static_cast<std::int64_t>(std::llround(seconds));
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total % 3600 / 60);
}

std::string count_text(std::uint64_t n) {
  std::string digits = std::to_string(n);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

std::string two_digits(double value) {
  return fmt::format(value >= 9.5 && value < 1e6 ? "{:.0f}" : "{:.2g}", value);
}

std::string percent_text(double share) {
  const double percent = share < 1 ? std::min(100 * share, 99.9) : 100 * share;
  return fmt::format("{:.1f} %", percent);
}

}  // namespace runner
