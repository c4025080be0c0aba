// SPDX-License-Identifier: Apache-2.0
// What liquid freezes onto, lattice sites beside what is left of bodies of its solid, and where none are left.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"
#include "scene.hpp"

namespace runner {

/// A warning for every liquid that could freeze, and has no body to freeze onto from the start.
std::vector<std::string> nothing_to_freeze_onto(const Scene& scene);
/// Names of the solids that freeze of which bodies were there at the start and nothing is left.
std::vector<std::string> melted_away(const Scene& scene, Built& built);
/// Of those solids the ones whose liquid something cools below the melting point: a warning each. `when`: "a trial", say.
std::vector<std::string> will_not_freeze(const Scene& scene, const std::vector<std::string>& gone,
                                         bool cold_enough, const std::string& when);
/// At the end of a run: a warning for every liquid that is colder than its melting point where nothing of its solid is left.
std::vector<std::string> left_supercooled(const Scene& scene, Built& built);

}  // namespace runner
