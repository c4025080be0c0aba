// SPDX-License-Identifier: Apache-2.0
#include "run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "deep_bodies.hpp"
#include "enclosed_liquid.hpp"
#include "expect.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "freezing.hpp"
#include "heat_regions.hpp"
#include "interrupt.hpp"
#include "missing_mass.hpp"
#include "resumed_scene.hpp"
#include "room_to_melt.hpp"
#include "scene_json.hpp"
#include "thin_layers.hpp"
#include "thin_walls.hpp"

namespace runner {

namespace {

// A machine that dies costs at most this much work.
constexpr double checkpoint_every_s = 60;
// Adaptive steps follow the speeds of the last batch but one: the last one is still being computed when the next is
// enqueued. A number, not whatever is ready, so that a run repeats bit for bit.
constexpr std::size_t readings_behind = 2;
// Of the length of a step: what is as close to a whole number of steps is one.
constexpr double whole_step_slack = 1e-9;

}  // namespace

Run::Run(const Scene& scene, const RunOptions& options, Built& built, RunDirectory directory, Log& log,
         TradeWatch* trade, FrameBudget* budget)
    : scene_(scene),
      options_(options),
      built_(built),
      directory_(std::move(directory)),
      log_(log),
      trade_(trade),
      budget_(budget),
      time_(scene.time),
      started_(Clock::now()),
      last_checkpoint_(Clock::now()) {}

int Run::execute() {
  watch_interrupts();
  const InterruptSteps interrupt(built_.world);
  static_cast<void>(built_.world.scheduler().enable_timings(true));
  resolve_dt();
  last_result_ = built_.world.synchronize();
  times_.start_up = seconds_since(program_start());
  try {
    if (options_.resume) resume();
    else begin();
    start_time_ = state_.time;
    start_steps_ = state_.steps;
    return report(loop());
  } catch (const Failure& failure) {
    // A checkpoint that could not be taken up cannot be by the same command either.
    if (failure.code() != ExitCode::io || !(checkpointed_ || (options_.resume && recorder_))) throw;
    throw Failure(ExitCode::io, fmt::format("{}\nthe last checkpoint is whole; resume with: {}",
                                            failure.what(), resume_hint()));
  }
}

void Run::resolve_dt() {
  Scene resolved = scene_;
  if (budget_ != nullptr) {  // sub-steps are the library's, or shorter where the scene says so
    resolved_scene_ = scene_json(resolved, built_.world.resolved());
    return;
  }
  if (!time_.dt && !time_.adaptive) {
    time_.dt = automatic_dt(built_.world.stable_dt(), 1 / time_.fps);
    resolved.time.dt = time_.dt;
  }
  resolved_scene_ = scene_json(resolved, built_.world.resolved());
  if (!time_.dt || time_.adaptive) return;
  const double frame = 1 / time_.fps, dt = fixed_frame_dt(0, frame, *time_.dt);
  if (std::abs(dt - *time_.dt) > whole_step_slack * *time_.dt) {
    log_.warn(fmt::format(
        "dt {:g} s does not divide the frame interval {:g} s; using {:.6g} s, {:.0f} steps per frame",
        *time_.dt, frame, dt, frame / dt));
  }
}

/// Of scenes so large that looking at every particle would delay the start only `check` does.
void Run::warn_of_walls() {
  constexpr std::uint64_t most = 100000;
  const meltsim::StepResult now = built_.world.synchronize();
  if (now.fluid + now.solid > most) return;
  for (const std::string& warning : thin_walls(scene_, built_)) log_.warn(warning);
  for (const std::string& warning : thin_layers(scene_, built_)) log_.warn(warning);
  for (const std::string& warning : enclosed_liquid(scene_, built_)) log_.warn(warning);
}

void Run::begin() {
  for (const std::string& warning : missing_mass(scene_, built_)) log_.warn(warning);
  for (const std::string& warning : room_to_melt(scene_, built_)) log_.warn(warning);
  for (const std::string& warning : deep_bodies(scene_)) log_.warn(warning);
  warn_of_walls();
  for (const std::string& warning : nothing_to_freeze_onto(scene_)) log_.warn(warning);
  for (const std::string& warning : uneven_regions(scene_)) log_.warn(warning);
  recorder_.emplace(scene_, directory_, built_, frames_until(planned_end()), nullptr, wants_still(),
                    options_.page);
  state_.meltable = built_.meltable;
  write_run_json({});
  if (time_.adaptive && budget_ == nullptr) state_.limits.assign(readings_behind, built_.world.stable_dt());
  Flight start;
  start.ends_frame = true;
  start.batch.end = state_.time;
  request(start);
  flights_.push_back(start);
  settle_all();
}

void Run::resume() {
  Checkpoint checkpoint = read_checkpoint(directory_.file("checkpoint.bin"));
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
    checkpoint.state.rest = checkpoint.state.part = {};
    checkpoint.state.limits.clear();
  }
  const meltsim::Status restored =
      built_.world.restore(checkpoint.snapshot.data(), checkpoint.snapshot.size());
  if (!restored) {
    throw Failure(ExitCode::io,
                  fmt::format("{}: {}{}", directory_.file("checkpoint.bin"), restored.error().message,
                              changed_since(checkpoint.scene, resolved_scene_)));
  }
  for (const std::string& difference : take_over(scene_, built_, checkpoint.scene, resolved_scene_))
    log_.warn(difference);
  state_ = checkpoint.state;
  wall_before_ = state_.wall_s;
  if (time_.adaptive && state_.limits.empty() && budget_ == nullptr) {
    state_.rest = state_.part = {};
    state_.limits.assign(readings_behind, built_.world.stable_dt());
  }
  recorder_.emplace(scene_, directory_, built_, frames_until(planned_end()), &state_, wants_still(),
                    options_.page);
  count_restored();
  log_.info(
      fmt::format("resuming at t={:.6g} s, step {}, frame {}", state_.time, state_.steps, state_.next_frame));
}

/// What run.json says of a resumed run that has no frame ahead, or is stopped before it.
void Run::count_restored() {
  meltsim::ReadRequest steering;
  steering.totals = steering.pieces = true;
  const meltsim::ReadTicket ticket = expect(built_.world.request(steering));
  StatsRow row;
  row.step = state_.steps;
  row.time = state_.time;
  row.dt = time_.dt.value_or(built_.world.stable_dt());
  recorder_->count(built_, state_.next_frame, row, expect(built_.world.take(ticket)), state_.meltable);
}

double Run::planned_end() const {
  if (options_.steps) return std::numeric_limits<double>::infinity();
  return time_.end;
}

double Run::end() const {
  const double planned = planned_end();
  if (options_.steps || !state_.melted_at) return planned;
  return std::min(planned, *state_.melted_at + time_.tail);
}

double Run::frame_end() const {
  // The next frame of the regular grid that lies ahead, or the end when that comes first.
  return std::min(static_cast<double>(state_.next_frame) / time_.fps, end());
}

std::uint64_t Run::frames_until(double end) const {
  const double frames = std::ceil(end * time_.fps - whole_step_slack);
  return std::isfinite(frames) ? static_cast<std::uint64_t>(std::clamp(frames, 0.0, 1e12)) : 0;
}

double Run::frame_start() const { return static_cast<double>(state_.next_frame - 1) / time_.fps; }

bool Run::at_end() const {
  if (options_.steps && state_.steps >= *options_.steps) return true;
  if (budget_ != nullptr && state_.next_frame > budget_->frames(frames_until(planned_end()))) return true;
  return reached(state_.time, end());
}

double Run::wall() const { return wall_before_ + seconds_since(started_); }

Outcome Run::loop() {
  for (;;) {
    if (interrupt_signal() != 0) return settle_all() ? Outcome::interrupted : Outcome::diverged;
    if (at_end() || melting_must_settle()) {
      if (!settle_all()) return Outcome::diverged;
      if (at_end()) return Outcome::finished;
    }
    if (!make_room()) return Outcome::diverged;
    if (budget_ != nullptr) enqueue_within_budget();
    else enqueue(next_batch());
    if (!step_error_.empty()) {
      settle_all();
      return Outcome::diverged;
    }
    write_ready_frames();
    if (seconds_since(last_checkpoint_) > checkpoint_every_s) {
      if (!settle_all()) return Outcome::diverged;
      save_checkpoint();
    }
  }
}

/// Whether a frame on its way may tell that the run ends before the next batch does.
bool Run::melting_must_settle() const {
  if (!time_.until_melted || state_.melted_at) return false;
  for (const Flight& flight : flights_) {
    if (flight.ends_frame) return !reached(flight.batch.end + time_.tail, frame_end());
  }
  return false;
}

int Run::open_readings() const {
  int open = 0;
  for (const Flight& flight : flights_) open += flight.particles.value != 0 ? 2 : 1;
  for (const OpenFrame& frame : frames_) open += frame.particles.value != 0 ? 1 : 0;
  return open;
}

bool Run::make_room() {
  while (flights_.size() >= readings_behind ||
         (time_.adaptive && budget_ == nullptr && state_.limits.empty() && !flights_.empty())) {
    if (!settle()) return false;
  }
  while (open_readings() + 2 > meltsim::most_readings) {
    if (!frames_.empty()) write_frame();
    else if (!settle()) return false;
  }
  return true;
}

void Run::choose_frame_dt() {
  const double left = frame_end() - state_.time;
  // A resumed frame goes on with the step it began with, to the last bit.
  const double steps = state_.frame_dt > 0 ? left / state_.frame_dt : 0;
  const bool fits = steps > 0.5 && std::abs(steps - std::round(steps)) < 1e-6 &&
                    state_.frame_dt <= *time_.dt * (1 + whole_step_slack);
  if (fits) return;
  const bool whole = std::abs(state_.time - frame_start()) < whole_step_slack * *time_.dt;
  state_.frame_dt = fixed_frame_dt(whole ? frame_start() : state_.time, frame_end(), *time_.dt);
}

Batch Run::next_batch() {
  if (state_.rest.steps > 0) return std::exchange(state_.rest, {});
  const double frame = frame_end();
  Batch batch;
  if (time_.adaptive) {
    const double cap = time_.dt.value_or(std::numeric_limits<double>::infinity());
    batch = adaptive_batch(state_.time, frame, std::min(cap, state_.limits.front()));
    state_.limits.erase(state_.limits.begin());
  } else {
    choose_frame_dt();
    batch = fixed_batch(state_.time, frame, state_.frame_dt);
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

void Run::enqueue(const Batch& batch) {
  Flight flight;
  flight.batch = batch;
  flight.time = state_.time;
  flight.steps_before = state_.steps;
  flight.substeps_before = built_.world.steps();
  flight.next_frame = state_.next_frame;
  const double stepping_before = times_.stepping;
  dt_ = batch.dt;
  bool whole = true;
  while (whole && flight.steps < batch.steps && (flight.steps == 0 || interrupt_signal() == 0)) {
    whole = step(batch.dt);
    if (!whole) break;
    ++flight.steps;
    ++state_.steps;
    show_progress(flight.time + batch.dt * flight.steps);
  }
  flight.enqueuing = times_.stepping - stepping_before;
  flight.substeps = built_.world.steps() - flight.substeps_before;
  const int left = batch.steps - flight.steps;
  whole = left == 0;
  state_.time = batch.end - batch.dt * left;
  if (!whole) state_.rest = {batch.dt, left, batch.end};
  if (state_.part.steps > 0) state_.time += batch.dt - state_.part.dt * state_.part.steps;
  flight.ends_frame = whole && (at_end() || reached(state_.time, frame_end()));
  request(flight);
  flights_.push_back(flight);
  if (flight.ends_frame && (recorder_->decides_at_frames() || recorder_->wants_world(state_.next_frame - 1)))
    settle_all();
}

/// A frame: as many sub-steps as its budget allows, or as another run took. Each of the scene's own steps is one call.
void Run::enqueue_within_budget() {
  settle_all();  // nothing is under way by now, and how fast things are limits the steps
  Flight flight;
  flight.time = state_.time;
  flight.steps_before = state_.steps;
  flight.substeps_before = built_.world.steps();
  flight.next_frame = state_.next_frame;
  const double frame = 1 / time_.fps, before = built_.world.time(), stepping_before = times_.stepping;
  double longest = time_.dt.value_or(frame);
  if (time_.adaptive) longest = std::min(longest, built_.world.stable_dt(state_.rest_speed));
  // What was not simulated of the frames before is not made up for: the last one goes on from where it is due.
  const double span = std::min({frame, planned_end() - frame_start(), end() - state_.time});
  {
    const Stopwatch watch(times_.stepping);
    const FrameBudget::Taken taken =
        budget_->take(built_.world, state_.next_frame, span, fixed_frame_dt(0, span, longest));
    if (!taken.status && taken.status.error().code != meltsim::ErrorCode::interrupted &&
        taken.status.error().code != meltsim::ErrorCode::halted) {
      step_error_ = taken.status.error().message;
      step_error_code_ = taken.status.error().code;
    }
    state_.owed += taken.owed;
  }
  flight.enqueuing = times_.stepping - stepping_before;
  flight.substeps = built_.world.steps() - flight.substeps_before;
  flight.steps = 1;
  flight.batch = {built_.world.time() - before, 1, state_.time + (built_.world.time() - before)};
  if (flight.substeps > 0) dt_ = flight.batch.dt / static_cast<double>(flight.substeps);
  if (interrupt_signal() != 0 && flight.substeps == 0) return;
  state_.substeps.push_back(flight.substeps);
  state_.time = flight.batch.end;
  ++state_.steps;
  flight.ends_frame = true;
  show_progress(state_.time);
  request(flight);
  flights_.push_back(flight);
  settle_all();
}

bool Run::step(double dt) {
  const Stopwatch watch(times_.stepping);
  meltsim::World& world = built_.world;
  // What is left of a step that was interrupted is taken in its own sub-steps.
  Batch part = std::exchange(state_.part, {});
  const bool goes_on = part.steps > 0;
  if (!goes_on) part = {dt, 1, 0};
  for (; part.steps > 0; --part.steps) {
    const std::uint64_t before = world.steps();
    const double start = world.time();
    const meltsim::Status status = world.step(part.dt);
    if (status) continue;
    const auto done = static_cast<double>(world.steps() - before);
    if (status.error().code == meltsim::ErrorCode::interrupted) {
      if (goes_on) state_.part = part;
      if (goes_on || done == 0) return false;
      const double substeps = std::round(dt * done / (world.time() - start));
      state_.part = {dt / substeps, static_cast<int>(substeps - done), 0};
      return false;
    }
    // That it halted is what the readings on their way say, too, and they know where.
    if (status.error().code != meltsim::ErrorCode::halted) {
      step_error_ = status.error().message;
      step_error_code_ = status.error().code;
    }
    return false;
  }
  return true;
}

void Run::request(Flight& flight) {
  const Stopwatch watch(times_.reading);
  meltsim::ReadRequest steering;
  steering.totals = steering.pieces = flight.ends_frame;
  flight.ticket = expect(built_.world.request(steering));
  if (!flight.ends_frame) return;
  meltsim::ReadRequest all;
  all.particles =
      recorder_->wants_particles(state_.next_frame) || (trade_ != nullptr && trade_->wants_particles());
  all.probes = !scene_.probes.empty();
  if (all.particles || all.probes) {
    flight.particles = expect(built_.world.request(all));
  }
  ++state_.next_frame;
}

bool Run::settle_all() {
  while (!flights_.empty()) {
    if (!settle()) return false;
  }
  while (!frames_.empty()) write_frame();
  return true;
}

bool Run::settle() {
  const Flight flight = flights_.front();
  flights_.pop_front();
  meltsim::Reading reading;
  const double stepping_before = times_.stepping;
  {
    const Stopwatch watch(times_.stepping);
    reading = expect(built_.world.take(flight.ticket));
  }
  frame_stepping_ += flight.enqueuing + times_.stepping - stepping_before;
  if (reading.result.halted) {
    diverge(flight, reading.result);
    return false;
  }
  last_result_ = reading.result;
  last_dt_ = flight.steps > 0 ? flight.batch.dt : last_dt_;
  frame_steps_ += static_cast<std::uint64_t>(flight.steps);
  warn_about(last_result_, flight.next_frame);
  if (budget_ != nullptr) state_.rest_speed = last_result_.max_speed;
  if (time_.adaptive && budget_ == nullptr && flight.substeps > 0) {
    state_.rest_speed = std::max(state_.rest_speed, last_result_.max_speed);
    if (flight.steps == flight.batch.steps)
      state_.limits.push_back(built_.world.stable_dt(std::exchange(state_.rest_speed, 0)));
  }
  if (flight.ends_frame) settle_frame(flight, std::move(reading));
  return true;
}

void Run::settle_frame(const Flight& flight, meltsim::Reading reading) {
  StatsRow row;
  row.step = flight.steps_before + static_cast<std::uint64_t>(flight.steps);
  row.time = flight.batch.end;
  row.dt = frame_steps_ > 0 ? last_dt_ : time_.dt.value_or(built_.world.stable_dt());
  if (frame_steps_ > 0) row.ms_per_step = 1e3 * frame_stepping_ / static_cast<double>(frame_steps_);
  last_ms_ = row.ms_per_step;
  if (trade_ != nullptr) trade_->frame(row.time, reading.totals, reading.pieces);
  frame_steps_ = 0;
  frame_stepping_ = 0;
  frames_.push_back({recorder_->count(built_, flight.next_frame, row, std::move(reading), state_.meltable),
                     flight.particles});
  // The frame ahead is the same when fewer steps are on their way.
  recorder_->choose_still(flight.next_frame, std::max(state_.next_frame, flight.next_frame + 2));
  check_melted(flight.batch.end);
}

void Run::write_ready_frames() {
  while (!frames_.empty()) {
    const meltsim::ReadTicket particles = frames_.front().particles;
    if (particles.value != 0 && !expect(built_.world.ready(particles))) return;
    write_frame();
  }
}

void Run::write_frame() {
  OpenFrame open = std::move(frames_.front());
  frames_.pop_front();
  meltsim::Reading all;
  if (open.particles.value != 0) {
    const Stopwatch watch(times_.reading);
    all = expect(built_.world.take(open.particles));
  }
  if (trade_ != nullptr && (trade_->wants_particles() || trade_->wants_probes()))
    trade_->rest(all.particles, all.probes);
  std::shared_ptr<const FrameShapes> shapes;
  if (recorder_->wants_world(open.frame.index)) {
    const Stopwatch watch(times_.surfaces);
    shapes = recorder_->shapes(built_.world, all.particles, open.frame.index, open.frame.row.time);
  }
  const Stopwatch watch(times_.writing);
  recorder_->write(std::move(open.frame), std::move(all.particles), std::move(all.probes), std::move(shapes));
}

/// Goes back to the last good state, which may be amid a step that was split.
void Run::diverge(const Flight& flight, const meltsim::StepResult& result) {
  last_result_ = result;
  last_dt_ = flight.batch.dt;
  const double good = static_cast<double>(result.steps - std::min(result.steps, flight.substeps_before));
  const double per_step = static_cast<double>(flight.substeps) / std::max(flight.steps, 1);
  state_.time = flight.time + flight.batch.dt * good / std::max(per_step, 1.0);
  state_.steps = flight.steps_before + static_cast<std::uint64_t>(good / std::max(per_step, 1.0));
  state_.next_frame = flight.next_frame;
  std::vector<meltsim::ReadTicket> left{flight.particles};
  for (const Flight& later : flights_) {
    left.push_back(later.ticket);
    left.push_back(later.particles);
  }
  flights_.clear();
  for (const meltsim::ReadTicket ticket : left) {
    if (ticket.value == 0) continue;
    if (meltsim::Result<meltsim::Reading> reading = built_.world.take(ticket); reading)
      append(samples_left_, std::move(reading->probes));
  }
  while (!frames_.empty()) write_frame();
}

void Run::check_melted(double time) {
  if (!time_.until_melted || state_.melted_at || recorder_->anything_left_to_melt()) return;
  state_.melted_at = time;
  log_.info(fmt::format("everything has melted at t={:.4g} s", time), {{"melted_at_s", time}});
}

void Run::save_checkpoint() {
  const Stopwatch watch(times_.writing);
  state_.wall_s = wall();
  state_.still_share = recorder_->still_share();
  Recorder::Samples samples = std::exchange(samples_left_, {});
  append(samples, expect(built_.world.take_samples()));
  recorder_->save({state_, resolved_scene_, expect(built_.world.snapshot())}, std::move(samples));
  checkpointed_ = true;
  last_checkpoint_ = Clock::now();
}

}  // namespace runner
