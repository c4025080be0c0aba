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

/// The same for a spacing that was chosen for an error: what nozzles give at most is as much liquid as before.
void apply_chosen_spacing(Scene& scene, double spacing);

/// What the particles of a shape take up [m^3]: of liquid from wall to wall as World::add_fluid fills it.
double volume_of_particles(const meltsim::WorldDesc& world, const meltsim::Shape& shape, bool liquid,
                           double spacing);

}  // namespace runner
