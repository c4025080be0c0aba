// SPDX-License-Identifier: Apache-2.0
// One run: steps the World from frame to frame until the end, an interrupt or a divergence.
#pragma once

#include <chrono>
#include <string>

#include "log.hpp"
#include "recorder.hpp"
#include "stepper.hpp"

namespace runner {

enum class Outcome { finished, interrupted, diverged };

/// Seconds of waiting since then.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Run {
 public:
  Run(const Scene& scene, const RunOptions& options, Built& built, RunDirectory directory, Log& log);

  /// Returns the exit code of the program.
  int execute();

 private:
  using Clock = std::chrono::steady_clock;

  void resume();
  void begin();
  void resolve_dt();
  Outcome loop();
  void frame_done();
  void choose_frame_dt();
  Batch next_batch();
  bool take(const Batch& batch);  ///< false: diverged
  void warn_about_stiffness();
  void warn_about(const meltsim::StepResult& result);
  void check_melted();
  void show_progress(const meltsim::StepResult& result);
  bool at_end() const;
  double end() const;
  std::uint64_t planned_frames() const;
  double frame_start() const;
  double frame_end() const;
  double wall() const;  ///< [s] of all sessions
  void save_checkpoint();
  void write_run_json(const Json& final_block);
  Json final_block(Outcome outcome) const;
  std::string resume_hint() const;
  std::string divergence_message() const;
  void finish_pictures(Outcome outcome);
  int report(Outcome outcome);

  const Scene& scene_;
  const RunOptions& options_;
  Built& built_;
  RunDirectory directory_;
  Log& log_;
  RunState state_;
  std::optional<Recorder> recorder_;
  Json resolved_scene_;
  SceneTime time_;  ///< with dt as a value
  Progress progress_;
  meltsim::StepResult last_result_;
  std::string step_error_;  ///< why step() refused, when it did
  double last_dt_ = 0;
  bool resumed_amid_ = false;      ///< of a batch of steps
  std::uint64_t frame_steps_ = 0;  ///< steps since the last frame
  double stepping_s_ = 0;          ///< time they took
  double start_time_ = 0, wall_before_ = 0;
  Clock::time_point started_, last_checkpoint_;
};

}  // namespace runner
