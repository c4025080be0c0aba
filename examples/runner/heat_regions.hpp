// SPDX-License-Identifier: Apache-2.0
// What the sources of heat.regions release: that of the particles in them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "scene.hpp"

namespace runner {

/// A region with a source, at the start.
struct RegionPower {
  const SceneHeatRegion* region;
  std::uint64_t particles;  ///< in it
  double power;             ///< [W] that they get while it acts
};

std::vector<RegionPower> region_powers(const Scene& scene, Built& built);
/// A warning for every region whose particles take up another volume than its shape does, in matter that fills it.
std::vector<std::string> uneven_regions(const Scene& scene);

}  // namespace runner
