// SPDX-License-Identifier: Apache-2.0
// Walls of bodies that liquid leaks through.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// A warning for each body whose curved or turned walls are one site thick where there is liquid.
std::vector<std::string> thin_walls(const Scene& scene, Built& built);

}  // namespace runner
