// SPDX-License-Identifier: Apache-2.0
// --scale and --quality: the same scene with coarser or finer particles.
#pragma once

#include "options.hpp"
#include "scene.hpp"

namespace runner {

/// draft: 0.8 x the resolution, 0.8 x the sound speed, Courant number at least 0.5. balanced: the scene as it is. accurate:
/// 1.4 x the resolution. --scale multiplies the resolution further. The spacing is then
/// moved by up to 6 % to fit between the domain's walls.
void apply_resolution(Scene& scene, double scale, Quality quality);

/// The same scene with this spacing; the support and the surface's cells keep their ratio to it.
void apply_spacing(Scene& scene, double spacing);

/// How wide a gap [spacings] is left beside the upper walls of the domain, over the axes across gravity.
double domain_misfit(const meltsim::WorldDesc& world, double spacing);

}  // namespace runner
