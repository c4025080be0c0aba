// SPDX-License-Identifier: Apache-2.0
// Lines and tokens of text files. Numbers are read without regard to the locale of the process.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "shape/mesh_builder.hpp"

namespace meltsim {
inline namespace v0 {

class TextLines {
 public:
  /// Where `continued` is set a backslash at the end of a line joins the next one to it.
  TextLines(std::string_view text, bool continued) : text_(text), continued_(continued) {}

  /// Goes to the next line; false at the end of the text.
  bool next();
  /// Next token of the line, empty at its end.
  std::string_view token();
  FilePlace place() const { return {FilePlace::line, number_}; }
  /// Byte behind the current line and its end.
  std::size_t behind() const { return next_; }

 private:
  std::string_view text_, line_;
  std::size_t next_ = 0;
  std::uint64_t number_ = 0, joined_ = 0;
  bool continued_;
};

/// Whole token as a number: false where it is anything else. NaN and infinity are numbers here.
bool parse_number(std::string_view token, double& value);
bool parse_integer(std::string_view token, std::int64_t& value);
bool same_word(std::string_view token, std::string_view lower_case);
/// For error messages: quoted, shortened, and without bytes that cannot be shown.
std::string quoted(std::string_view token);

/// Reads three numbers from the line or says what was there instead.
Status read_point(const MeshSource& source, TextLines& lines, Vec3d& point);

}  // namespace v0
}  // namespace meltsim
