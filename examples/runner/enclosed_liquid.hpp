// SPDX-License-Identifier: Apache-2.0
// Liquid in the cavities of bodies that it was put around.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// A warning for each liquid that lies around a hollow body and in it as well, since its shape covers both.
std::vector<std::string> enclosed_liquid(const Scene& scene, Built& built);

}  // namespace runner
