// SPDX-License-Identifier: Apache-2.0
// --scale and --quality: the same scene with coarser or finer particles.
#pragma once

#include "options.hpp"
#include "scene.hpp"

namespace runner {

/// draft: support 2 spacings, 0.75 x the resolution. balanced: the scene as it is. accurate: 1.25 x the
/// resolution, Courant number at most 0.25. --scale multiplies the resolution further. The spacing is then
/// moved by up to 6 % to fit between the domain's walls.
void apply_resolution(Scene& scene, double scale, Quality quality);

}  // namespace runner
