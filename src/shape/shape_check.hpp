// SPDX-License-Identifier: Apache-2.0
// Checks of the fields of shapes. Each names the field, its value, and what is allowed.
#pragma once

#include <charconv>
#include <string>

#include "meltsim/result.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

inline std::string number_text(double value) {
  char text[32];  // whatever the host's locale is
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 9).ptr};
}
Status refuse_shape(std::string message);
Status check_number(const std::string& field, double value);
Status check_point(const std::string& field, Vec3d value);
Status check_positive(const std::string& field, double value);
/// A direction: finite and not zero.
Status check_axis(const std::string& field, Vec3d value);

}  // namespace v0
}  // namespace meltsim
