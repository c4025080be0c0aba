// SPDX-License-Identifier: Apache-2.0
// Bodies whose way is known beforehand, and whether the domain is large enough for it.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// Fails where a kinematic body, going straight on or turning on from where it is now, reaches through a wall before `end` [s]: the
/// library would refuse that step. Says it as a warning where the run may end sooner, as everything has melted, or the body is gone by
/// then. Warns of bodies that fall out through an open face, with nothing below to land on.
std::vector<std::string> check_paths(const Scene& scene, Built& built, double end);

}  // namespace runner
