// SPDX-License-Identifier: Apache-2.0
#include "shape/mesh_text.hpp"

#include <algorithm>
#include <charconv>

namespace meltsim {
inline namespace v0 {
namespace {

constexpr std::string_view blanks = " \t\r\n\v\f";

std::string_view without_plus(std::string_view token) {
  // The C++ conversions refuse a leading plus; the formats allow it. "+-1" stays refused.
  return token.size() > 1 && token[0] == '+' && token[1] != '-' ? token.substr(1) : token;
}

}  // namespace

bool TextLines::next() {
  if (next_ >= text_.size()) return false;
  number_ += 1 + joined_;
  joined_ = 0;
  const std::size_t begin = next_;
  std::size_t end = begin;
  for (;;) {
    end = std::min(text_.find('\n', end), text_.size());
    next_ = std::min(end + 1, text_.size());
    if (!continued_ || next_ == text_.size()) break;
    const std::size_t last = end > begin && text_[end - 1] == '\r' ? end - 1 : end;
    if (last == begin || text_[last - 1] != '\\') break;
    ++joined_;
    ++end;
  }
  line_ = text_.substr(begin, end - begin);
  return true;
}

std::string_view TextLines::token() {
  const auto blank = [this](char c) {
    return blanks.find(c) != std::string_view::npos || (continued_ && c == '\\');
  };
  std::size_t begin = 0;
  while (begin < line_.size() && blank(line_[begin])) ++begin;
  std::size_t end = begin;
  while (end < line_.size() && !blank(line_[end])) ++end;
  const std::string_view found = line_.substr(begin, end - begin);
  line_.remove_prefix(end);
  return found;
}

bool parse_number(std::string_view token, double& value) {
  token = without_plus(token);
  const char* end = token.data() + token.size();
  const auto [stop, problem] = std::from_chars(token.data(), end, value);
  if (stop != end || token.empty()) return false;
  if (problem == std::errc::result_out_of_range) {
    // Too small or too large is not told apart. Whatever is too small for a double lies at the origin.
    const bool tiny =
        token.find("e-") != std::string_view::npos || token.find("E-") != std::string_view::npos;
    value = tiny ? 0 : infinity;
    return true;
  }
  return problem == std::errc();
}

bool parse_integer(std::string_view token, std::int64_t& value) {
  token = without_plus(token);
  const char* end = token.data() + token.size();
  const auto [stop, problem] = std::from_chars(token.data(), end, value);
  return problem == std::errc() && stop == end && !token.empty();
}

bool same_word(std::string_view token, std::string_view lower_case) {
  const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; };
  return token.size() == lower_case.size() &&
         std::equal(token.begin(), token.end(), lower_case.begin(), same);
}

std::string quoted(std::string_view token) {
  if (token.empty()) return "the end of the line";
  std::string out = "'";
  for (const char c : token.substr(0, 40)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (token.size() > 40 ? "...'" : "'");
}

Status read_point(const MeshSource& source, TextLines& lines, Vec3d& point) {
  for (double* c : {&point.x, &point.y, &point.z}) {
    const std::string_view token = lines.token();
    if (!parse_number(token, *c))
      return source.error(lines.place(), "expected three coordinates, found " + quoted(token));
  }
  return {};
}

}  // namespace v0
}  // namespace meltsim
