// SPDX-License-Identifier: Apache-2.0
// The step that explicit exchange of heat (heat.model iwasaki) takes, and what to change where it is too long. The other models are
// bounded at any step: enthalpy by its stages, paper because each pair ends between its two temperatures.
#pragma once

#include <string>

#include "meltsim/world.hpp"
#include "scene.hpp"

namespace runner {

/// [s] The longest stable sub-step of explicit heat in the scene where its particles lie as they are laid out:
/// sum_j K V L dt <= 1 (meltsim/physics/heat.hpp). Infinite with another model. world: one of the scene, for its ratio of support and spacing.
double explicit_heat_dt(const Scene& scene, meltsim::World& world);

/// "heat.model iwasaki is stable in steps of ...: use time.dt ...": empty with another model.
std::string explicit_heat_cure(const Scene& scene, meltsim::World& world);

/// A warning where sub-steps of this length [s] are too long for explicit heat, else empty.
std::string explicit_heat_warning(const Scene& scene, meltsim::World& world, double substep);

}  // namespace runner
