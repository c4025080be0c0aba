// SPDX-License-Identifier: Apache-2.0
// Readings: converts data of the engine into those of the interface, at once or later.
#include <algorithm>
#include <atomic>
#include <iterator>
#include <utility>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/energy.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {

/// Tickets are unique in the process, so that a ticket of another World is recognised.
std::uint64_t next_ticket() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

bool is_check(const std::string& fault) { return fault.compare(0, 7, "checked") == 0; }

}  // namespace

/// The executor reports a fault once; this keeps it for later calls.
Status WorldImpl::lost_device() {
  const std::string fault = engine->fault();
  if (fault.empty() || is_check(fault)) return {};  // a broken invariant is reported by synchronize()
  note_halt({}, fault);
  return Error{ErrorCode::internal, halt_reason_};
}

/// Uploads added things into the engine and keeps the extremes of the steps before.
Status WorldImpl::ready_to_read() {
  if (!dirty_) return {};
  carried_ = synchronize();
  return prepare();
}

/// Ahead of a reading of forces: it reports on what is watched since the last step, too. Waits where that is the first to be.
Status WorldImpl::ready_for_forces() {
  const bool planned = dirty_ || halted_ || !plan_changed_ || (facts_ & core::fact_forces) != 0;
  return planned || watched_bodies() == 0 || engine->host_captures() ? Status{} : adapt();
}

/// Waits.
Result<core::StateReading> WorldImpl::read_now(const core::ReadParts& parts) {
  core::StateReading s;
  if (Status ready = ready_to_read(); !ready) return ready.error();
  if ((facts_ & core::fact_particles) == 0) return s;
  if (Status ready = parts.forces ? ready_for_forces() : Status{}; !ready) return ready.error();
  if (Status asked = engine->request(core::waiting_slot, parts); !asked) return asked.error();
  if (Status taken = engine->take(core::waiting_slot, s); !taken) return taken.error();
  if (Status lost = lost_device(); !lost) return lost.error();
  return s;
}

Totals WorldImpl::totals_of(const core::StateReading& s, const StepResult& r, const Moment& at) const {
  const Ledger l = ledger_of(s, r, at);
  Totals t;
  t.fluid = l.fluid;
  t.solid = l.solid;
  t.bodies = s.piece_count;
  t.melted = r.melted;
  t.frozen = r.frozen;
  t.mass = l.mass;
  t.momentum = l.momentum;
  t.angular_momentum = l.angular_momentum;
  t.kinetic = l.kinetic;
  t.potential = l.potential;
  t.thermal = l.thermal;
  t.latent = l.latent;
  t.latent_max = l.latent_max;
  t.heat_in = l.heat_in;
  t.field_work = l.field_work;
  t.field_impulse = l.field_impulse;
  if (s.sums.mass > 0) {
    t.temperature_min = s.extents.coldest;
    t.temperature_max = s.extents.hottest;
    t.temperature_mean = s.extents.heat / s.sums.mass;
  }
  if (s.extents.solid_mass > 0)
    t.solid_center = s.extents.solid_moment * (1 / s.extents.solid_mass) + at.origin;
  t.max_speed = s.extents.speed;
  t.density_error_mean = l.density_error_mean;
  t.density_error_max = l.density_error_max;
  return t;
}

Ledger WorldImpl::ledger_of(const core::StateReading& s, const StepResult& r, const Moment& at) const {
  Ledger l;
  const core::WorldStatus& now = s.status;
  l.step = r.steps;
  l.time = r.time;
  l.fluid = r.fluid;
  l.solid = r.solid;
  l.mass = s.sums.mass;
  l.momentum = s.sums.momentum;
  l.angular_momentum = s.sums.angular_momentum + cross(at.origin, s.sums.momentum);
  l.kinetic = s.sums.kinetic;
  l.potential = s.sums.potential + physics::potential_energy(s.sums.mass, desc.gravity, at.origin);
  l.thermal = s.sums.thermal;
  l.latent = s.sums.latent;
  l.latent_max = s.sums.latent_max;
  l.heat_in = now.heat_in;
  l.field_work = now.field_work;
  l.field_impulse = now.field_impulse;
  l.sound_work = at.sound_work;
  l.displaced = at.displaced;
  l.displaced_work = at.displaced_work;
  std::copy(std::begin(s.contents.solute), std::end(s.contents.solute), l.solute.begin());
  std::copy(std::begin(s.contents.dissolved), std::end(s.contents.dissolved), l.dissolved.begin());
  l.solution = s.contents.solution;
  if (now.ledger_step == 0) {  // no sub-step since the upload
    l.max_speed = s.extents.speed;
    return l;
  }
  l.max_speed = now.step_speed;
  l.density_error_mean = now.step_excess;
  l.density_error_max = std::max(0.0, now.step_density - 1);
  l.sound_speed = at.sound_speed;
  l.courant = (at.sound_speed + now.step_speed) * now.ledger_dt / core::support_of(desc);
  return l;
}

std::vector<PieceInfo> WorldImpl::pieces_of(const core::StateReading& s, Vec3d origin) const {
  std::vector<PieceInfo> all;
  std::vector<int> seen(bodies_.size(), 0);
  const double half = 0.5 * desc.spacing;
  for (const core::PieceReading& from : s.pieces) {
    PieceInfo p;
    p.body = id_of(from.body);
    p.name = bodies_[from.body].desc.name;
    if (++seen[from.body] > 1) p.name += "." + std::to_string(seen[from.body]);
    p.piece = from.label + 1;
    p.particles = from.particles;
    p.mass = from.mass;
    p.center = from.center + origin;
    p.velocity = from.velocity;
    p.orientation = from.orientation;
    p.angular_velocity = from.angular_velocity;
    p.inertia = from.inertia;
    p.bounds.min = from.low + origin - Vec3d{half, half, half};
    p.bounds.max = from.high + origin + Vec3d{half, half, half};
    p.temperature_mean = from.temperature_mean;
    p.submerged_fraction = from.submerged_fraction;
    all.push_back(std::move(p));
  }
  return all;
}

Result<Totals> WorldImpl::totals() {
  core::ReadParts parts;
  parts.sums = true;
  const auto s = read_now(parts);
  if (!s) return s.error();
  const Moment at = now();
  return totals_of(*s, result_of(s->status, at), at);
}

Result<Ledger> WorldImpl::ledger() {
  core::ReadParts parts;
  parts.sums = true;
  const auto s = read_now(parts);
  if (!s) return s.error();
  const Moment at = now();
  StepResult r = result_of(s->status, at);
  if (s->status.halted != 0) report_halt(s->status, r);
  return ledger_of(*s, r, at);
}

Result<std::vector<PieceInfo>> WorldImpl::pieces() {
  core::ReadParts parts;
  parts.pieces = true;
  const auto s = read_now(parts);
  if (!s) return s.error();
  if (s->piece_count > s->pieces.size())
    return Error{ErrorCode::capacity, core::text("pieces: there are ", s->piece_count, ", more than the ",
                                                 std::uint64_t{s->pieces.size()}, " that can be read")};
  return pieces_of(*s, origin_);
}

core::ReadParts WorldImpl::parts_of(const ReadRequest& what) {
  core::ReadParts parts;
  parts.sums = what.totals;
  parts.pieces = what.pieces;
  parts.particles = what.particles;
  parts.forces = what.forces;
  parts.events = what.events;
  parts.clears = true;
  if (what.probes) {
    parts.first_sample = first_of_region();
    parts.samples = samples_used_;
  }
  return parts;
}

Result<ReadTicket> WorldImpl::request(const ReadRequest& what) {
  const auto free = std::find_if(readings_.begin(), readings_.end(),
                                 [](const OpenReading& r) { return r.ticket.value == 0; });
  if (free == readings_.end())
    return Error{ErrorCode::capacity, core::text("request: ", most_readings,
                                                 " readings are open, which is as many as there may be; "
                                                 "take() one first")};
  if (what.events && !event_watch_)
    return invalid("request: events: they are not watched; call watch_events() before the steps");
  if (Status ready = ready_to_read(); !ready) return ready.error();
  if (Status ready = what.forces ? ready_for_forces() : Status{}; !ready) return ready.error();
  OpenReading r;
  r.what = what;
  r.restored = restored_;
  if (what.forces) r.watched = watched();
  r.of_nothing = (facts_ & core::fact_particles) == 0;
  if (r.of_nothing) {
    r.carried = synchronize();
    if (what.probes) collect_samples();
  } else {
    const auto slot = static_cast<int>(free - readings_.begin());
    if (Status asked = engine->request(slot, parts_of(what)); !asked) return asked.error();
    r.carried = take_carried();
    r.at = now();
    state_stale_ = state_stale_ || what.forces || what.events;  // the device begins anew
  }
  if (what.probes) r.samples = hand_over_samples();  // later samples go into another region
  r.ticket.value = next_ticket();
  *free = std::move(r);
  if (what.probes) choose_region();
  return free->ticket;
}

Result<bool> WorldImpl::ready(ReadTicket ticket) {
  for (std::size_t k = 0; k < readings_.size(); ++k)
    if (ticket.value != 0 && readings_[k].ticket.value == ticket.value)
      return readings_[k].of_nothing ? Result<bool>(true) : engine->ready(static_cast<int>(k));
  return invalid("ready: ticket: no open reading of this World has it; use what request() returned, once");
}

/// What was asked for, beside status and samples.
void WorldImpl::fill_reading(Reading& r, core::StateReading& s, const OpenReading& open) {
  if (open.what.totals) {
    r.ledger = ledger_of(s, r.result, open.at);
    r.totals = totals_of(s, r.result, open.at);
  }
  if (open.what.pieces) {
    r.pieces = pieces_of(s, open.at.origin);
    r.pieces_left_out = s.piece_count - s.pieces.size();
  }
  if (open.what.forces) r.forces = forces_of(s, open.watched, open.at.origin, r.time);
  if (open.what.events) r.events = events_of(s, open.at.origin);
  if (open.what.particles) {
    r.particles = std::move(s.particles);
    r.particles.species = species_ids();
    r.particles.fractions.resize(species_.size(), std::vector<float>(r.particles.id.size(), 0.0F));
    r.particles.origin = open.at.origin;
  }
}

Result<Reading> WorldImpl::take(ReadTicket ticket) {
  const auto found = std::find_if(readings_.begin(), readings_.end(), [&](const OpenReading& r) {
    return ticket.value != 0 && r.ticket.value == ticket.value;
  });
  if (found == readings_.end())
    return invalid("take: ticket: no open reading of this World has it; use what request() returned, once");
  OpenReading open = std::exchange(*found, {});
  Reading r;
  r.probes = std::move(open.samples.series);
  if (open.of_nothing) {
    r.result = open.carried;
    r.step = r.result.steps;
    r.time = r.result.time;
    return r;
  }
  core::StateReading s;
  if (Status taken = engine->take(static_cast<int>(found - readings_.begin()), s); !taken)
    return taken.error();
  if (Status lost = lost_device(); !lost) return lost.error();
  r.result = result_of(s.status, open.at);
  add_extremes(r.result, open.carried);
  const bool still_there = open.restored == restored_;
  if (s.status.halted != 0 && static_cast<core::Halt>(s.status.halted) != core::Halt::interrupted) {
    report_halt(s.status, r.result);
    if (still_there) note_halt(s.status, {});
    r.result.halt_reason = still_there ? halt_reason_ : halt_text(s.status);
  }
  if (still_there && s.status.max_speed > 0) last_max_speed_ = s.status.max_speed;
  if (still_there && !halted_ && !dirty_) note(s.status);  // the next step follows
  r.step = r.result.steps;
  r.time = r.result.time;
  add_samples(open.samples, s.samples.data(), s.status.halted != 0 ? s.status.halt_step : 0, r.probes);
  fill_reading(r, s, open);
  return r;
}

}  // namespace v0
}  // namespace meltsim
