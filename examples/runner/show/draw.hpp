// SPDX-License-Identifier: Apache-2.0
// A frame to a finished picture of the built-in renderer.
#pragma once

#include "show/image.hpp"
#include "show/shapes.hpp"
#include "show/tracer.hpp"

namespace runner {

struct PictureWish {
  int width = 960, height = 540, samples = 3, threads = 0;
  Look look = Look::natural;
  double cold = 0, hot = 1;  ///< ends of the ramp [degrees Celsius]
  double extent = 0;  ///< [m] of what a row of pictures shows: tiles and shades stay as they are; 0 = domain
  double aspect() const { return static_cast<double>(width) / height; }  ///< width to height
};

/// With its time, and in the temperature view with a legend.
Image draw(const FrameShapes& shapes, const Scene& scene, const Camera& camera, const PictureWish& wish);

/// The time, and in the temperature view a legend: what draw() adds to any renderer's picture.
void annotate(Image& image, double time, const PictureWish& wish);

/// As output.picture says.
PictureWish picture_wish(const Scene& scene, double cold, double hot);
TraceSettings trace_settings(const Scene& scene, const Camera& camera, const PictureWish& wish);

/// Ends of the ramp: of what `shapes` shows, widened to what `cold` and `hot` say already.
void widen_range(const FrameShapes& shapes, double& cold, double& hot);

}  // namespace runner
