// SPDX-License-Identifier: Apache-2.0
// A frame as a scene of POV-Ray 3.7: refractive liquid, smooth solids, floor, light; or temperatures.
#pragma once

#include <string>

#include "show/camera.hpp"
#include "show/shapes.hpp"
#include "show/tracer.hpp"

namespace runner {

/// Self-contained: `povray frame.pov +W960 +H540 +A0.1` makes the picture. A frame without liquid or without
/// solids is a valid scene too.
std::string pov_text(const FrameShapes& shapes, const Camera& camera, const TraceSettings& settings);

}  // namespace runner
