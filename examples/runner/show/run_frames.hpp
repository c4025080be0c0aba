// SPDX-License-Identifier: Apache-2.0
// A run on disk, as `render` and `plot` find it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "run_directory.hpp"
#include "scene.hpp"
#include "show/shapes.hpp"

namespace runner {

/// Domain, spacing, gravity, materials, camera and surface of the run in `directory`: what its run.json says, without
/// what was in it. Fails with exit code 5 when it is no run.
Scene run_scene_of(const RunDirectory& directory);

/// Numbers of the frames of which there are particles or surfaces as PLY, in order.
std::vector<std::uint64_t> frames_on_disk(const RunDirectory& directory);

/// A frame: surfaces where the run exported them, particles as balls for the rest.
FrameShapes frame_on_disk(const RunDirectory& directory, const Scene& scene, std::uint64_t index);

/// The coldest and the warmest of stats.csv; 0 and 1 when it says nothing.
std::pair<double, double> range_on_disk(const RunDirectory& directory);

}  // namespace runner
