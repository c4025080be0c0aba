// SPDX-License-Identifier: Apache-2.0
// What a run says: progress, warnings, run.json, and how it ended.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "csv.hpp"
#include "explicit_heat.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "freezing.hpp"
#include "halt.hpp"
#include "interrupt.hpp"
#include "library_error.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "run.hpp"
#include "run_json.hpp"

namespace runner {

namespace {

// Liquid squeezed above this ratio at the start has no room, or runs into something.
constexpr double squeezed = 1.2;

}  // namespace

void Run::warn_about(const meltsim::StepResult& result, std::uint64_t next_frame) {
  if (result.courant_exceeded)
    log_.warn("something moved further than 0.4 support radii in one sub-step; lower dt");
  if (result.heat_bound_exceeded) {
    const std::string cure = explicit_heat_cure(scene_, built_.world);
    log_.warn("heat was exchanged faster than " +
              (cure.empty() ? "its stage bound allows; raise heat.max_stages or lower dt"
                            : "an explicit step allows; " + cure));
  }
  if (result.viscous_bound_exceeded)
    log_.warn("momentum diffused faster than the stages of viscosity allow: liquid is crowded; lower dt");
  if (result.solute_bound_exceeded)
    log_.warn(
        "a species diffused faster than its sweeps allow: liquid is crowded, and contents may leave the "
        "range "
        "of those around; lower dt");
  if (result.modulus_unreachable)
    for (const std::string& warning : softer_than_asked(built_)) log_.warn(warning);
  if (result.body_stiffened)
    log_.warn(
        "a body is softer than liquid around it bears and was stiffened to E = density c^2/2 (run.json: "
        "stiffness); a "
        "lower sound_speed lets it be softer");
  if (result.cooled_to_zero) log_.warn("something was to be cooled below absolute zero and was held there");
  if (result.level_bared)
    log_.warn(
        "liquid below the level of a hydrostatic field has a free surface, so its weight is missing there: "
        "lower the field's center");
  if (result.emitter_exhausted)
    log_.warn(
        "an emitter brings less than its speed asks for: max_particles have come, of one that recycles are "
        "there, or the domain is closed and full");
  if (result.strayed > 0)
    log_.warn("liquid falls out of the scene and is removed (solver.stray; run.json counts it as strayed)");
  if (next_frame <= 1 && result.max_density_ratio > squeezed) {
    log_.warn(fmt::format(
        "liquid is squeezed to {:.3g} of its rest density in the first frame: it is fast, or between "
        "shapes that leave it no room",
        result.max_density_ratio));
  }
}

void Run::update_progress(double time) {
  const meltsim::StepResult& result = last_result_;
  const double waited = seconds_since(started_), simulated = time - start_time_;
  progress_.end = end();
  progress_.done = options_.steps ? static_cast<double>(state_.steps) / static_cast<double>(*options_.steps)
                                  : time / progress_.end;
  progress_.done = std::min(1.0, progress_.done);
  progress_.time = time;
  progress_.dt = dt_;
  progress_.steps = state_.steps;
  progress_.fluid = result.fluid;
  progress_.solid = result.solid;
  if (state_.meltable > 0) {
    progress_.melted = std::min(1.0, static_cast<double>(net_melted(result.melted, result.frozen)) /
                                         static_cast<double>(state_.meltable));
  }
  progress_.ms_per_step = last_ms_;
  // Ahead of the first frame: of the whole run so far.
  if (last_ms_ == 0) progress_.ms_per_step = 1e3 * waited / static_cast<double>(state_.steps - start_steps_);
  progress_.real_time_ratio = simulated / waited;
  const double before = options_.steps ? 0 : start_time_ / progress_.end;
  const double done = progress_.done - before;
  // Not known before there is a step to go by.
  progress_.eta = done > 0 ? waited * (1 - progress_.done) / done : std::numeric_limits<double>::infinity();
}

void Run::show_progress(double time) {
  update_progress(time);
  log_.progress(progress_);
}

void Run::write_run_json(const Json& final_block_json) {
  const Stopwatch watch(times_.writing);
  Json json = run_json(scene_, resolved_scene_, options_, built_, log_.warnings(), final_block_json);
  json["timings"].update(timings_json());
  const bool ended = final_block_json.is_object() && final_block_json.value("status", "") == "finished";
  if (trade_ != nullptr) json["trade"] = trade_->json(ended);
  else if (kept_trade_.is_object()) json["trade"] = kept_trade_;
  if (budget_ != nullptr) json["budget"] = budget_->json(state_.substeps, state_.owed);
  write_file(directory_.file("run.json"), json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

Json Run::final_block(Outcome outcome) const {
  const bool refused = outcome == Outcome::diverged && !step_error_.empty();
  const char* status[] = {"finished", "interrupted", "diverged"};
  Json json = stats_json(recorder_->last());
  json["steps"] = state_.steps;
  json["substeps"] = built_.world.steps();
  json["frames"] = state_.next_frame;
  json["wall_s"] = wall();
  json["strayed"] = last_result_.strayed;
  json["diverged"] = outcome == Outcome::diverged && !refused;
  json["status"] = refused ? "refused" : status[static_cast<std::size_t>(outcome)];
  if (state_.melted_at) json["melted_at_s"] = *state_.melted_at;
  return json;
}

std::string Run::resume_hint() const {
  std::string command =
      fmt::format("{} --out {} --resume", options_.resume_command, shell_quoted(directory_.path));
  if (!scene_.text.empty()) command += " < " + shell_quoted(directory_.file(stdin_scene));
  return command;
}

std::string Run::divergence_message() const {
  if (!step_error_.empty())  // what the library refuses it says with the cure
    return fmt::format("step {} (t={:.4g} s) was refused: {}; state saved to {}", state_.steps + 1,
                       state_.time, refusal_text(scene_, step_error_), directory_.file("checkpoint.bin"));
  return fmt::format("diverged at step {} (t={:.4g} s): {}; state saved to {}; {}", state_.steps + 1,
                     state_.time, halt_text(last_result_.halt_reason), directory_.file("checkpoint.bin"),
                     halt_advice(scene_, built_.world, last_result_, last_dt_));
}

Json Run::timings_json() const {
  Json wall;
  wall["start_up_s"] = times_.start_up;
  wall["stepping_s"] = times_.stepping;
  wall["reading_s"] = times_.reading;
  wall["surfaces_s"] = times_.surfaces;
  wall["writing_s"] = times_.writing;
  wall["pictures_s"] = times_.pictures;
  wall["all_s"] = seconds_since(program_start());
  wall["writer_busy_s"] = recorder_ ? recorder_->busy() : 0;
  return {{"wall", wall}};
}

bool Run::wants_still() const { return options_.still && !scene_.output.formats.empty(); }

/// After a divergence or an interrupt, that and how to go on must be said even where no picture can be made.
void Run::finish_pictures(Outcome outcome) {
  try {
    const Stopwatch watch(times_.pictures);
    // An interrupted run is to end soon, and its picture is made when it is resumed and done.
    recorder_->pictures(built_.world, state_, outcome != Outcome::interrupted);
  } catch (const Failure& failure) {
    if (outcome == Outcome::finished) throw;
    log_.warn(fmt::format("pictures: {}", failure.what()));
  }
}

void Run::warn_at_end(Outcome outcome) {
  if (options_.overwrite) {
    const std::size_t stale = stale_frames(directory_, state_.next_frame - 1, scene_.output.formats);
    if (stale > 0)
      log_.warn(fmt::format(
          "{} frame files of an earlier run, longer or of other formats, remain in {}/frames; delete them "
          "where they are not wanted",
          stale, directory_.path));
  }
  if (outcome == Outcome::finished && time_.until_melted && !state_.melted_at) {
    log_.warn(fmt::format("the end was reached with {} of the solid {}; raise time.end or {}",
                          percent_text(recorder_->last().melted_fraction),
                          built_.melts ? "melted" : "dissolved", pace_keys(built_)));
  }
  if (outcome == Outcome::finished)
    for (const std::string& warning : left_supercooled(scene_, built_)) log_.warn(warning);
}

int Run::report(Outcome outcome) {
  if (outcome != Outcome::finished) {
    if (outcome == Outcome::diverged) {
      state_.frame_dt = 0;
      state_.rest = state_.part = {};
      state_.limits.clear();
    }
    save_checkpoint();
  }
  {
    const Stopwatch watch(times_.writing);
    recorder_->finish();
  }
  if (state_.steps > start_steps_) {
    update_progress(state_.time);  // what the last steps came to was not known when they were enqueued
    log_.end_progress(progress_);
  }
  warn_at_end(outcome);
  const Json block = final_block(outcome);
  write_run_json(block);
  finish_pictures(outcome);
  for (const std::string& problem : recorder_->problems()) log_.warn("pictures: " + problem);
  write_run_json(block);
  if (outcome == Outcome::diverged) {
    log_.error(divergence_message());
    return static_cast<int>(step_error_.empty() ? ExitCode::diverged : exit_code(step_error_code_));
  }
  if (outcome == Outcome::interrupted) {
    log_.error(fmt::format("interrupted at t={:.4g} s; state saved to {}\nresume with: {}", state_.time,
                           directory_.file("checkpoint.bin"), resume_hint()),
               "interrupted");
    return 128 + interrupt_signal();
  }
  if (trade_ != nullptr) {
    for (const std::string& line : trade_->report()) log_.info(line);
    if (const std::string missed = trade_->broken_promise(); !missed.empty()) log_.warn(missed);
  }
  if (budget_ != nullptr) log_.info(budget_->report(state_.owed, state_.time + state_.owed));
  if (options_.page) log_.info("page, for any browser: " + directory_.file("index.html"));
  log_.info(fmt::format("done: {} s simulated in {} steps, {}; results in {}", csv_number(state_.time),
                        state_.steps, duration_text(wall()), directory_.path),
            {{"final", block}, {"out", directory_.path}});
  return static_cast<int>(ExitCode::ok);
}

}  // namespace runner
