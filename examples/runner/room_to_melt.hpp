// SPDX-License-Identifier: Apache-2.0
// Melt that is lighter than its solid, in a domain with no room for it.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// A warning where what can melt takes up more room as liquid than a closed domain has free.
std::vector<std::string> room_to_melt(const Scene& scene, Built& built);

}  // namespace runner
