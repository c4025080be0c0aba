// SPDX-License-Identifier: Apache-2.0
// The one place where the runner asks the library for surfaces.
#pragma once

#include "build_world.hpp"
#include "show/shapes.hpp"

namespace runner {

/// What a World looks like now: surfaces of liquid and solids as output.surface says. Particles as balls
/// where a surface could not be made, which `problem` then explains.
FrameShapes world_shapes(meltsim::World& world, const Scene& scene, double time,
                         const meltsim::ParticleFrame& particles, std::string& problem);

/// What pictures show of a frame: bodies that are visible, and one sheet where liquid touches them, since light cannot tell two apart.
FrameShapes picture_shapes(FrameShapes shapes, const Scene& scene);

}  // namespace runner
