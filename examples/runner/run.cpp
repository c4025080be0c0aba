// SPDX-License-Identifier: Apache-2.0
#include "run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "expect.hpp"
#include "files.hpp"
#include "interrupt.hpp"
#include "scene_json.hpp"

namespace runner {

namespace {

// A machine that dies costs at most this much work.
constexpr double checkpoint_every_s = 60;
// Of the length of a step: what is as close to a whole number of steps is one.
constexpr double slack = 1e-9;

}  // namespace

Run::Run(const Scene& scene, const RunOptions& options, Built& built, RunDirectory directory, Log& log)
    : scene_(scene),
      options_(options),
      built_(built),
      directory_(std::move(directory)),
      log_(log),
      time_(scene.time),
      started_(Clock::now()),
      last_checkpoint_(Clock::now()) {}

int Run::execute() {
  watch_interrupts();
  built_.world.scheduler().enable_timings(true);
  resolve_dt();
  if (options_.resume) resume();
  else begin();
  start_time_ = state_.time;
  return report(loop());
}

void Run::resolve_dt() {
  Scene resolved = scene_;
  if (!time_.dt && !time_.adaptive) {
    time_.dt = automatic_dt(built_.world.stable_dt(), 1 / time_.fps);
    resolved.time.dt = time_.dt;
  }
  resolved_scene_ = scene_json(resolved, built_.world.resolved());
  if (!time_.dt || time_.adaptive) return;
  const double frame = 1 / time_.fps, dt = fixed_frame_dt(0, frame, *time_.dt);
  if (std::abs(dt - *time_.dt) > slack * *time_.dt) {
    log_.warn(fmt::format(
        "dt {:g} s does not divide the frame interval {:g} s; using {:.6g} s, {:.0f} steps per frame",
        *time_.dt, frame, dt, frame / dt));
  }
}

void Run::begin() {
  recorder_.emplace(scene_, directory_, built_, planned_frames(), nullptr);
  state_.meltable = built_.meltable;
  write_run_json({});
  recorder_->probes(built_.world, -1, state_.time);
  frame_done();
}

void Run::resume() {
  Checkpoint checkpoint = read_checkpoint(directory_.file("checkpoint.bin"));
  for (const char* part : {"domain", "particles", "heat", "materials", "fluids", "bodies", "emitters"}) {
    const Json before = checkpoint.scene.value(part, Json()), now = resolved_scene_.value(part, Json());
    if (before != now)
      log_.warn(fmt::format("{} differs from the scene the checkpoint was written for", part));
  }
  const Json time_before = checkpoint.scene.value("time", Json()),
             time_now = resolved_scene_.value("time", Json());
  if (time_before.value("fps", 0.0) != time_now.value("fps", 0.0)) {
    throw Failure(ExitCode::scene,
                  fmt::format("--resume: the run was started with {} frames per second; frames are "
                              "numbered by it, so resume with --fps {}",
                              time_before.value("fps", 0.0), time_before.value("fps", 0.0)));
  }
  if (time_before.value("dt", Json()) != time_now.value("dt", Json())) {
    checkpoint.state.frame_dt = 0;
    checkpoint.state.rest = {};
  }
  const meltsim::Status restored =
      built_.world.restore(checkpoint.snapshot.data(), checkpoint.snapshot.size());
  if (!restored) {
    throw Failure(ExitCode::io,
                  fmt::format("{}: {}", directory_.file("checkpoint.bin"), restored.error().message));
  }
  state_ = checkpoint.state;
  wall_before_ = state_.wall_s;
  resumed_amid_ = state_.rest.steps > 0;
  recorder_.emplace(scene_, directory_, built_, planned_frames(), &state_);
  log_.info(
      fmt::format("resuming at t={:.6g} s, step {}, frame {}", state_.time, state_.steps, state_.next_frame));
}

double Run::end() const {
  if (options_.steps) return std::numeric_limits<double>::infinity();
  const double planned = options_.frames ? static_cast<double>(*options_.frames) / time_.fps : time_.end;
  return state_.melted_at ? std::min(planned, *state_.melted_at + time_.tail) : planned;
}

double Run::frame_end() const {
  // The next frame of the regular grid that lies ahead, or the end when that comes first.
  return std::min(static_cast<double>(state_.next_frame) / time_.fps, end());
}

std::uint64_t Run::planned_frames() const {
  const double frames = end() * time_.fps;
  return std::isfinite(frames) ? static_cast<std::uint64_t>(std::min(frames, 1e12)) : 0;
}

double Run::frame_start() const { return static_cast<double>(state_.next_frame - 1) / time_.fps; }

bool Run::at_end() const {
  if (options_.steps && state_.steps >= *options_.steps) return true;
  return reached(state_.time, end());
}

double Run::wall() const { return wall_before_ + seconds_since(started_); }

Outcome Run::loop() {
  while (!at_end()) {
    if (interrupt_signal() != 0) return Outcome::interrupted;
    const double since = state_.time;
    const Batch batch = next_batch();
    if (!take(batch)) return Outcome::diverged;
    recorder_->probes(built_.world, since, state_.time);
    if (at_end() || reached(state_.time, frame_end())) frame_done();
    if (seconds_since(last_checkpoint_) > checkpoint_every_s) save_checkpoint();
  }
  return Outcome::finished;
}

void Run::choose_frame_dt() {
  const double left = frame_end() - state_.time;
  // A resumed frame goes on with the step it began with, to the last bit.
  const double steps = state_.frame_dt > 0 ? left / state_.frame_dt : 0;
  const bool fits =
      steps > 0.5 && std::abs(steps - std::round(steps)) < 1e-6 && state_.frame_dt <= *time_.dt * (1 + slack);
  if (fits) return;
  const bool whole = std::abs(state_.time - frame_start()) < slack * *time_.dt;
  state_.frame_dt = fixed_frame_dt(whole ? frame_start() : state_.time, frame_end(), *time_.dt);
}

Batch Run::next_batch() {
  if (state_.rest.steps > 0) return std::exchange(state_.rest, {});
  const double frame = frame_end(), target = std::min(frame, recorder_->next_probe(state_.time));
  Batch batch;
  if (time_.adaptive) {
    const double cap = time_.dt.value_or(std::numeric_limits<double>::infinity());
    // A restored World has not seen its speeds yet; the checkpoint has.
    // One that stopped amid a batch adds what it saw since.
    double stable = state_.stable_dt > 0 ? state_.stable_dt : built_.world.stable_dt();
    if (resumed_amid_) stable = std::min(stable, built_.world.stable_dt());
    resumed_amid_ = false;
    state_.stable_dt = 0;
    batch = adaptive_batch(state_.time, target, frame, std::min(cap, stable));
  } else {
    choose_frame_dt();
    batch = fixed_batch(state_.time, target, frame, state_.frame_dt);
  }
  if (options_.steps) {
    const std::uint64_t left = *options_.steps - state_.steps;
    if (left < static_cast<std::uint64_t>(batch.steps)) {
      batch.steps = static_cast<int>(left);
      batch.end = state_.time + batch.dt * batch.steps;
    }
  }
  return batch;
}

bool Run::take(const Batch& batch) {
  const Clock::time_point start = Clock::now();
  const std::uint64_t substeps_before = built_.world.steps();
  int taken = 0;
  while (taken < batch.steps && (taken == 0 || interrupt_signal() == 0)) {
    const meltsim::Status status = built_.world.step(batch.dt);
    ++taken;
    if (status) continue;
    if (status.error().code != meltsim::ErrorCode::halted) step_error_ = status.error().message;
    break;
  }
  const std::uint64_t substeps = built_.world.steps() - substeps_before;
  last_result_ = built_.world.synchronize();
  stepping_s_ += seconds_since(start);
  last_dt_ = batch.dt;
  if (last_result_.halted || !step_error_.empty()) {
    // Sub-steps that were good before the one that was not; a step counts when all of its own were.
    const double good = static_cast<double>(last_result_.steps - substeps_before);
    const double per_step = static_cast<double>(substeps) / taken;
    state_.time += batch.dt * good / std::max(per_step, 1.0);
    state_.steps += static_cast<std::uint64_t>(good / std::max(per_step, 1.0));
    return false;
  }
  if (taken < batch.steps) state_.rest = {batch.dt, batch.steps - taken, batch.end};
  state_.time = taken < batch.steps ? state_.time + batch.dt * taken : batch.end;
  state_.steps += static_cast<std::uint64_t>(taken);
  frame_steps_ += static_cast<std::uint64_t>(taken);
  warn_about(last_result_);
  show_progress(last_result_);
  return true;
}

void Run::frame_done() {
  const double ms = frame_steps_ > 0 ? 1e3 * stepping_s_ / static_cast<double>(frame_steps_) : 0;
  const double dt = frame_steps_ > 0 ? last_dt_ : time_.dt.value_or(built_.world.stable_dt());
  recorder_->frame(built_, state_, dt, ms);
  ++state_.next_frame;
  frame_steps_ = 0;
  stepping_s_ = 0;
  check_melted();
}

void Run::check_melted() {
  if (!time_.until_melted || state_.melted_at || recorder_->anything_left_to_melt()) return;
  state_.melted_at = state_.time;
  log_.info(fmt::format("everything has melted at t={:.4g} s", state_.time), {{"melted_at_s", state_.time}});
}

void Run::save_checkpoint() {
  state_.wall_s = wall();
  state_.stable_dt = time_.adaptive ? built_.world.stable_dt() : 0;
  recorder_->save();
  write_checkpoint(directory_.file("checkpoint.bin"),
                   {state_, resolved_scene_, expect(built_.world.snapshot())});
  state_.stable_dt = 0;
  last_checkpoint_ = Clock::now();
}

}  // namespace runner
