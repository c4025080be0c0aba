// SPDX-License-Identifier: Apache-2.0
// Building error messages: text("density: ", value, " kg/m^3").
#pragma once

#include <charconv>
#include <cstdint>
#include <string>

#include "meltsim/result.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

inline std::string to_text(const std::string& s) { return s; }
inline std::string to_text(const char* s) { return s; }
/// A number with so many digits: all that count (general) or after the point (fixed). Not by printf, which writes a comma where the
/// host has set a locale that does.
inline std::string number_text(double v, std::chars_format format, int digits) {
  char buffer[400];  // a fixed one may have 309 before the point
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, v, format, digits).ptr};
}
inline std::string to_text(double v) { return number_text(v, std::chars_format::general, 6); }
inline std::string to_text(int v) { return std::to_string(v); }
inline std::string to_text(std::uint32_t v) { return std::to_string(v); }
inline std::string to_text(std::uint64_t v) { return std::to_string(v); }
inline std::string to_text(Vec3d v) {
  return "(" + to_text(v.x) + ", " + to_text(v.y) + ", " + to_text(v.z) + ")";
}

template <class... Parts>
std::string text(const Parts&... parts) {
  return (std::string() + ... + to_text(parts));
}

template <class... Parts>
Error invalid(const Parts&... parts) {
  return Error{ErrorCode::invalid_argument, text(parts...)};
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
