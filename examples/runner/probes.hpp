// SPDX-License-Identifier: Apache-2.0
// A scene's probes: the World samples them, probes.csv holds what they say.
#pragma once

#include <string>
#include <vector>

#include "meltsim/world.hpp"
#include "scene.hpp"

namespace runner {

/// Probes of a scene that are points of one probe of the World, because they ask for the same at the same times. Numbers
/// count from 0, in the order of the scene; groups are in the order in which the World has them.
using ProbeGroups = std::vector<std::vector<std::size_t>>;

/// Fails with the place in the scene where the World refuses one.
ProbeGroups add_probes(meltsim::World& world, const Scene& scene);

/// Later samples of the same probes behind earlier ones.
void append(std::vector<meltsim::ProbeSeries>& to, std::vector<meltsim::ProbeSeries> more);

/// Rows of probes.csv, in order of time, then of the scene's probes and their fields. `series` as the World gives them.
std::vector<std::string> probe_rows(const Scene& scene, const ProbeGroups& groups,
                                    const std::vector<meltsim::ProbeSeries>& series);

}  // namespace runner
