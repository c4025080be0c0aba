// SPDX-License-Identifier: Apache-2.0
// Layers of bodies across which what lies on both sides reaches each other.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// A warning for each body that is one site thick, conducts heat worse than the bodies on both its sides, and so passes too much.
std::vector<std::string> thin_layers(const Scene& scene, Built& built);

}  // namespace runner
