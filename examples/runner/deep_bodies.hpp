// SPDX-License-Identifier: Apache-2.0
// Bodies whose motion pressure holds back.
#pragma once

#include <string>
#include <vector>

#include "scene.hpp"

namespace runner {

/// A warning for each body that can move, is nearly as dense as the liquid that it lies in and deep below its surface, with the force
/// field that cures it. What can be said before the first step: from the shapes of the scene.
std::vector<std::string> deep_bodies(const Scene& scene);

}  // namespace runner
