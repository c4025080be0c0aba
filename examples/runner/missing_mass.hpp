// SPDX-License-Identifier: Apache-2.0
// Bodies and liquids whose particles hold less or more than their shapes do.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// A warning for each body and liquid of a scene at its start whose particles are more than an eighth off its shape's volume, with the
/// particles.spacing that fits all of them. Liquid that bodies displace counts as there. After three the rest is counted.
std::vector<std::string> missing_mass(const Scene& scene, Built& built);

}  // namespace runner
