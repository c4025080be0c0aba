// SPDX-License-Identifier: Apache-2.0
// Values of a scene as JSON, in the form in which a scene gives them.
#pragma once

#include <cmath>

#include "scene.hpp"

namespace runner {

inline Json echo(const meltsim::Vec3d& v) { return Json::array({v.x, v.y, v.z}); }
inline Json echo(const std::optional<meltsim::Vec3d>& v) { return v ? echo(*v) : Json(); }

/// JSON has no infinity; a scene reads the text.
inline Json echo_number(double v) { return std::isinf(v) ? Json(v > 0 ? "inf" : "-inf") : Json(v); }

}  // namespace runner
