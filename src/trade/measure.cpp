// SPDX-License-Identifier: Apache-2.0
// One probe: a World stepped from sample to sample.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "meltsim/physics/diffusion.hpp"
#include "meltsim/trade.hpp"
#include "trade/check.hpp"
#include "trade/measure.hpp"
#include "world/guarded.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Number of steps that are enqueued before their speeds are read; fixed, so that a probe repeats bit for bit.
constexpr double steps_per_look = 8;
// Share of a step: times this close to a whole number of steps count as one.
constexpr double slack = 1e-6;

Error invalid(const std::string& message) { return {ErrorCode::invalid_argument, message}; }

class Probe {
 public:
  Probe(const Problem& problem, const Knobs& knobs, World world, double wall_limit)
      : problem_(problem), world_(std::move(world)), wall_limit_(wall_limit) {
    result_.knobs = knobs;
    step_limit_ = std::min(problem.longest_step * knobs[Knob::step], problem.longest_sample_step);
  }

  Result<Measurement> run() && {
    const Clock::time_point start = Clock::now();
    if (const Status ready = world_.prepare(); !ready) return ready.error();
    note(world_.synchronize());
    result_.bytes = world_.plan().bytes;
    if (const Status seen = sample(0); !seen) return seen.error();
    const int samples = std::max(1, problem_.samples);
    for (int i = 1; i <= samples && result_.complete; ++i) {
      const double end = problem_.end * i / samples;
      if (!finished_)
        if (const Status gone_on = advance(end, start); !gone_on) return gone_on.error();
      if (!result_.complete) break;
      if (const Status seen = sample(end); !seen) return seen.error();
    }
    result_.wall_s = since(start);
    result_.substeps = world_.steps();
    for (std::size_t k = 0; k < problem_.observables.size(); ++k)
      result_.values.push_back(reduce(problem_.observables[k], times_, series_[k]));
    return std::move(result_);
  }

 private:
  void note(const StepResult& now) {
    particles_ = static_cast<double>(now.fluid + now.solid);
    result_.particles = std::max(result_.particles, now.fluid + now.solid);
    speed_ = now.max_speed;
  }

  /// A run that comes to nothing is a result, too.
  Status fail(const std::string& why) {
    result_.complete = false;
    result_.problem = why;
    return {};
  }

  Status advance(double end, Clock::time_point start) {
    while (time_ < end) {
      const double limit = std::min(world_.stable_dt(speed_), step_limit_);
      const double all = std::isfinite(limit) ? std::max(1.0, std::ceil((end - time_) / limit - slack)) : 1;
      const double dt = (end - time_) / all, count = std::min(all, steps_per_look);
      const std::uint64_t before = world_.steps();
      for (int i = 0; i < static_cast<int>(count); ++i)
        if (const Status status = world_.step(dt); !status && status.error().code != ErrorCode::halted)
          return status.error().code == ErrorCode::interrupted ? status : fail(status.error().message);
      const StepResult now = world_.synchronize();
      if (now.halted) return fail(now.halt_reason);
      note(now);
      result_.work += static_cast<double>(world_.steps() - before) *
                      work_of_substep(world_, particles_, dt, problem_.diffusivity);
      time_ = count == all ? end : time_ + count * dt;
      if (since(start) > wall_limit_) return fail(too_long);
    }
    return {};
  }

  /// Present values of the observables; values that can no longer change are repeated.
  Status sample(double time) {
    if (!finished_) {
      values_.clear();
      if (const Status seen = problem_.observe(world_, values_); !seen) return seen;
      std::size_t expected = 0;
      for (const Observable& o : problem_.observables)
        expected += static_cast<std::size_t>(std::max(1, o.components));
      if (values_.size() != expected)
        return invalid("observe: expected " + std::to_string(expected) +
                       " values, one per component of an observable, got " + std::to_string(values_.size()));
      finished_ = time > 0 && problem_.finished && problem_.finished(values_);
    }
    times_.push_back(time);
    series_.resize(problem_.observables.size());
    std::size_t at = 0;
    for (std::size_t k = 0; k < series_.size(); ++k)
      for (int c = 0; c < std::max(1, problem_.observables[k].components); ++c)
        series_[k].push_back(values_[at++]);
    return {};
  }

  const Problem& problem_;
  World world_;
  double wall_limit_, step_limit_, time_ = 0, particles_ = 0, speed_ = 0;
  bool finished_ = false;
  Measurement result_;
  std::vector<double> times_, values_;
  std::vector<std::vector<double>> series_;
};

}  // namespace

double work_of_substep(double particles, double support_over_spacing, double heat_sweeps, Backend backend) {
  // Particles that a GPU's launches, or the loops of a CPU, cost as much as.
  const double idle = backend == Backend::cuda ? 30000 : 100;
  return (particles + idle) * std::pow(support_over_spacing / 2.5, 3) * (1 + 0.35 * heat_sweeps);
}

double work_of_substep(World& world, double particles, double dt, double diffusivity) {
  const Resolved resolved = world.resolved();
  const double dx = world.desc().spacing;
  // The number of stages grows with the root of the step.
  double sweeps = 0;
  if (std::isfinite(resolved.stable_dt) && resolved.stable_dt > 0)
    sweeps = static_cast<double>(resolved.heat_sweeps +
                                 std::int64_t{resolved.viscous_stages} * resolved.viscous_supersteps) *
             std::sqrt(std::min(1.0, dt / resolved.stable_dt));
  else if (diffusivity > 0)  // 12 / dx^2: the largest eigenvalue of the Laplacian on a lattice
    sweeps = physics::stage_count(std::min(1e9, dt * 12 * diffusivity / (dx * dx)), false);
  return work_of_substep(particles, resolved.support_radius / dx, sweeps, world.backend());
}

Reference reference_of(World& world) {
  const Resolved resolved = world.resolved();
  Reference reference;
  reference.spacing = world.desc().spacing;
  reference.support = resolved.support_radius / world.desc().spacing;
  reference.sound_speed = resolved.sound_speed;
  reference.courant = world.desc().courant;
  reference.stable_dt = world.stable_dt();
  return reference;
}

Knobs multiples(const Reference& here, const Reference& of, const Knobs& asked) {
  const auto ratio = [](double a, double b) { return a > 0 && b > 0 ? a / b : 1.0; };
  Knobs knobs = asked;
  knobs[Knob::spacing] = ratio(here.spacing, of.spacing);
  knobs[Knob::support] = ratio(here.support, of.support);
  knobs[Knob::sound_speed] = ratio(here.sound_speed, of.sound_speed);
  knobs[Knob::courant] = ratio(here.courant, of.courant);
  return knobs;
}

Result<Measurement> measure_from(const Problem& problem, const Knobs& knobs, double wall_limit,
                                 const Reference* reference) {
  return core::guarded<Result<Measurement>>([&]() -> Result<Measurement> {
    if (problem.run) return problem.run(knobs, wall_limit);
    Result<World> world = problem.build(knobs);
    if (!world) return world.error();
    const Reference here = reference_of(*world);
    Result<Measurement> result = Probe(problem, knobs, std::move(*world), wall_limit).run();
    if (result) result->actual = multiples(here, reference != nullptr ? *reference : here, knobs);
    return result;
  });
}

Result<Reference> reference_to(const Problem& problem) {
  if (problem.run) return Reference{};
  Result<World> world = core::guarded<Result<World>>([&] { return problem.build(Knobs{}); });
  if (!world) return world.error();
  return reference_of(*world);
}

Result<Measurement> measure(const Problem& problem, const Knobs& knobs, double wall_limit) {
  if (const Status s = check(problem); !s) return s.error();
  if (const Status s = check(knobs); !s) return s.error();
  const Result<Reference> reference = reference_to(problem);
  if (!reference) return reference.error();
  return measure_from(problem, knobs, wall_limit, &*reference);
}

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
