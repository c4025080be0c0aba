// SPDX-License-Identifier: Apache-2.0
// Checks of the fields of shapes. Each names the field, its value, and what is allowed.
#pragma once

#include <cstdio>
#include <string>

#include "meltsim/result.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

inline std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}
Status refuse_shape(std::string message);
Status check_number(const std::string& field, double value);
Status check_point(const std::string& field, Vec3d value);
Status check_positive(const std::string& field, double value);
/// A direction: finite and not zero.
Status check_axis(const std::string& field, Vec3d value);

}  // namespace v0
}  // namespace meltsim
