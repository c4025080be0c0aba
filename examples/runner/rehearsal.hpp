// SPDX-License-Identifier: Apache-2.0
// What `check` says about the run to come: the scene is run with few, large particles, all its sources of heat with it.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

// Half a percent of the solid is next to nothing.
constexpr double least_share = 0.005;

/// How the solid melts, as the scene with coarser particles showed it.
struct Rehearsal {
  struct Sample {
    double time;    ///< [s]
    double melted;  ///< share of what could melt at the start, in whole particles
    double taken;   ///< share of the latent heat that melts it; melted, where that is not known
  };
  std::vector<Sample> melting;  ///< from 0 on
  double frozen = 0;            ///< of what could freeze the share that had at the end, less what had melted
  bool changes =
      false;  ///< heat of the scene depends on the time: nothing is said of what comes after its end
  double coarseness = 1;          ///< spacing over that of the scene; 1 = the scene itself
  double until = 0;               ///< [s] how far it came
  double substeps_per_s = 0;      ///< of the scene itself, at the speeds that were seen
  std::string untried;            ///< why nothing was tried; empty: it was
  std::vector<std::string> gone;  ///< solids that freeze, of which nothing was left at the end
  std::string stopped;            ///< how the trial ended at `until`, and what to change; empty: as it should

  /// Estimated share at a time. Beyond `until` the last half of the curve of `taken` goes on as a power of time.
  double melted_at(double time) const;
  /// Of a time up to `until`, and the most of all times.
  double taken_at(double time) const;
  double most_taken() const;
  /// Estimated time at which this share has melted; infinite where nothing melts.
  double time_of(double share) const;
  /// " with particles 2 times as large", or nothing where it was tried with the scene's own.
  std::string with() const;
};

/// What `check` says of it: how much melts until `end` [s], how far that was tried, and what of it is extrapolated.
/// most: share of the solid that can melt at all.
std::string melting_text(const Rehearsal& seen, const Built& built, double end, double most);

/// Likewise of a scene in which nothing melts and liquid freezes.
std::string freezing_text(const Rehearsal& seen, const Built& built, double end);

/// Tries a scene in which something can melt. Takes a few seconds at most.
Rehearsal rehearse(const Scene& scene, Built& built);

}  // namespace runner
