// SPDX-License-Identifier: Apache-2.0
// One run: steps the World from frame to frame until the end, an interrupt or a divergence.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "frame_budget.hpp"
#include "log.hpp"
#include "recorder.hpp"
#include "stepper.hpp"
#include "trade_watch.hpp"
#include "wall_times.hpp"

namespace runner {

enum class Outcome { finished, interrupted, diverged };

/// Steps run ahead: while some are being computed, the next are enqueued, and what a frame reads is taken when those
/// after it are on their way. A Flight is a batch of steps that was enqueued and whose reading was not taken yet.
struct Flight {
  Batch batch;
  int steps = 0;  ///< of the batch; fewer where an interrupt cut it short
  // When it was enqueued:
  double time = 0;  ///< [s] at its start
  std::uint64_t steps_before = 0, substeps_before = 0;
  std::uint64_t substeps = 0;  ///< of its own
  double enqueuing = 0;        ///< wall time that it took [s]; on the CPU the steps themselves
  std::uint64_t next_frame = 0;
  bool ends_frame = false;
  meltsim::ReadTicket ticket;     ///< what steers the run; of a frame with totals and pieces
  meltsim::ReadTicket particles;  ///< of a frame; null: it needs none
};

/// A frame whose steps are done and whose particles are on their way, if it needs them.
struct OpenFrame {
  Frame frame;
  meltsim::ReadTicket particles;
};

class Run {
 public:
  /// `trade`: of a run whose settings were chosen for an error; null: none was asked for.
  /// `budget`: of a run whose frames have a budget of wall time; null: frames take as long as they take.
  Run(const Scene& scene, const RunOptions& options, Built& built, RunDirectory directory, Log& log,
      TradeWatch* trade = nullptr, FrameBudget* budget = nullptr);

  /// Returns the exit code of the program.
  int execute();
  /// Before execute(), of a run that is resumed: the block "trade" of its run.json, which goes on.
  void keep_trade(Json trade) { kept_trade_ = std::move(trade); }

 private:
  void resume();
  void count_restored();
  void warn_of_walls();
  void begin();
  void resolve_dt();
  Outcome loop();
  bool melting_must_settle() const;
  bool make_room();  ///< false: diverged
  int open_readings() const;
  void choose_frame_dt();
  Batch next_batch();
  void enqueue(const Batch& batch);
  void enqueue_within_budget();
  bool step(double dt);  ///< false: not a whole one
  void request(Flight& flight);
  bool settle();      ///< the oldest flight; false: diverged
  bool settle_all();  ///< false: diverged
  void settle_frame(const Flight& flight, meltsim::Reading reading);
  void write_frame();  ///< the oldest open one
  void write_ready_frames();
  void diverge(const Flight& flight, const meltsim::StepResult& result);
  void warn_about(const meltsim::StepResult& result, std::uint64_t next_frame);
  void warn_at_end(Outcome outcome);
  void check_melted(double time);
  void update_progress(double time);  ///< [s] simulated so far
  void show_progress(double time);    ///< likewise
  bool at_end() const;
  double planned_end() const;                    ///< [s] of a run in which not everything melts before
  double end() const;                            ///< [s] as far as it is known
  std::uint64_t frames_until(double end) const;  ///< the last one may be shorter; 0: not known
  double frame_start() const;
  double frame_end() const;
  double wall() const;  ///< [s] of all sessions
  void save_checkpoint();
  void write_run_json(const Json& final_block);
  Json final_block(Outcome outcome) const;
  Json timings_json() const;
  std::string resume_hint() const;
  std::string divergence_message() const;
  void finish_pictures(Outcome outcome);
  bool wants_still() const;
  int report(Outcome outcome);

  const Scene& scene_;
  const RunOptions& options_;
  Built& built_;
  RunDirectory directory_;
  Log& log_;
  TradeWatch* trade_;
  FrameBudget* budget_;
  RunState state_;  ///< with the steps that are enqueued
  std::optional<Recorder> recorder_;
  Json resolved_scene_;
  Json kept_trade_;  ///< of run.json, of the run that is resumed: which settings were chosen for it
  SceneTime time_;   ///< with dt as a value
  Progress progress_;
  std::deque<Flight> flights_;
  std::deque<OpenFrame> frames_;
  Recorder::Samples samples_left_;  ///< of readings that belong to no frame
  meltsim::StepResult last_result_;
  std::string step_error_;  ///< why step() refused, when it did
  meltsim::ErrorCode step_error_code_{};
  double last_dt_ = 0;  ///< of the steps that were settled last
  double dt_ = 0;       ///< of those that were enqueued last
  std::uint64_t start_steps_ = 0;
  std::uint64_t frame_steps_ = 0;  ///< steps settled since the last frame
  double frame_stepping_ = 0;      ///< wall time of these steps [s]
  double last_ms_ = 0;             ///< per step, in the last frame
  double start_time_ = 0, wall_before_ = 0;
  bool checkpointed_ = false;
  WallTimes times_;
  Clock::time_point started_, last_checkpoint_;
};

}  // namespace runner
