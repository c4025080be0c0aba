// SPDX-License-Identifier: Apache-2.0
#include "session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "failure.hpp"
#include "recorder.hpp"
#include "stepper.hpp"

namespace view {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Waiting costs a little on a GPU, so steps are enqueued together, but never more than the budget may hold.
constexpr int most_together = 8;

// As `meltsim run` has it.
constexpr double squeezed_too_much = 1.2;

}  // namespace

Session::Session(runner::Scene base, runner::MachineOptions machine, double scale, runner::Quality quality)
    : base_(std::move(base)), machine_(machine), quality_(quality), edits_(edits_of(base_, scale)) {
  scene_ = edited(base_, edits_, quality_);
  built_.emplace(runner::build_world(scene_, machine_));
  step_.automatic = scene_.time.adaptive || !scene_.time.dt;
  step_.dt = scene_.time.dt.value_or(runner::automatic_dt(built_->world.stable_dt(), 1 / scene_.time.fps));
  result_ = built_->world.synchronize();
  read_back();
}

void Session::rebuild(const Edits& edits, bool keep_state) {
  error_.clear();
  note_.clear();
  try {
    runner::Scene scene = edited(base_, edits, quality_);
    runner::Built fresh = runner::build_world(scene, machine_);
    note_ = "started again";
    if (keep_state) {
      const auto state = built_->world.snapshot();
      const meltsim::Status kept =
          state ? fresh.world.restore(state->data(), state->size()) : meltsim::Status(state.error());
      note_ = kept ? fmt::format("goes on from {:.3f} s", built_->world.time())
                   : "started again: " + kept.error().message;
    }
    scene_ = std::move(scene);
    built_.emplace(std::move(fresh));
    edits_ = edits;
    squeezed_ = owed_ = ratio_ = paced_simulated_ = paced_elapsed_ = 0;
    ++generation_;
    result_ = built_->world.synchronize();
    read_back();
  } catch (const runner::Failure& failure) {
    error_ = failure.what();
  } catch (const std::bad_alloc&) {
    error_ = "memory: the machine has no more; a smaller quality fits";
  }
}

double Session::choose_dt() {
  if (!step_.automatic) return step_.dt;
  const double stable = built_->world.stable_dt(), cap = scene_.time.dt.value_or(1 / scene_.time.fps);
  return std::min(scene_.time.adaptive ? cap : 1 / scene_.time.fps, stable);
}

void Session::advance(double seconds, double budget, double elapsed) {
  if (stopped()) return;
  const Clock::time_point start = Clock::now();
  const double before = time();
  result_.courant_exceeded = result_.heat_bound_exceeded = result_.viscous_bound_exceeded = false;
  owed_ += seconds;
  while (true) {
    const double dt = choose_dt(), left = budget - seconds_since(start);
    const double fit = ms_per_step_ > 0 ? 1e3 * left / ms_per_step_ : 1;
    const double due = std::floor(owed_ / dt + 1e-6);
    if (due < 1 || left <= 0) break;
    const double count = std::min({due, std::max(fit, 1.0), static_cast<double>(most_together)});
    if (!step(dt, static_cast<int>(count))) break;
    owed_ -= dt * std::floor(count);
  }
  // What could not be done in time is dropped: slower than real time, but never ever further behind.
  owed_ = std::min(owed_, choose_dt());
  read_back();
  count_pace(time() - before, std::max(elapsed, seconds_since(start)));
}

void Session::single_step() {
  if (stopped()) return;
  step(choose_dt(), 1);
  read_back();
}

bool Session::step(double dt, int count) {
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < count; ++i) {
    const meltsim::Status status = built_->world.step(dt);
    if (status) continue;
    if (status.error().code != meltsim::ErrorCode::halted) error_ = status.error().message;
    wait();
    return false;
  }
  wait();
  last_dt_ = dt;
  const double ms = 1e3 * seconds_since(start) / count;
  ms_per_step_ = ms_per_step_ > 0 ? 0.8 * ms_per_step_ + 0.2 * ms : ms;
  error_.clear();
  return !result_.halted;
}

/// Flags are those of the steps since the World was last asked; what is shown is all of a frame.
void Session::wait() {
  const meltsim::StepResult before = result_;
  result_ = built_->world.synchronize();
  result_.courant_exceeded |= before.courant_exceeded;
  result_.heat_bound_exceeded |= before.heat_bound_exceeded;
  result_.viscous_bound_exceeded |= before.viscous_bound_exceeded;
  if (result_.time <= 1 / scene_.time.fps) squeezed_ = std::max(squeezed_, result_.max_density_ratio);
}

void Session::read_back() {
  if (result_.halted) error_ = "stopped: " + result_.halt_reason;
  auto ledger = built_->world.ledger();
  if (ledger) ledger_ = *ledger;
  else ledger_.reset();
}

std::string Session::warning() const {
  std::string text;
  const auto say = [&text](bool so, const std::string& what) {
    if (so) text += (text.empty() ? "" : "\n") + what;
  };
  say(squeezed_ > squeezed_too_much, fmt::format("liquid was squeezed to {:.3g} of its rest density at the "
                                                 "start: it is fast, or between shapes that leave it no "
                                                 "room; try another velocity or quality",
                                                 squeezed_));
  say(result_.courant_exceeded, "something moves too far in one sub-step: take a shorter time step");
  say(result_.heat_bound_exceeded, "heat is faster than its sub-step: take a shorter time step");
  say(result_.viscous_bound_exceeded, "liquid is too crowded for its viscosity: take a shorter time step");
  say(result_.emitter_exhausted,
      "an emitter brings less than it should: at its max_particles, or the domain is full");
  return text;
}

double Session::melted_share() const {
  if (!built_ || built_->meltable == 0) return 0;
  const double melted = static_cast<double>(runner::net_melted(result_.melted, result_.frozen));
  return std::min(1.0, melted / static_cast<double>(built_->meltable));
}

void Session::count_pace(double simulated, double elapsed) {
  paced_simulated_ += simulated;
  paced_elapsed_ += elapsed;
  if (paced_elapsed_ < 1 && ratio_ > 0) return;
  if (paced_elapsed_ > 0) ratio_ = paced_simulated_ / paced_elapsed_;
  if (paced_elapsed_ >= 1) paced_simulated_ = paced_elapsed_ = 0;
}

}  // namespace view
