// SPDX-License-Identifier: Apache-2.0
// A frame as text of Universal Scene Description (.usda): particles as points, surfaces as meshes, with temperature.
#pragma once

#include <string>

#include "meltsim/reading.hpp"
#include "show/shapes.hpp"

namespace runner {

/// One stage "meltsim": Points "particles" (ids, velocities, widths, primvars temperature, liquid_fraction, body, material), Mesh
/// "liquid" and Mesh "solid" (normals, primvars temperature, liquid_fraction where it is known, body, material), in metres, world coordinates. body: from 0, -1 = liquid.
/// A surface of nothing is a mesh without points.
/// up: a unit vector; where it is neither y nor z, which USD knows, the stage is turned so that it is y.
std::string usd_text(const meltsim::ParticleFrame& particles, const FrameShapes& shapes, double spacing,
                     double time, const meltsim::Vec3d& up);

}  // namespace runner
