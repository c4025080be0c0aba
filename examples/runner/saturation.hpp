// SPDX-License-Identifier: Apache-2.0
// How much of a species the liquid of a scene can hold, beside what there is of it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "scene.hpp"

namespace runner {

/// A species at the start, in a box that nothing comes into.
struct Saturation {
  std::string species, solvent;
  double solubility = 0;  ///< w_s at the temperature of the solvent [kg per kg of solution]
  double holds = 0;       ///< of the species when the liquid is saturated [kg]
  double dissolved = 0;   ///< in the liquid [kg]
  double crystals = 0;    ///< in bodies [kg]
  /// Share of the bodies that dissolves in the end, 0 to 1.
  double share() const;
};

/// Of every species that has bodies. Empty where liquid comes in or leaves.
std::vector<Saturation> saturations(const Scene& scene, Built& built);
std::string saturation_text(const Saturation& s);
/// Share of all that melts or dissolves that can go at all, if `melts` of what melts can. 1 where nothing dissolves.
double most_that_goes(const Scene& scene, Built& built, double melts);

}  // namespace runner
