// SPDX-License-Identifier: Apache-2.0
// Calorimetry before the run: do the liquid and the bodies that do not melt hold enough heat to melt the others?
#pragma once

#include <optional>
#include <string>

#include "build_world.hpp"

namespace runner {

struct HeatBalance {
  bool liquid = false;         ///< there is liquid
  bool bodies = false;         ///< there are bodies that do not melt
  double available = 0;        ///< [J] both give while they cool to the melting point
  double cold = 0;             ///< [J] that the solids take up below the melting point, less `available`
  double freezing = 0;         ///< [J] that the liquid that can freeze gives off as it does
  double needed = 0;           ///< [J] to warm the meltable solids to the melting point and melt them
  double melting_point = 0;    ///< [degrees Celsius]
  double melts = 0;            ///< share of the solid that melts in an insulated box
  bool freezes_onto = false;   ///< there are bodies that liquid freezes onto
  bool over_range = false;     ///< melting has a range: all is liquid to the same share in the end
  double freezes = 0;          ///< share of the liquid that can freeze that has done so in an insulated box
  double end_temperature = 0;  ///< [degrees Celsius] of an insulated box
};

/// With what emitters bring that stop before long. Nothing when nothing melts or the solids melt at different temperatures.
std::optional<HeatBalance> heat_balance(const Scene& scene, Built& built);
/// `others`: what else brings or takes heat, in words, or empty.
std::string heat_balance_text(const HeatBalance& balance, const std::string& others);
/// "walls, emitter \"jet\"": what the balance of an insulated box leaves out; empty where there is nothing.
/// idle: names of regions that heat nothing.
std::string heat_sources_text(const Scene& scene, const std::vector<std::string>& idle = {});

/// [m^3] What an emitter that is no reservoir brings until the end of the scene.
double emitted_volume(const Scene& scene, const meltsim::EmitterDesc& desc);

}  // namespace runner
