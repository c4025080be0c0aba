// SPDX-License-Identifier: Apache-2.0
// A step: its sub-steps, their stages of heat, emission and probes that are due, and the result.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>

#include "description/nozzle.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "meltsim/physics/shape_matching.hpp"
#include "meltsim/physics/sound_speed.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"
#include "pipeline/pipeline.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Most that heat.max_supersteps can be set to.
constexpr int most_supersteps = 1000000;
/// Where nothing moves, or all too slowly: single precision holds it and its square [s].
constexpr double longest_substep = 1e15, shortest_step = 1e-30;
}  // namespace

double WorldImpl::stable_dt() {
  static_cast<void>(prepare());  // a failure shows at the next step
  return std::min(stable_dt(last_max_speed_), motion_dt());
}

double WorldImpl::stable_dt(double speed) const {
  const double largest = largest_substep(), support = core::support_of(desc);
  if (!(speed > 0) || !std::isfinite(largest)) return largest;
  return std::min({largest, physics::signal_dt(desc.courant, support, sound_now(), speed),
                   // A particle may cross courant H per sub-step before a flag is raised.
                   desc.courant * support / speed});
}

/// Most stages of a super-step of heat for tau lambda. Where something melts or freezes they are few, as far as heat.max_supersteps allows.
int WorldImpl::most_heat_stages(double reach) const {
  const int given = physics::most_stages(desc.heat.max_stages, changes_phase_);
  if (!changes_phase_ || given <= physics::phase_stages) return given;
  const double each = reach / desc.heat.max_supersteps;
  if (!(each < physics::stage_reach(given))) return given;
  return std::max(physics::phase_stages, physics::stage_count(each, true));
}

void WorldImpl::heat_plan(double dt, int& stages, int& supersteps, double& heat_dt, double& bound) const {
  const double tau = dt * desc.heat.time_scale;
  stages = supersteps = 0;
  heat_dt = tau;
  bound = infinity;
  if ((facts_ & (core::fact_heat_enthalpy | core::fact_heat_paper | core::fact_heat_iwasaki)) == 0) return;
  stages = supersteps = 1;
  if ((facts_ & core::fact_heat_enthalpy) == 0) return;
  const double reach = tau * heat_lambda_;
  const int most = most_heat_stages(reach);
  constexpr double countable = 1e12;  // stages for more are beyond an integer
  const bool one = reach <= countable && physics::stage_count(reach, changes_phase_) <= most;
  // check_heat_work() refuses more than there may be.
  if (!one)
    supersteps = static_cast<int>(
        std::min(std::ceil(reach / physics::stage_reach(most)), double(most_supersteps) + 1));
  if (!std::isfinite(largest_substep()) || !driven())
    supersteps = std::max(supersteps, static_cast<int>(std::min(physics::resting_supersteps(reach),
                                                                double(desc.heat.max_supersteps))));
  stages = supersteps > most_supersteps ? most : physics::stage_count(reach / supersteps, changes_phase_);
  heat_dt = tau / supersteps;
  bound = physics::stage_reach(stages) / (2 * heat_dt);
}

void WorldImpl::viscous_plan(double dt, core::SubstepArguments& a) const {
  a.viscous_stages = a.viscous_supersteps = 0;
  a.viscous_dt = dt;
  a.viscous_bound = infinity;
  if ((facts_ & core::fact_implicit) == 0) return;
  const physics::ViscousStages v = physics::viscous_stages(dt * viscous_lambda_, !strong_pull_);
  a.viscous_stages = v.stages;
  // check_viscous_work() refuses more than max_substeps.
  a.viscous_supersteps = static_cast<int>(std::min(v.supersteps, 1e9));
  a.viscous_dt = dt / v.supersteps;
  a.viscous_bound = physics::stage_reach(v.stages) / a.viscous_dt;
}

/// Refuses a step that would take too long, as for heat.
Status WorldImpl::check_viscous_work(double dt, int supersteps) const {
  if (supersteps <= desc.max_substeps) return {};
  return Error{
      ErrorCode::step_too_large,
      core::text("step: dt: viscosity needs ", supersteps, " super-steps of ", physics::most_viscous_stages,
                 " stages in every sub-step of ", dt, " s, more than max_substeps ", desc.max_substeps,
                 "; step by at most ", 0.999 * dt * desc.max_substeps / supersteps,
                 " s, raise max_substeps, or use a larger spacing; viscosities far from those of real "
                 "liquids have this effect, too")};
}

/// Sub-steps of this length that share a step of heat.
int WorldImpl::heat_interval(double substep) const {
  const bool sampled = std::any_of(probes_.begin(), probes_.end(), [](const ProbeRecord& p) {
    return p.desc.kind == ProbeKind::heat;  // heat in one sub-step over its length
  });
  if (sampled || (facts_ & (core::fact_heat_enthalpy | core::fact_heat_paper | core::fact_heat_iwasaki)) == 0)
    return 1;
  if (desc.heat.interval > 0) return desc.heat.interval;
  if ((facts_ & core::fact_heat_enthalpy) == 0) return 1;
  return physics::shared_substeps(substep * desc.heat.time_scale * heat_lambda_);
}

/// `heat`: it is taken in this sub-step.
std::uint64_t WorldImpl::stage_bits(std::uint64_t index, bool heat) const {
  std::uint64_t bits = 0;
  const bool dissolves = (facts_ & core::fact_species) != 0;
  for (int s = 0; s < core::stage_count; ++s) {
    const core::StageInfo& info = core::stage_table[static_cast<std::size_t>(s)];
    if (!core::runs(info, facts_)) continue;
    const std::string_view module = info.module;
    if (s == core::stage_step_enter && layers_.empty() && (facts_ & core::fact_inlets) == 0) continue;
    if (s == core::stage_thermal_level) {
      if (index % core::level_interval != 0) continue;
    } else if (module == "thermal" && !heat) {
      continue;
    }
    if (s == core::stage_topology_pieces) {
      if (index % static_cast<std::uint64_t>(desc.pieces_interval) != 0) continue;
    } else if (module == "topology" && s != core::stage_topology_regions &&
               (index % static_cast<std::uint64_t>(topology_interval_) != 0 || !(heat || dissolves))) {
      continue;  // regions follow whatever melted in the sub-step before
    }
    bits |= std::uint64_t{1} << s;
  }
  return bits;
}

/// A layer of an emitter `late` seconds after its time; `comes`: with its particles, otherwise only its nozzle.
core::BurstArguments WorldImpl::burst_of(const EmitterRecord& e, double late, bool comes) const {
  const auto& row = rows_[e.desc.material.index];
  const Vec3d axis = core::unit(e.desc.axis);
  core::BurstArguments b;
  b.first_point = e.first_point;
  b.points = comes ? e.points : 0;
  b.center = e.desc.center - origin_ + axis * (e.desc.speed * late - e.lead);
  b.radius = core::nozzle_reach_across(e.desc);
  if (core::is_rectangle(e.desc)) {
    const core::NozzleAxes sides = core::nozzle_axes(e.desc);
    b.across = sides.across;
    b.upright = sides.upright;
    b.width = e.desc.width;
    b.height = e.desc.height;
  }
  b.held = (e.held_layers - 0.5) * e.layer_distance;
  b.velocity = axis * e.desc.speed;
  b.mass =
      mixed_density(physics::rest_density(row, physics::enthalpy_of(row, e.desc.temperature)), e.contents) *
      desc.spacing * desc.spacing * desc.spacing;
  round_to_precision(b.mass);
  for (std::size_t k = 0; k < species_.size(); ++k) b.solute[k] = e.contents[k] * b.mass;
  b.volume = desc.spacing * desc.spacing * desc.spacing;
  b.enthalpy = physics::enthalpy_of(row, e.desc.temperature) * b.mass;
  b.tag = e.desc.material.index;
  return b;
}

/// A layer of a nozzle that recycles, as it is at the end of the next sub-step: its particles come in there (step.enter), since which
/// ids are free the device knows.
core::InletLayer WorldImpl::recycled_layer(const EmitterRecord& e, double late) const {
  const core::BurstArguments b = burst_of(e, late, true);
  core::InletLayer layer{e.inlet(), span_of(e)};
  layer.now.center = b.center;
  layer.now.velocity = b.velocity;
  layer.now.enthalpy = b.enthalpy;
  std::copy(b.solute.begin(), b.solute.end(), layer.now.solute);
  layer.now.mass = b.mass;
  layer.now.volume = b.volume;
  layer.now.tag = b.tag;
  layer.now.due = steps + 1;
  return layer;
}

/// Whether a layer that is due has a place: one of a nozzle that recycles may come in a sub-step.
bool WorldImpl::may_come(const EmitterRecord& e) const {
  const bool second = e.recycles() && !layers_.empty() && layers_.back().row == e.inlet();
  return !second && has_room_for(e.points);
}

/// Layers whose time comes in [from, until): known to the host, so emission needs no word from the device.
const std::vector<core::BurstArguments>* WorldImpl::due_bursts(double from, double until) {
  bursts_.clear();
  layers_.clear();
  for (EmitterRecord& e : emitters_) {
    // Behind the last layer the nozzle lets go of those that it holds.
    const std::uint64_t end = std::min(e.layers + e.held_layers, layers_due(e, until));
    for (std::uint64_t layer = std::max(e.first_layer, layers_due(e, from)); layer < end; ++layer) {
      const bool due_now = layer < e.layers;
      e.blocked = due_now && e.on && !may_come(e);
      const bool comes = due_now && e.on && !e.blocked;
      if (due_now && !comes) ++e.skipped;
      bursts_.push_back(burst_of(e, from - due(e, layer), comes && !e.recycles()));
      if (!comes) continue;
      census_.fluid = true;
      if (!e.recycles()) {
        born_ += e.points;
        continue;
      }
      layers_.push_back(recycled_layer(e, until - due(e, layer)));
      census_.removed -= std::min<std::uint64_t>(census_.removed, e.points);  // until it is counted again
    }
    if (!e.on || e.blocked) limit_layers(e);
  }
  return bursts_.empty() ? nullptr : &bursts_;
}

/// Whether a layer was due that max_particles does not allow, or for which there was no room.
bool WorldImpl::exhausted(const EmitterRecord& e) const {
  return !e.reservoir() && (e.blocked || layers_before(e, time) > e.layers);
}

/// Whether so many more particles fit into the domain: a closed one holds its volume over dx^3. More would press on each other until
/// the World halts.
bool WorldImpl::has_room_for(std::uint64_t more) const {
  const DomainDesc& d = desc.domain;
  if (!d.bounded || std::any_of(d.faces.begin(), d.faces.end(), [](Face f) { return f == Face::open; }))
    return true;
  const Vec3d size = d.max - d.min;
  const double room = size.x * size.y * size.z / (desc.spacing * desc.spacing * desc.spacing);
  return static_cast<double>(born_ - census_.removed + more) <= room * (1 + 1e-9);
}

/// Refuses a step that would take too long: a sub-step cannot be interrupted.
Status WorldImpl::check_heat_work(double dt, double supersteps) const {
  if (supersteps <= desc.heat.max_supersteps) return {};
  const double tau = dt * desc.heat.time_scale;
  const int most = most_heat_stages(tau * heat_lambda_);
  const double needed = std::ceil(tau * heat_lambda_ / physics::stage_reach(most));
  return Error{
      ErrorCode::step_too_large,
      core::text(
          "step: dt: heat needs ", needed, " super-steps of ", most, " stages in every sub-step of ", dt,
          " s, more than heat.max_supersteps ", desc.heat.max_supersteps,
          "; lower heat.time_scale by a factor of ", needed / desc.heat.max_supersteps,
          " or step by at most ", 0.999 * dt * desc.heat.max_supersteps / needed,
          " s, or raise heat.max_stages or heat.max_supersteps; conductivities and heat capacities far "
          "from those of real materials have this effect, too")};
}

double WorldImpl::substeps_of(double dt) const {
  return std::ceil(dt / std::min({largest_substep(), motion_dt(), longest_substep}) * (1 - 1e-9));
}

/// Why sub-steps are so short, where something was once faster than anything falls: a slip of the host's may be behind it.
std::string WorldImpl::fast_sound_text() const {
  constexpr double usual = 3;
  const double of_fall =
      physics::sound_speed_for(0, length(desc.gravity), fall_height() + desc.spacing,
                               desc.density_error > 0 ? desc.density_error : physics::usual_density_error);
  if (desc.sound_speed != automatic || !(of_fall > 0) || sound_speed_ < usual * of_fall) return {};
  return core::text("; sound is at ", sound_speed_,
                    " m/s for the fastest that anything was set to, and goes back by restore() alone; "
                    "step_within() takes as many as fit");
}

/// Refuses a step of more than `most` sub-steps; where the sound speed follows what moves, of more than at its
/// largest, so that whether a step is taken does not hang on a splash.
Status WorldImpl::check_substeps(double dt, double most) const {
  const double largest = std::min({static_dt_, motion_dt(), longest_substep});
  const double wanted = std::ceil(dt / largest * (1 - 1e-9));
  if (!(wanted > most)) return {};
  return Error{ErrorCode::step_too_large,
               core::text("step: dt: ", dt, " s needs ", wanted, " sub-steps of at most ", largest,
                          " s, more than max_substeps ", most, "; step by at most ", 0.999 * largest * most,
                          " s, or raise max_substeps", fast_sound_text())};
}

/// Ends a step ahead of time: after a number of sub-steps, or before one for which there is no time.
class WorldImpl::Limit {
 public:
  Limit(core::Engine& engine, core::SubstepCost& cost, double seconds, std::uint64_t substeps)
      : engine_(engine), cost_(cost), seconds_(seconds), substeps_(substeps), start_(Clock::now()) {}

  /// Ahead of the first sub-step: the device has nothing else to do then, so that what follows can be measured.
  void begin() {
    if (!timed()) return;
    engine_.mark(0);
    engine_.wait_for(0);
    learned_ = waited();
    batch_ = 1;
  }
  /// Whether a sub-step may follow on `taken` ones.
  bool allows(std::uint64_t taken) {
    if (taken >= substeps_) return false;
    if (!timed() || taken < marked_ + batch_) return true;
    mark(taken);
    // Waits for the first of two enqueued batches, while the second one runs.
    const bool drain = !engine_.runs_ahead() || !cost_.known();
    while (open_ > (drain ? 0 : 1)) learn();
    batch_ = core::next_batch(cost_, seconds_ - waited(), ahead());
    while (batch_ == 0 && open_ != 0) {  // what was thought to be under way may be done
      learn();
      batch_ = core::next_batch(cost_, seconds_ - waited(), ahead());
    }
    if (batch_ != 0 && !engine_.runs_ahead()) batch_ = 1;
    return batch_ != 0;
  }
  /// Waits for all of them.
  void end(std::uint64_t taken) {
    if (!timed()) {
      engine_.mark(0);
      engine_.wait_for(0);
      return;
    }
    if (taken > marked_) mark(taken);
    while (open_ != 0) learn();
  }
  /// Most sub-steps of a step: what bounds the work itself needs no other bound.
  double most_substeps(double otherwise) const {
    return timed() || substeps_ != ~std::uint64_t{0} ? 1e9 : otherwise;
  }
  double waited() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  bool exceeded() const { return waited() > seconds_; }

 private:
  using Clock = std::chrono::steady_clock;
  bool timed() const { return std::isfinite(seconds_); }
  std::uint64_t ahead() const { return open_ == 0 ? 0 : open_ == 1 ? size_[first_] : size_[0] + size_[1]; }
  void mark(std::uint64_t taken) {
    if (open_ == 2) learn();
    const int number = (first_ + open_) % 2;
    size_[number] = taken - marked_;
    marked_ = taken;
    ++open_;
    engine_.mark(number);
  }
  void learn() {
    engine_.wait_for(first_);
    const double now = waited();
    cost_.learn(now - learned_, size_[first_]);
    learned_ = now;
    first_ = 1 - first_;
    --open_;
  }

  core::Engine& engine_;
  core::SubstepCost& cost_;
  double seconds_;
  std::uint64_t substeps_;
  Clock::time_point start_;
  double learned_ = 0;                    ///< [s] when the last batch that was waited for was done
  std::uint64_t marked_ = 0, batch_ = 0;  ///< sub-steps up to the last mark; how many follow
  std::uint64_t size_[2] = {0, 0};        ///< sub-steps of the two batches that may be open
  int first_ = 0, open_ = 0;              ///< the older of them; how many are
};

Result<TimedStep> WorldImpl::step_within(double dt, double milliseconds) {
  if (!(milliseconds > 0))
    return invalid("step_within: milliseconds: must be above 0, got ", milliseconds,
                   "; infinity takes all of dt");
  if (engine->host_captures())
    return invalid(
        "step_within: the World's stream is being captured into a graph, in which no time passes; use "
        "step_part()");
  return limited_step(dt, milliseconds / 1000, ~std::uint64_t{0});
}

Result<TimedStep> WorldImpl::step_part(double dt, std::uint64_t substeps) {
  return limited_step(dt, infinity, substeps);
}

Result<TimedStep> WorldImpl::limited_step(double dt, double seconds, std::uint64_t substeps) {
  Limit limit(*engine, substep_cost_, seconds, substeps);
  TimedStep done;
  done.owed = dt;
  if (Status s = step(dt, &limit, &done); !s) return s.error();
  done.wall_ms = 1000 * limit.waited();
  done.substep_ms = 1000 * substep_cost_.mean();
  done.over_budget = limit.exceeded();
  return done;
}

Status WorldImpl::step(double dt) { return step(dt, nullptr, nullptr); }

Error WorldImpl::halted_error() const {
  return {ErrorCode::halted, "step: the World halted: " + halt_reason_ + "; restore a snapshot to go on"};
}

Status WorldImpl::check_step(double dt) const {
  if (!(std::isfinite(dt) && dt >= 0))
    return invalid("step: dt: must be finite and >= 0 s, got ", dt, "; 0 does nothing");
  if (dt == 0) return {};
  if (dt < shortest_step)
    return invalid("step: dt: must be 0 or at least ", shortest_step, " s, got ", dt,
                   "; single precision cannot tell it from 0");
  if (!(time + dt > time))
    return invalid("step: dt: ", dt, " s does not move the clock, which is at ", time,
                   " s and goes by 2e-16 of that; take a longer step",
                   dt < 1e-9 ? "" : ", or restore() or load_saved() a state from earlier");
  if (halted_) return halted_error();
  return {};
}

/// The plan has followed a step that is not taken: it goes back.
Status WorldImpl::not_taken(Status s, const BeforePlan& before) {
  bool limits_follow = false;
  const auto as_it_was = [&] {
    limits_follow = limits_follow || may_melt_ != before.may_melt || liquid_used_ != liquid_used_before_;
    state_.heat_level = before.heat_level;
    may_melt_ = before.may_melt;
    liquid_used_ = liquid_used_before_;
    census_.unsettled = census_.unsettled && before.melted;
    plan_until_ = before.plan_until;
  };
  as_it_was();
  // Where there is no memory to go back, the next step tries again.
  if (regions_act(time, time)) static_cast<void>(adapt(true));
  as_it_was();
  if (limits_follow) {
    derive_limits();
    plan_changed_ = true;
  }
  return s;
}

/// A step while it is taken. Where the sound speed follows what moves, it is taken in parts that are planned one by one; else
/// there is one.
class WorldImpl::OngoingStep {
 public:
  OngoingStep(WorldImpl& world, double dt, Limit* limit)
      : w_(world), dt_(dt), start_(world.time), limit_(limit) {}

  Status take() {
    Status s;
    do s = take_part();
    while (s && goes_on_);
    return s;
  }
  bool refused() const { return refused_; }  ///< no sub-step was taken, because they would be too many
  void report(TimedStep& done) const;

 private:
  Status check_parts() const;
  Status take_part();
  bool take_substep(int k);
  void plan_heat(int k);
  Error broken_off();

  WorldImpl& w_;
  double dt_, start_;
  Limit* limit_;
  int taken_ = 0, planned_ = 0;  ///< sub-steps
  double simulated_ = 0;         ///< [s]
  bool goes_on_ = false, refused_ = false;
  // The part that is being taken.
  core::SubstepArguments a_;
  StepPart part_;
  double from_ = 0, end_ = 0,
         rest_ = 0;     ///< where it began; where it ends, and how long it is, if nothing breaks it off [s]
  int before_ = 0;      ///< sub-steps of other parts
  int unheated_ = 0;    ///< sub-steps since the last with heat
  std::string thrown_;  ///< what a stage of the host threw
  bool heats_ = false;  ///< the sub-step does
};

/// A step that is refused is refused as a whole: whether heat takes too long in any of its parts.
Status WorldImpl::OngoingStep::check_parts() const {
  const double end = start_ + dt_;
  for (double from = start_, until = 0; from < end; from = until) {
    until = w_.next_switch(from, end);
    core::SubstepArguments a;
    StepPart part;
    if (from == start_ && until == end) return {};
    if (Status s = w_.plan_part(until - from, a, part); !s) return s;
  }
  return {};
}

Status WorldImpl::OngoingStep::take_part() {
  before_ = taken_;
  from_ = before_ == 0 ? start_ : w_.time;
  end_ = w_.next_switch(from_, start_ + dt_);
  rest_ = before_ == 0 && end_ == start_ + dt_ ? dt_ : end_ - from_;
  a_ = {};
  part_ = {};
  unheated_ = 0;
  const FollowedSound sound = w_.sound_;
  const bool look_now = w_.look_now_;
  if (w_.follows_sound()) w_.plan_sound(rest_);
  Status fits = w_.plan_part(rest_, a_, part_);
  if (!fits && w_.at_full_sound()) fits = w_.plan_part(rest_, a_, part_);
  if (fits && before_ == 0) fits = check_parts();
  refused_ = !fits && before_ == 0;
  if (refused_) {
    const double work = w_.sound_.work;  // was taken from the device
    w_.sound_ = sound;
    w_.sound_.work = work;
    w_.look_now_ = look_now;
    return fits;
  }
  w_.follow_paths(before_ == 0);
  w_.substep_ = a_.dt;
  const int n = part_.substeps, last = w_.follows_sound() ? std::min(n, w_.part_length()) : n;
  planned_ = before_ + n;
  int k = 0;
  for (; k < last; ++k) {
    if (limit_ != nullptr && !limit_->allows(static_cast<std::uint64_t>(taken_))) break;
    if (w_.interrupted_.exchange(false, std::memory_order_relaxed)) return broken_off();
    if (!take_substep(k)) return broken_off();
  }
  w_.heat_owed_ += a_.dt * unheated_;
  const bool whole = k == n && end_ == start_ + dt_;
  simulated_ = whole ? dt_ : k == n ? end_ - start_ : (from_ - start_) + rest_ * k / n;
  if (w_.follows_sound() && k == last && w_.steps % physics::sound_interval == 0) w_.look_at_sound();
  goes_on_ = k == last && !whole;
  return {};
}

/// false: the step ends here. It was broken off, and the World is back at the beginning of it; or a stage of the host threw.
bool WorldImpl::OngoingStep::take_substep(int k) {
  const int n = part_.substeps;
  a_.time = from_ + rest_ * k / n;
  a_.end = k + 1 == n ? end_ : from_ + rest_ * (k + 1) / n;
  a_.index = w_.steps + 1;
  w_.begin_motions(a_, taken_ == 0, k == 0);
  plan_heat(k);
  if (heats_) w_.follow_heat(a_.end - 0.5 * a_.dt);
  a_.bursts = w_.emitters_.empty() ? nullptr : w_.due_bursts(a_.time, a_.end);
  a_.layers = w_.layers_.empty() ? nullptr : &w_.layers_;
  a_.stages = w_.stage_bits(a_.index, heats_);
  w_.begin_sample(a_, a_.end);
  const FollowedSound sound = w_.sound_;
  if (w_.follows_sound()) w_.go_on_with_sound(a_.dt);
  a_.spring_stretch = w_.spring_stretch();
  w_.state_stale_ = true;
  ++w_.steps;
  w_.engine->substep(a_);
  thrown_ = w_.engine->take_thrown();
  if (w_.engine->abandoned()) {  // as of a World that halted
    w_.fetch_state();
    w_.dirty_ = true;
    w_.sound_ = sound;
    w_.interrupted_.store(false, std::memory_order_relaxed);
    return false;
  }
  w_.end_sample(a_, a_.end);
  w_.time = a_.end;
  w_.could_melt_ = w_.may_melt_;
  ++taken_;
  unheated_ = heats_ ? 0 : unheated_ + 1;
  if (heats_) w_.heat_owed_ = 0;
  return thrown_.empty();
}

/// Whether heat flows in the sub-step, and over which time.
void WorldImpl::OngoingStep::plan_heat(int k) {
  // A step that is broken off again and again would never get as far as its share.
  const double span = w_.heat_owed_ + a_.dt * (unheated_ + 1);
  heats_ = part_.heats(k) || span > (part_.heat_every - 0.5) * a_.dt;
  if (!heats_ || span == part_.heat_span) return;
  part_.heat_span = span;
  w_.heat_plan(span, a_.heat_stages, a_.heat_supersteps, a_.heat_dt, a_.heat_bound);
}

Error WorldImpl::OngoingStep::broken_off() {
  w_.heat_owed_ += a_.dt * unheated_;
  const std::string where =
      core::text(" after ", taken_, " of ", planned_, " sub-steps, ", w_.time - start_, " of ", dt_, " s");
  if (thrown_.empty())
    return {ErrorCode::interrupted,
            "step: interrupted" + where + "; the World is good up to there, call step again to go on"};
  return {ErrorCode::internal, "step: " + thrown_ + ", which ended the step as interrupt() does," + where +
                                   "; let the stage catch what it throws, or remove it"};
}

void WorldImpl::OngoingStep::report(TimedStep& done) const {
  done.substeps = static_cast<std::uint64_t>(taken_);
  done.planned = static_cast<std::uint64_t>(planned_);
  done.simulated = simulated_;
  done.owed = dt_ - simulated_;
}

/// With a limit: as far as that allows, and waits; `done` is what it came to.
Status WorldImpl::step(double dt, Limit* limit, TimedStep* done) {
  if (Status s = check_step(dt); !s || dt == 0) return s;
  const std::vector<std::size_t> let_go = let_go_of_bodies(dt);
  const std::uint64_t before = steps;
  Status s = attempt(dt, limit, done);
  if (steps > 0) laid_out_ = {};
  if (s || let_go.empty() || steps != before || halted_) return s;
  for (const std::size_t b : let_go) set_held(b, true);  // no sub-step was taken
  return s;
}

Status WorldImpl::attempt(double dt, Limit* limit, TimedStep* done) {
  if (Status s = ready_to_step(); !s) return s;
  const double carried = carried_speed_;
  if (Status s = plan_motions(dt); !s) return s;
  find_timed_bodies();
  const auto refused = [&](Status s) {  // the motions wait for another step
    carried_speed_ = carried;
    return s;
  };
  const double most = limit != nullptr ? limit->most_substeps(desc.max_substeps) : double(desc.max_substeps);
  if (Status s = check_substeps(dt, most); !s)
    return refused(s);  // before anything follows the plan of a step that is not taken
  const BeforePlan before{state_.heat_level, may_melt_, (facts_ & core::fact_melt) != 0, plan_until_};
  liquid_used_before_ = liquid_used_;
  if (Status s = follow_plan(dt); !s) return refused(not_taken(s, before));
  if (halted_) return halted_error();  // found out while it was prepared
  if (Status s = check_substeps(dt, most); !s) return refused(not_taken(s, before));
  OngoingStep ongoing(*this, dt, limit);
  if (limit != nullptr) limit->begin();
  if (Status s = ongoing.take(); !s) return ongoing.refused() ? refused(not_taken(s, before)) : s;
  if (limit == nullptr) return {};
  ongoing.report(*done);
  limit->end(done->substeps);
  return {};
}

/// Divides the rest of a step into sub-steps, with the stages of heat, viscosity and species that they need. An error, with all
/// of it set nevertheless, where that is more work than is allowed.
Status WorldImpl::plan_part(double rest, core::SubstepArguments& a, StepPart& part) const {
  const int n = std::max(1, static_cast<int>(substeps_of(rest)));
  part.substeps = n;
  a.dt = rest / n;
  // Steps of heat are spread evenly over the sub-steps; the last one ends the step.
  part.heat_every = heat_interval(a.dt);
  part.heat_rounds = (n + part.heat_every - 1) / part.heat_every;
  part.heat_span = std::max(heat_owed_ + a.dt, a.dt * ((n + part.heat_rounds - 1) / part.heat_rounds));
  heat_plan(part.heat_span, a.heat_stages, a.heat_supersteps, a.heat_dt, a.heat_bound);
  viscous_plan(a.dt, a);
  solute_plan(a.dt, a);
  if (Status s = check_heat_work(part.heat_span, a.heat_supersteps); !s) return s;
  if (Status s = check_viscous_work(a.dt, a.viscous_supersteps); !s) return s;
  return check_solute_work(a.dt, a);
}

/// What hosts have set of kinematic bodies and proxies goes with the first sub-step of a step, a new part of a path with that of a part of it.
void WorldImpl::begin_motions(core::SubstepArguments& a, bool first, bool first_of_part) {
  a.steered = nullptr;
  if (first_of_part && !steered_.empty()) {
    a.steered = &steered_;
    for (const core::Steered& s : steered_) {
      if (bodies_[s.body].kinematic()) state_.motion[s.body] = s.motion;  // the device moves proxies
      motions_[s.body].reset();
      proxies_[s.body].reset();
    }
  }
  a.reshaped = nullptr;
  if (first && !reshaped_.empty()) {
    a.reshaped = &reshaped_;
    for (const core::Reshaped& r : reshaped_) {
      std::copy(r.points, r.points + r.count, state_.mesh_points.begin() + std::ptrdiff_t{r.first});
      meshes_[r.body].set = false;
    }
  }
}

std::string WorldImpl::halt_text(const core::WorldStatus& s) {
  fetch_state();
  std::string body;
  if (s.halt_particle < state_.tag.size()) {
    const std::uint32_t b = body_of(state_.tag[s.halt_particle]);
    if (b != 0 && is_solid(state_.tag[s.halt_particle]))
      body = " (body \"" + bodies_[b - 1].desc.name + "\")";
  }
  const char* what = "";
  switch (static_cast<core::Halt>(s.halted)) {
    case core::Halt::position:
      what = "position is not finite, or the volume, after the search for neighbours";
      break;
    case core::Halt::density:
      what = "density is not finite after sph.density";
      break;
    case core::Halt::force:
      what = "acceleration is not finite after sph.forces";
      break;
    case core::Halt::shape:
      what = "velocity is not finite after lsm.balance";
      break;
    case core::Halt::heat:
      what = "enthalpy is not finite after thermal.exchange";
      break;
    default:
      break;
  }
  if (static_cast<core::Halt>(s.halted) == core::Halt::unsaved)
    return "load_state: nothing was saved, since the World had halted before save_state()";
  if (static_cast<core::Halt>(s.halted) == core::Halt::speed)
    return core::text("sub-step ", s.halt_step, ": particle ", s.halt_particle, body, ": speed ",
                      s.halt_value, " m/s crosses its neighbourhood in one sub-step (step.integrate)");
  return core::text("sub-step ", s.halt_step, ": particle ", s.halt_particle, body, ": ", what);
}

namespace {
std::string fault_text(const std::string& fault) {
  return fault.compare(0, 7, "checked") == 0 ? fault : "device: " + fault;
}
}  // namespace

StepResult WorldImpl::synchronize() {
  StepResult r = collect();
  add_extremes(r, take_carried());
  if (r.max_speed > 0) last_max_speed_ = r.max_speed;
  return r;
}

/// Extremes of the interval that ends now as far as the host has them; those of the next begin.
StepResult WorldImpl::take_carried() {
  StepResult r = std::exchange(carried_, {});
  r.modulus_unreachable = steps > 0 && modulus_out_of_reach();
  r.body_stiffened = steps > 0 && stiffened_by_liquid();
  return r;
}

void WorldImpl::add_extremes(StepResult& r, const StepResult& more) {
  r.max_speed = std::max(r.max_speed, more.max_speed);
  r.max_density_ratio = std::max(r.max_density_ratio, more.max_density_ratio);
  r.courant_exceeded = r.courant_exceeded || more.courant_exceeded;
  r.heat_bound_exceeded = r.heat_bound_exceeded || more.heat_bound_exceeded;
  r.viscous_bound_exceeded = r.viscous_bound_exceeded || more.viscous_bound_exceeded;
  r.solute_bound_exceeded = r.solute_bound_exceeded || more.solute_bound_exceeded;
  r.cooled_to_zero = r.cooled_to_zero || more.cooled_to_zero;
  r.level_bared = r.level_bared || more.level_bared;
  r.body_stiffened = r.body_stiffened || more.body_stiffened;
  r.modulus_unreachable = r.modulus_unreachable || more.modulus_unreachable;
}

WorldImpl::Moment WorldImpl::now() const {
  const bool spent =
      std::any_of(emitters_.begin(), emitters_.end(), [this](const auto& e) { return exhausted(e); });
  return {steps,       time,        solids_built_, spent,           reserved_ids(), origin_,
          sound_now(), sound_.work, displaced_,    displaced_work_, forgotten_};
}

/// Flags of a status of that moment, except halts.
StepResult WorldImpl::result_of(const core::WorldStatus& s, const Moment& at) {
  StepResult r;
  r.steps = at.steps;
  r.time = at.time;
  r.max_speed = s.max_speed;
  r.max_density_ratio = s.max_density;
  r.courant_exceeded = s.courant_exceeded != 0;
  r.heat_bound_exceeded = s.heat_bound_exceeded != 0;
  r.viscous_bound_exceeded = s.viscous_bound_exceeded != 0;
  r.solute_bound_exceeded = s.solute_bound_exceeded != 0;
  r.cooled_to_zero = s.cooled_to_zero != 0;
  r.level_bared = s.level_bared != 0;
  r.emitter_exhausted = at.emitter_exhausted || s.reserve_spent != 0;
  r.melted = static_cast<std::uint64_t>(s.melted);
  r.frozen = s.frozen;
  r.strayed = static_cast<std::uint64_t>(s.strayed);
  r.entered = static_cast<std::uint64_t>(s.entered);
  r.removed =
      left_of(static_cast<std::uint64_t>(s.removed), r.entered, at.reserved_ids) - r.strayed + at.forgotten;
  r.solid = at.solids_built + s.frozen - r.melted;
  r.fluid = s.particles - static_cast<std::uint64_t>(s.removed) - r.solid;
  return r;
}

/// Reports a halt: the clock goes back with the state.
void WorldImpl::report_halt(const core::WorldStatus& s, StepResult& r) {
  r.halted = true;
  r.halt_step = s.halt_step;
  if (s.halt_step == 0) return;
  r.steps = s.halt_step - 1;
  r.time = s.time;
}

/// Whether the World halted: it is then back at its last good state, and clock and emitters go with it.
void WorldImpl::note_halt(const core::WorldStatus& s, const std::string& fault) {
  if (halted_ || (s.halted == 0 && fault.empty())) return;
  if (s.halt_step != 0) {
    steps = s.halt_step - 1;
    time = s.time;
  }
  if (static_cast<core::Halt>(s.halted) == core::Halt::interrupted && fault.empty()) return;
  halted_ = true;
  // States saved after the halted sub-step do not exist.
  for (SavedState& saved : saved_)
    if (saved.restored == restored_ && s.halt_step != 0 && saved.steps >= s.halt_step) saved = {};
  halt_step_ = s.halt_step;
  halt_reason_ = fault.empty() ? halt_text(s) : fault_text(fault);
}

/// Results of the steps since the last call, from engine and host.
StepResult WorldImpl::collect() {
  // Nothing was stepped since a change or restore(): the engine's status is of what was before.
  const core::WorldStatus s = dirty_ ? core::WorldStatus{} : engine->synchronize();
  note_halt(s, engine->fault());
  StepResult r = result_of(s, now());
  r.halted = halted_;
  r.halt_reason = halt_reason_;
  r.halt_step = halt_step_;
  if (dirty_) {  // the state is on the host
    r.melted = state_.melted;
    r.frozen = state_.frozen;
    r.entered = state_.entered;
    r.removed = left_of(state_.removed, state_.entered, reserved_ids()) - state_.strayed + forgotten_;
    r.strayed = state_.strayed;
    r.fluid = r.solid = 0;
    for (const std::uint32_t tag : state_.tag) {
      r.fluid += is_fluid(tag) ? 1u : 0u;
      r.solid += is_solid(tag) ? 1u : 0u;
    }
    return r;
  }
  if (halted_) return r;
  note(s);
  if (plan_changed_) static_cast<void>(adapt());  // a failure shows at the next step
  return r;
}

double WorldImpl::heat_efficiency(double dt) const {
  if ((facts_ & core::fact_heat_paper) == 0) return 1;
  double K = 0;
  for (const auto& row : rows_) K = std::max(K, row.diffusivity);
  const double tau = dt * desc.heat.time_scale;
  return K > 0 && tau > 0
             ? physics::paper_effective_diffusivity(K, tau, core::support_of(desc), desc.spacing) / K
             : 1;
}

Resolved WorldImpl::resolved() {
  Resolved r;
  if (Status s = ready_to_step(); !s) r.error = s.error().message;
  r.backend = engine->backend();
  r.backend_reason = backend_reason;
  r.device_name = engine->device_name();
  r.neighbour_search = search_.search;
  r.neighbour_reason = search_.reason;
  r.support_radius = core::support_of(desc);
  r.sound_speed = (facts_ & core::fact_particles) != 0 ? sound_speed_ : 0;
  r.stable_dt = largest_substep();
  r.origin = origin_;
  for (const MaterialDesc& m : materials) r.stiffness.push_back(stiffness_of(m));
  double heat_dt = 0, bound = 0;
  if (std::isfinite(r.stable_dt)) {
    r.heat_interval = heat_interval(r.stable_dt);
    heat_plan(r.stable_dt * r.heat_interval, r.heat_stages, r.heat_supersteps, heat_dt, bound);
  }
  r.heat_sweeps = std::int64_t{r.heat_stages} * r.heat_supersteps;
  r.viscosity = (facts_ & core::fact_implicit) != 0 ? Viscosity::implicit : Viscosity::explicit_;
  r.viscous_dt = viscous_dt_;
  if (std::isfinite(r.stable_dt)) {
    core::SubstepArguments a;
    viscous_plan(r.stable_dt, a);
    r.viscous_stages = a.viscous_stages;
    r.viscous_supersteps = a.viscous_supersteps;
    solute_plan(r.stable_dt, a);
    r.solute_supersteps = a.solute_supersteps;
  }
  if (std::isfinite(r.stable_dt)) r.heat_efficiency = heat_efficiency(r.stable_dt);
  return r;
}

}  // namespace v0
}  // namespace meltsim
