// SPDX-License-Identifier: Apache-2.0
// The rows of stats.csv, probes.csv and bodies.csv.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "meltsim/world.hpp"
#include "scene.hpp"

namespace runner {

extern const std::string probes_header;

/// One row of stats.csv.
struct StatsRow {
  std::uint64_t step = 0;
  double time = 0, dt = 0;  ///< [s]
  meltsim::Totals totals;
  double melted_fraction = 0;
  double ms_per_step = 0;
  double courant = 0;  ///< of the last sub-step
  std::array<double, meltsim::most_species>
      solute{},                         ///< of every species, in order of run.json's materials [kg]
      dissolved{};                      ///< of it what is dissolved [kg]
  double solution = 0;                  ///< heat that dissolving has taken up [J]
  std::uint64_t left = 0, entered = 0;  ///< particles so far: through open faces; below a level beyond one
};

std::string stats_header();
std::string bodies_header();
std::string stats_line(const StatsRow& row);
Json stats_json(const StatsRow& row);  ///< column -> value

std::string bodies_line(const meltsim::PieceInfo& piece, double time);

}  // namespace runner
