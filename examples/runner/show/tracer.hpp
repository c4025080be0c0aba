// SPDX-License-Identifier: Apache-2.0
// The built-in renderer: light traced through a frame, on the CPU, with nothing to install.
#pragma once

#include "show/bvh.hpp"
#include "show/camera.hpp"
#include "show/image.hpp"
#include "show/tank.hpp"

namespace runner {

enum class Look {
  natural,     ///< water that refracts, solids in a colour per body
  temperature  ///< cold blue, hot red; liquid lets half of what is behind it through
};

struct TraceSettings {
  int width = 960, height = 540;
  int samples = 2;  ///< per pixel along each side
  int threads = 0;  ///< 0 = all
  Look look = Look::natural;
  double cold = 0, hot = 1;      ///< ends of the ramp [degrees Celsius]
  std::vector<Rgb> bodies;       ///< colours of the first ones; a palette goes on from there
  std::vector<SceneLook> looks;  ///< of materials, for liquids
  double spacing = 0;            ///< [m]
  double extent = 0;             ///< [m] of what a row of pictures shows; 0 = of this frame
  bool has_floor = true;
  double floor = 0;       ///< its height along the camera's up [m]
  std::vector<Bar> tank;  ///< the domain's walls
  Box basin;              ///< the domain, whose own floor is darker; empty = none is drawn
};

/// Edge of the floor's tiles for a picture of something this large [m]: 1, 2 or 5 times a power of ten.
double tile_size(double size);
/// Linear light of a body, 1 + its index.
Rgb body_color(const TraceSettings& settings, std::size_t body);
Image traced(const FrameShapes& shapes, const Camera& camera, const TraceSettings& settings);
/// Whether the camera stands inside something solid, and would see nothing but its inside.
bool eye_in_solid(const FrameShapes& shapes, const Camera& camera);
inline constexpr const char* eye_in_solid_text = "the camera stands inside a solid: move output.camera.eye";

}  // namespace runner
