// SPDX-License-Identifier: Apache-2.0
// A run whose frames have a budget of wall time: what is chosen for it, what each frame came to, and how it is repeated.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "log.hpp"
#include "meltsim/trade.hpp"
#include "node.hpp"
#include "scene_json.hpp"

namespace runner {

/// What a frame, and a sub-step of it, take [ms].
struct FrameCost {
  double frame_ms = 0, substep_ms = 0;
};

struct FitToBudget {
  meltsim::trade::Choice choice;
  FrameCost cost;  ///< as timed
};

/// What settings for a budget are judged by: the first observable whose error settings change; the first of all where none does.
const meltsim::trade::Known& first_that_changes(const meltsim::trade::Study& study);

/// The most exact settings of a front (from the coarsest on; costs rise) with which a frame is expected to leave a fifth of its budget
/// free, as costs differ between frames. What they take is timed, for laws may expect too little: cheaper ones are then taken,
/// until a frame fits, there is nothing cheaper, or five have been timed. `frames`: of the run that the front is of.
FitToBudget most_exact_within(double milliseconds, double frames,
                              const std::vector<meltsim::trade::Choice>& front,
                              const std::function<FrameCost(const meltsim::trade::Knobs&)>& time);

class FrameBudget {
 public:
  /// A run under a budget of `milliseconds` a frame.
  explicit FrameBudget(double milliseconds) : milliseconds_(milliseconds) {}
  /// Takes what another run took: run.json in its directory. Fails where that is of no run under a budget.
  static FrameBudget repeating(const std::string& directory);

  /// Settings for the budget: those of the scene where they fit, else the most exact ones that are expected to. Says what it
  /// chose and expects.
  void choose(Scene& scene, const RunOptions& options, Log& log);
  /// The settings that were chosen for the run that is resumed or repeated; null: the scene's own.
  const Json& settings() const { return settings_; }
  void set_settings(const Json& settings) { settings_ = settings; }
  /// Of a run that repeats another one: its frames are as long as those, and it ends with them at the latest.
  void set_times(SceneTime& time, const RunOptions& options) const;

  struct Taken {
    double simulated = 0, owed = 0;  ///< [s]
    meltsim::Status status;
  };
  /// One frame, number `frame` from 1 on: `span` seconds in steps of `dt`, as far as its budget goes.
  Taken take(meltsim::World& world, std::uint64_t frame, double span, double dt);
  /// Frames after the first one that the run has, where its end asks for `planned`.
  std::uint64_t frames(std::uint64_t planned) const;

  /// What was delivered, in words. `owed`: [s] not simulated; `end`: [s] asked for.
  std::string report(double owed, double end) const;
  Json json(const std::vector<std::uint64_t>& substeps, double owed) const;

 private:
  double milliseconds_ = 0;
  bool repeats_ = false;
  std::vector<std::uint64_t> substeps_;  ///< of the run that is repeated
  double fps_ = 0, end_ = 0;             ///< likewise; the end [s] that it was started with
  Json settings_;
  double expected_ms_ = 0, expected_share_ = 1;
  std::vector<double> wall_ms_;  ///< per frame of this session
};

}  // namespace runner
