// SPDX-License-Identifier: Apache-2.0
#include "shape/shape_check.hpp"

#include <cmath>

#include "shape/shape_limits.hpp"

namespace meltsim {
inline namespace v0 {

Status refuse_shape(std::string message) {
  return Error{ErrorCode::invalid_argument, "shape: " + std::move(message)};
}

Status check_number(const std::string& field, double value) {
  if (!std::isfinite(value)) return refuse_shape(field + " is " + number_text(value) + " but must be finite");
  if (std::abs(value) > max_coordinate)
    return refuse_shape(field + " is " + number_text(value) + " but must be at most 1e30 in magnitude");
  return {};
}

Status check_point(const std::string& field, Vec3d value) {
  if (Status s = check_number(field + ".x", value.x); !s) return s;
  if (Status s = check_number(field + ".y", value.y); !s) return s;
  return check_number(field + ".z", value.z);
}

Status check_positive(const std::string& field, double value) {
  if (Status s = check_number(field, value); !s) return s;
  if (!(value > 0)) return refuse_shape(field + " is " + number_text(value) + " but must be greater than 0");
  return {};
}

Status check_axis(const std::string& field, Vec3d value) {
  if (Status s = check_point(field, value); !s) return s;
  if (!(length(value) > 0)) return refuse_shape(field + " is (0, 0, 0) but must have a direction");
  return {};
}

}  // namespace v0
}  // namespace meltsim
