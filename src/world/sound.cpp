// SPDX-License-Identifier: Apache-2.0
// A sound speed that follows what moves (WorldDesc::follow_sound_speed, physics/sound_speed.hpp): once in 32 sub-steps the
// World reads the largest head; in between, c follows from the last reading and from what the host has set. So c and
// the division of a step into sub-steps follow from states and steps alone, never from when a host looks.
#include <algorithm>
#include <cmath>
#include <utility>

#include "description/nozzle.hpp"
#include "description/validate.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/sound_speed.hpp"
#include "meltsim/physics/surface_tension.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

bool WorldImpl::follows_sound() const { return desc.follow_sound_speed; }

/// c of the next sub-step [m/s].
double WorldImpl::sound_now() const {
  return follows_sound() && sound_.now > 0 ? std::min(sound_.now, sound_speed_) : sound_speed_;
}

/// How much longer the step that springs go by is than the scene's: bodies are as stiff as sound is fast in liquid.
double WorldImpl::spring_stretch() const { return follows_sound() ? sound_speed_ / sound_now() : 1.0; }

/// Largest sub-step at the sound speed that is planned for [s].
double WorldImpl::largest_substep() const {
  if (!follows_sound() || !(sound_.level > 0)) return static_dt_;
  return std::min(rest_dt_, sound_dt_ * (sound_speed_ / std::min(sound_.level, sound_speed_)));
}

/// Along which sound passes [m].
double WorldImpl::scene_length() const { return std::max(fall_height(), 8 * core::support_of(desc)); }

/// Head that the host gives to what it moves or lets in during [from, until) [m^2/s^2].
double WorldImpl::driven_head(double from, double until) const {
  const double g = length(desc.gravity), low = lowest_place();
  const Vec3d up = g > 0 ? desc.gravity * (-1.0 / g) : Vec3d{};
  double head = 0, moved = carried_speed_;
  for (const EmitterRecord& e : emitters_) {
    if (e.reservoir()) head = std::max(head, g * (dot(e.desc.center, up) + 0.5 * e.desc.height - low));
    const std::uint64_t next = layers_due(e, from);
    if (!e.on || next >= e.layers || due(e, next) >= until) continue;
    const double height = dot(e.desc.center, up) + core::nozzle_reach_across(e.desc) - low;
    head = std::max(head, 0.5 * e.desc.speed * e.desc.speed + g * std::max(0.0, height));
  }
  for (std::size_t f = 0; desc.domain.bounded && f < 6; ++f)
    moved = std::max({moved, length(desc.domain.velocity[f]), desc.domain.outlets[f].speed.value_or(0)});
  return std::max(head, std::max(0.0, sound_.head)) + 0.5 * moved * moved;
}

/// Waits. Takes in the work on compressed liquid since the last look. Not while the host captures the stream into a graph.
void WorldImpl::look_at_sound() {
  if (capacity_ == 0 || engine->host_captures()) return;
  const core::SoundLook seen = engine->look();
  const double g = length(desc.gravity);
  take_sound_work();
  sound_.elastic = seen.elastic;
  sound_.head = seen.head > -1e299 ? seen.head - dot(desc.gravity, origin_) - g * lowest_place() : 0;
  look_now_ = false;
}

/// Waits. Snapshots and saved states hold what has been done so far.
void WorldImpl::take_sound_work() {
  if (follows_sound()) sound_.work += engine->take_sound_work();
}

/// Sub-steps until the next reading of the head.
int WorldImpl::part_length() const {
  return static_cast<int>(physics::sound_interval - steps % physics::sound_interval);
}

/// Ahead of a part of a step, of which `rest` seconds are left: where c is to go, and what sub-steps are to be made for.
void WorldImpl::plan_sound(double rest) {
  const bool changed = look_now_;  // by the host: what it added or pushed is there at once
  if (look_now_) look_at_sound();
  const double e = desc.density_error > 0 ? desc.density_error : physics::usual_density_error;
  const double layer = length(desc.gravity) * desc.spacing, scene = scene_length();
  double least = physics::least_sound_share * sound_speed_;
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (materials[i].surface_tension > 0 && used(i))
      least = std::max(
          least, physics::tension_sound_speed(materials[i].surface_tension, least_density(i), desc.spacing));
  // Force fields do not go by a head.
  const bool held = sound_.elastic != 0 || any_field();
  if (held) least = sound_speed_;
  const auto asked = [&](double head) {
    return std::min(sound_speed_, std::max(least, physics::sound_speed_of_head(head + layer, e)));
  };
  if (!(sound_.now > 0)) sound_.now = asked(driven_head(time, time + rest));
  sound_.now = std::min(std::max(sound_.now, least), sound_speed_);  // the scene's may have grown
  // What a nozzle lets in or a body that the host moves pushes is there at once: c is then there, too.
  const double longest = std::min(rest, physics::sound_interval * sound_dt_ / physics::least_sound_share);
  const double driven = driven_head(time, time + longest);
  if (driven > std::max(0.0, sound_.head) || held || changed)
    sound_.now = std::max(sound_.now, asked(driven));
  const double rise = physics::sound_rise * scene / sound_.now;
  sound_target_ = asked(driven_head(time, time + longest + rise));
  // The largest c of the part: what is reached while it rises.
  double reached = sound_.now;
  const double dt = sound_dt_ * sound_speed_ / sound_.now;
  for (int k = part_length(); k > 0 && reached < sound_target_; --k)
    reached = physics::approach(reached, sound_target_, dt, scene);
  sound_.level = physics::sound_level_of(reached, sound_speed_);
}

/// Sub-steps are made for the scene's sound speed again; false: they were.
bool WorldImpl::at_full_sound() {
  if (!follows_sound() || sound_.level >= sound_speed_) return false;
  sound_.level = sound_speed_;
  return true;
}

/// Ahead of a sub-step: c on its way.
void WorldImpl::go_on_with_sound(double dt) {
  sound_.now = std::min(sound_.level, physics::approach(sound_.now, sound_target_, dt, scene_length()));
  const double told = std::exchange(sound_.told, sound_now());
  if (told != sound_.told)
    engine->set_sound_speed(sound_.told, told > 0 ? sound_.told * sound_.told - told * told : 0.0);
}

/// The engine gets c as it was, after it was given the scene's.
void WorldImpl::tell_sound() {
  if (follows_sound() && sound_.told > 0) engine->set_sound_speed(sound_.told, 0);
}

}  // namespace v0
}  // namespace meltsim
