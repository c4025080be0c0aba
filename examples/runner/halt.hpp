// SPDX-License-Identifier: Apache-2.0
// What a World that halted says, and what to change then.
#pragma once

#include <string>

#include "meltsim/world.hpp"
#include "scene.hpp"

namespace runner {

/// Why it halted, without the library's count of sub-steps: whoever prints it has a time or a count of its own.
std::string halt_text(const std::string& reason);

/// Why a step was refused, with the body of the scene that it is about instead of the library's call.
std::string refusal_text(const Scene& scene, const std::string& message);

/// Fails where the library will refuse the scene's step, since it needs too many sub-steps: said before anything is written.
void refuse_long_dt(const Scene& scene, const meltsim::World& world);

/// What to change after it halted in a step of `dt` [s]. Of a World with particles `coarseness` times as large as those of the scene
/// the step to try is that of the scene.
std::string halt_advice(const Scene& scene, meltsim::World& world, const meltsim::StepResult& result,
                        double dt, double coarseness = 1);

}  // namespace runner
