// SPDX-License-Identifier: Apache-2.0
// What `check` says about the run to come: the scene is run with few, large particles, all its sources of heat with it.
#pragma once

#include <optional>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// How the solid melts, as the scene with coarser particles showed it.
struct Rehearsal {
  struct Sample {
    double time;    ///< [s]
    double melted;  ///< share of what could melt at the start
  };
  std::vector<Sample> melting;  ///< from 0 on
  double coarseness = 1;        ///< spacing over that of the scene; 1 = the scene itself
  double until = 0;             ///< [s] how far it came
  double substeps_per_s = 0;    ///< of the scene itself, at the speeds that were seen

  /// Estimated share at a time. Beyond `until` the last half of the curve goes on as a power of time.
  double melted_at(double time) const;
  /// Estimated time at which this share has melted; infinite where nothing melts.
  double time_of(double share) const;
};

/// Nothing where nothing can melt, or where the coarse scene cannot be built or diverges. Takes a few seconds at most.
std::optional<Rehearsal> rehearse(const Scene& scene, Built& built);

}  // namespace runner
