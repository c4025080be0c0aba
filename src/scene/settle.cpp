// SPDX-License-Identifier: Apache-2.0
// Liquid that comes to rest before the first step: sub-steps of a second World that is this one with nothing in it that moves, heats or
// brings liquid (physics/hydrostatic.hpp: settling_rate, settling_time).
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/hydrostatic.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Sub-steps between two looks at whether the host interrupts.
constexpr double substeps_at_once = 16;
/// Far more than any liquid needs: what asks for more is a slip.
constexpr double most_substeps = 100000;

/// Faces that liquid could leave through hold it. Where walls would be too close to each other for their images, the faces stay open.
void close_faces(DomainDesc& d, double support) {
  const double size[3] = {d.max.x - d.min.x, d.max.y - d.min.y, d.max.z - d.min.z};
  for (std::size_t f = 0; f < 6 && d.bounded; ++f)
    if (d.faces[f] == Face::open && size[f / 2] >= 2 * support) d.faces[f] = Face::wall;
  d.outlets = {};
  d.velocity = {};
}

Error as_settle(const Error& e) {
  const std::string of_step = "step: ";
  const bool named = e.message.compare(0, of_step.size(), of_step) == 0;
  return {e.code, "settle: " + (named ? e.message.substr(of_step.size()) : e.message)};
}
}  // namespace

/// `calm`, a new World, becomes this one, with bodies that stay where they are and nothing that moves by itself, heats or is watched.
void WorldImpl::make_calm(WorldImpl& calm) const {
  calm.desc = desc;
  calm.desc.sound_speed = sound_speed_;
  calm.desc.density_error = automatic;
  calm.desc.follow_sound_speed = false;
  calm.desc.reserved_particles = 0;
  calm.desc.max_substeps = 1 << 20;
  close_faces(calm.desc.domain, core::support_of(desc));
  calm.engine = engine;
  calm.materials = materials;
  calm.species_ = species_;
  calm.properties_ = properties_;
  calm.bodies_ = bodies_;
  calm.lattice_ = lattice_;
  calm.state_ = state_;
  calm.fills_ = fills_;
  calm.solids_built_ = solids_built_;
  calm.origin_ = origin_;
  calm.origin_set_ = calm.pressed_ = true;
  calm.motions_.resize(bodies_.size());
  calm.meshes_.resize(bodies_.size());
  calm.proxies_.resize(bodies_.size());
  calm.disabled_facts_ =
      ~(core::fact_particles | core::fact_fluid | core::fact_solid | core::fact_viscosity |
        core::fact_strain | core::fact_isotropic | core::fact_tension | core::fact_implicit);
  calm.fix_bodies();
  calm.hold_liquid(hanging());
}

void WorldImpl::fix_bodies() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    BodyRecord& body = bodies_[b];
    body.desc.motion = Motion::fixed;
    body.desc.fixed = true;
    body.held = body.watched = false;
    body.desc.max_speed = 0;
    lattice_.bodies[b].motion = motion_of(body, true);
  }
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    std::uint32_t& tag = state_.tag[i];
    if (!is_solid(tag)) continue;
    tag = (tag & ~tag_kinematic) | tag_fixed;
    state_.velocity[i] = {};
  }
}

/// Liquid that moves, and what hangs, stays in its place as if a nozzle held it.
void WorldImpl::hold_liquid(const std::vector<std::uint32_t>& hanging) {
  for (const std::uint32_t id : hanging) state_.tag[id] |= tag_held;
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    if (!is_fluid(state_.tag[i]) || !(length(state_.velocity[i]) > 0)) continue;
    state_.tag[i] |= tag_held;
    state_.velocity[i] = {};
  }
}

/// Fields that act on liquid at the start, for as long as it takes, and a wind that slows it down in place of winds that drive it.
std::array<ForceFieldRecord, physics::most_force_fields> WorldImpl::calming_fields(double rate) const {
  std::array<ForceFieldRecord, physics::most_force_fields> all{};
  ForceFieldDesc drag;
  drag.kind = ForceFieldKind::drag;
  drag.rate = rate;
  drag.center = Vec3d{};
  all[0].desc = std::move(drag);
  all[0].used = true;
  std::size_t next = 1;
  for (const ForceFieldRecord& r : force_fields_) {
    if (!r.used || r.desc.kind == ForceFieldKind::drag || time < r.desc.from || time >= r.desc.until)
      continue;
    if (next == all.size()) break;
    all[next] = r;
    all[next].desc.from = 0;
    all[next++].desc.until = infinity;
  }
  return all;
}

/// Way of sound through the liquid that may move [m]: down, and across as far as it is deep, there and back.
double WorldImpl::sound_path() const {
  Vec3d low{infinity, infinity, infinity}, high = low * -1.0;
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    if (!is_fluid(state_.tag[i]) || is_held(state_.tag[i])) continue;
    const Vec3d x = state_.position[i];
    low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
  }
  if (!(low.x <= high.x)) return 0;
  const Vec3d size = high - low + cube(), g = desc.gravity;
  const double widest = std::max({size.x, size.y, size.z}), pull = length(g);
  if (!(pull > 0)) return 2 * widest;
  const double depth = (std::fabs(g.x) * size.x + std::fabs(g.y) * size.y + std::fabs(g.z) * size.z) / pull;
  return depth + std::min(widest, 2 * depth);
}

/// Takes sub-steps for `seconds`, or fewer if the host interrupts.
Status WorldImpl::run_calm(double seconds, const std::atomic<bool>& interrupted, Settled& done) {
  if (Status s = ready_to_step(); !s) return s;
  const double substep = std::min(largest_substep(), seconds);
  while (time < seconds * (1 - 1e-9)) {
    if (interrupted.load(std::memory_order_relaxed)) return Error{ErrorCode::interrupted, "interrupted"};
    if (Status s = step(std::min(substeps_at_once * substep, seconds - time)); !s) return s;
  }
  static_cast<void>(collect());
  if (halted_) return Error{ErrorCode::halted, halt_reason_};
  fetch_state();
  done.seconds = time;
  done.substeps = steps;
  return {};
}

/// Liquid where another World, this one before, has brought it, at the velocities that it has.
void WorldImpl::take_places_of(const WorldImpl& calm, Settled& done) {
  const DomainDesc& d = desc.domain;
  const Vec3d size = d.max - d.min;
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    if (!is_fluid(calm.state_.tag[i]) || is_held(calm.state_.tag[i])) continue;
    Vec3d moved = calm.state_.position[i] - state_.position[i];
    if (core::is_periodic(d, 0)) moved.x = std::remainder(moved.x, size.x);
    if (core::is_periodic(d, 1)) moved.y = std::remainder(moved.y, size.y);
    if (core::is_periodic(d, 2)) moved.z = std::remainder(moved.z, size.z);
    done.farthest = std::max(done.farthest, length(moved));
    done.fastest = std::max(done.fastest, length(calm.state_.velocity[i]));
    state_.position[i] = calm.state_.position[i];
  }
  laid_out_ = {};
  pressed_ = true;
  places_.reset();
}

Result<Settled> WorldImpl::settle(double seconds) {
  if (!(seconds == automatic || (seconds > 0 && std::isfinite(seconds))))
    return invalid("settle: seconds: must be a finite number above 0, got ", seconds,
                   "; leave it out to derive it from the depth");
  if (halted_)
    return Error{ErrorCode::halted,
                 core::text("settle: the World halted: ", halt_reason_, "; restore a snapshot to go on")};
  if (steps != 0)
    return invalid("settle: the World has taken ", steps,
                   " sub-steps; call it before the first, when all that the World starts with is there");
  if (Status s = ready_to_step(); !s) return as_settle(s.error());
  auto calm = std::make_unique<WorldImpl>();
  see_all_anew();  // the other World takes the engine
  make_calm(*calm);
  Settled done;
  const double path = calm->sound_path();
  if (!(path > 0) || !(sound_speed_ > 0)) return done;
  calm->force_fields_ = calming_fields(physics::settling_rate(sound_speed_, path));
  ++uploads_;  // views of surfaces end with their memory
  const double enough = physics::settling_time(sound_speed_, path),
               wanted = seconds == automatic ? enough : seconds;
  if (const double substeps = wanted / static_dt_; substeps > most_substeps)
    return invalid("settle: seconds: ", wanted, " s take ", substeps, " sub-steps, more than ", most_substeps,
                   "; the depth and the speed of sound ask for ", enough,
                   " s; give fewer, or let viscosity be implicit where it limits sub-steps");
  const Status s = calm->run_calm(wanted, interrupted_, done);
  if (!s && s.error().code == ErrorCode::interrupted) {
    interrupted_.store(false, std::memory_order_relaxed);
    return Error{ErrorCode::interrupted,
                 core::text("settle: interrupted after ", calm->time, " of ", wanted,
                            " s; liquid is where it was, call settle() again or step() without it")};
  }
  if (!s) return as_settle(s.error());
  take_places_of(*calm, done);
  return done;
}

}  // namespace v0
}  // namespace meltsim
