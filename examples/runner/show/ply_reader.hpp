// SPDX-License-Identifier: Apache-2.0
// Reads back the PLY files that runs write: particles and surfaces.
#pragma once

#include <string>

#include "show/shapes.hpp"

namespace runner {

/// Both fail with exit code 5 and the file's name when it is not one of ours, or cut short. `time` is that of
/// the frame.
std::vector<FrameParticle> read_particles_ply(const std::string& path, double& time);
/// Empty where the file holds the placeholder. Positions are made relative to `origin`. Of contents it knows the values, not
/// the species.
Mesh read_mesh_ply(const std::string& path, const meltsim::Vec3d& origin, double& time);

}  // namespace runner
