// SPDX-License-Identifier: Apache-2.0
// The scene that runs: its World, its pace, and what it has to say. Knows nothing of windows.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "build_world.hpp"
#include "edits.hpp"
#include "options.hpp"
#include "scene.hpp"

namespace view {

/// How long the next steps are.
struct StepChoice {
  bool automatic = true;  ///< as long as the fastest motion allows, anew for every frame
  double dt = 0;          ///< [s], when not automatic
};

class Session {
 public:
  /// `base` is the scene before any change of resolution. Throws runner::Failure as `meltsim run` does.
  Session(runner::Scene base, runner::MachineOptions machine, double scale, runner::Quality quality);

  /// Steps until `seconds` of simulated time have passed or `budget` seconds on the clock have. `elapsed`:
  /// seconds on the clock since the last call, for ratio().
  void advance(double seconds, double budget, double elapsed);
  void single_step();

  /// Builds the scene with `edits`. `keep_state`: goes on from here, which works where only heat conduction
  /// changed. When it fails the old World goes on, and error() says why.
  void rebuild(const Edits& edits, bool keep_state);

  runner::Built& built() { return *built_; }
  meltsim::World& world() { return built_->world; }
  const runner::Scene& scene() const { return scene_; }
  const Edits& edits() const { return edits_; }
  StepChoice& step_choice() { return step_; }

  /// After this many builds; what was attached to an older World is gone.
  int generation() const { return generation_; }
  const meltsim::StepResult& result() const { return result_; }
  const std::optional<meltsim::Ledger>& ledger() const { return ledger_; }
  double time() const { return result_.time; }
  double last_dt() const { return last_dt_; }
  double ms_per_step() const { return ms_per_step_; }
  double melted_share() const;  ///< 0..1 of what can melt; 0 where nothing can
  /// Simulated over elapsed seconds of the last second that was not paused.
  double ratio() const { return ratio_; }
  bool stopped() const { return result_.halted; }
  const std::string& error() const { return error_; }  ///< empty: all is well
  std::string warning() const;                         ///< what makes the results doubtful; empty: nothing
  const std::string& note() const { return note_; }    ///< what the last rebuild did

 private:
  using Clock = std::chrono::steady_clock;
  double choose_dt();
  bool step(double dt, int count);
  void wait();
  void read_back();
  void count_pace(double simulated, double elapsed);

  runner::Scene base_, scene_;
  runner::MachineOptions machine_;
  runner::Quality quality_;
  Edits edits_;
  std::optional<runner::Built> built_;
  StepChoice step_;
  meltsim::StepResult result_;
  std::optional<meltsim::Ledger> ledger_;
  std::string error_, note_;
  double owed_ = 0;  ///< [s] of simulated time that whole steps did not cover yet
  double last_dt_ = 0, ms_per_step_ = 0, ratio_ = 0;
  double paced_simulated_ = 0, paced_elapsed_ = 0;
  double squeezed_ = 0;  ///< largest rho/rho0 of the first frame
  int generation_ = 0;
};

}  // namespace view
