// SPDX-License-Identifier: Apache-2.0
// Holding bodies where they are, and releasing them.
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

/// The motion of a body as the engine has it.
std::uint32_t WorldImpl::motion_of(const BodyRecord& body, bool held) {
  if (body.kinematic()) return core::body_kinematic;
  if (body.proxy()) return core::body_proxy;
  if (body.desc.motion == Motion::fixed || held) return core::body_fixed;
  return body.rigid() ? core::body_rigid : core::body_free;
}

Status WorldImpl::hold(BodyId id, bool on) {
  if (Status s = check_body("hold", id); !s) return s;
  BodyRecord& body = bodies_[id.index];
  if (body.desc.motion != Motion::free && body.desc.motion != Motion::rigid)
    return invalid("hold: body \"", body.desc.name, "\": motion: only a free or rigid body can be held; ",
                   body.kinematic() ? "set_motion stops a kinematic one"
                   : body.proxy()   ? "set_proxy stops a proxy"
                                    : "a fixed one never moves");
  if (halted_)
    return Error{ErrorCode::halted,
                 core::text("hold: the World halted: ", halt_reason_, "; restore a snapshot to go on")};
  if (on) {  // it is let go at rest
    body.desc.velocity = body.desc.angular_velocity = {};
    body.desc.held_until = infinity;
  } else {
    body.desc.held_until = 0;
  }
  if (body.held == on) return {};
  set_held(id.index, on);
  return {};
}

/// Where its particles are on the backend. False: that takes an upload.
bool WorldImpl::set_held_in_place(std::size_t b, bool on) {
  if (!edits_in_place()) return false;
  BodyRecord& body = bodies_[b];
  const std::uint32_t count = body.vertices_in_lattice;
  const auto found = engine->find_body(static_cast<std::uint32_t>(b), body.first_vertex, count, found_);
  if (!found) return false;
  note_halt(*found, engine->fault());
  if (found->halted != 0 || halted_) return false;
  double mass = 0;
  Vec3d center{};
  for (const core::FoundParticle& p : found_) {
    mass += p.mass;
    center += p.position * p.mass;
  }
  if (mass > 0) center = center * (1 / mass);
  for (core::FoundParticle& p : found_) {
    p.tag = on ? p.tag | tag_fixed : p.tag & ~tag_fixed;
    p.position = on ? Vec3d{} : body.desc.velocity + cross(body.desc.angular_velocity, p.position - center);
  }
  if (!engine->hold(found_, on, body.first_vertex, count)) return false;
  const Derived before = derived();
  hold_as(b, on);
  static_cast<void>(
      engine->set_body(static_cast<std::uint32_t>(b), lattice_.bodies[b]));  // a fault is told later
  edited_in_place(before);
  if (!regions_fit()) {
    fetch_state();
    dirty_ = true;
  }
  return true;
}

/// Waits.
void WorldImpl::set_held(std::size_t b, bool on) {
  if (set_held_in_place(b, on)) return;
  fetch_state();
  see_added();
  BodyRecord& body = bodies_[b];
  const auto of_body = [&](std::uint32_t tag) { return is_solid(tag) && body_of(tag) == b + 1u; };
  double mass = 0;
  Vec3d center{};
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    if (!of_body(state_.tag[i])) continue;
    mass += state_.mass[i];
    center += state_.position[i] * state_.mass[i];
  }
  if (mass > 0) center = center * (1 / mass);
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    std::uint32_t& tag = state_.tag[i];
    if (!of_body(tag)) continue;
    tag = on ? tag | tag_fixed : tag & ~tag_fixed;
    Vec3d& v = state_.velocity[i];
    v = on ? Vec3d{} : body.desc.velocity + cross(body.desc.angular_velocity, state_.position[i] - center);
    for (double* x : {&v.x, &v.y, &v.z}) round_to_precision(*x);
  }
  // Only of rigid bodies that move the engine keeps rotations in double; a state is what it is before and after an upload.
  if (on && desc.precision == Precision::single_precision)
    for (std::uint32_t v = body.first_vertex; v < body.first_vertex + body.vertices; ++v) {
      Quat<double>& q = state_.region_rotation[v];
      q = {double(float(q.w)), double(float(q.x)), double(float(q.y)), double(float(q.z))};
    }
  hold_as(b, on);
  dirty_ = measure_ = true;
  added_ = added_ ||
           steps == 0;  // what was added is looked at anew, whether the World was prepared in between or not
}

void WorldImpl::hold_as(std::size_t b, bool on) {
  BodyRecord& body = bodies_[b];
  if (body.desc.motion != Motion::free && body.desc.motion != Motion::rigid) return;
  body.held = body.desc.fixed = on;
  lattice_.bodies[b].motion = motion_of(body, on);
}

/// Before a step of dt: releases bodies whose time has come, within the rounding of sums of steps. Returns which.
std::vector<std::size_t> WorldImpl::let_go_of_bodies(double dt) {
  std::vector<std::size_t> let_go;
  const double now = time + 1e-6 * dt;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    BodyRecord& body = bodies_[b];
    if (!body.held || body.gone || body.desc.held_until > now) continue;
    set_held(b, false);
    let_go.push_back(b);
  }
  return let_go;
}

std::vector<BodyRelease> WorldImpl::releases() const {
  std::vector<BodyRelease> all;
  for (const BodyRecord& b : bodies_)
    all.push_back({b.desc.held_until, b.desc.velocity, b.desc.angular_velocity});
  return all;
}

void WorldImpl::set_releases(const std::vector<BodyRelease>& all) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    SolidDesc& d = bodies_[b].desc;
    d.held_until = all[b].held_until;
    d.velocity = all[b].velocity;
    d.angular_velocity = all[b].angular_velocity;
  }
}

/// Which bodies are held in a state, from the tags of their particles.
std::vector<char> WorldImpl::fixed_in(const core::SceneState& s) const {
  std::vector<char> fixed;
  for (const BodyRecord& b : bodies_)
    fixed.push_back(b.desc.motion == Motion::fixed || b.kinematic() ? 1 : 0);
  for (const std::uint32_t tag : s.tag) {
    const std::uint32_t body = body_of(tag);
    if (!is_solid(tag) || body == 0u || body > bodies_.size() || (tag & tag_fixed) == 0u) continue;
    const Motion motion = bodies_[body - 1u].desc.motion;
    if (motion == Motion::free || motion == Motion::rigid) fixed[body - 1u] = 1;
  }
  return fixed;
}

}  // namespace v0
}  // namespace meltsim
