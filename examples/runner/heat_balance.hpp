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
  double needed = 0;           ///< [J] to warm the meltable solids to the melting point and melt them
  double melting_point = 0;    ///< [degrees Celsius]
  double melts = 0;            ///< share of the solid that melts in an insulated box
  double freezes = 0;          ///< share of the liquid that can freeze that has done so in an insulated box
  double end_temperature = 0;  ///< [degrees Celsius] of an insulated box
};

/// Nothing when nothing melts or the solids melt at different temperatures.
std::optional<HeatBalance> heat_balance(Built& built);
/// `others`: what else brings or takes heat, in words, or empty.
std::string heat_balance_text(const HeatBalance& balance, const std::string& others);
/// "walls, emitter \"jet\"": what the balance of an insulated box leaves out; empty where there is nothing.
std::string heat_sources_text(const Scene& scene);

}  // namespace runner
