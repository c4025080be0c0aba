// SPDX-License-Identifier: Apache-2.0
// Saving states in the backend's memory, and restoring them.
#include <utility>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

Status WorldImpl::check_slot(const char* call, int slot) const {
  if (slot >= 0 && slot < most_saved_states) return {};
  return invalid(call, ": slot: must be 0 to ", most_saved_states - 1, ", got ", slot);
}

Status WorldImpl::save_state(int slot) {
  if (Status s = check_slot("save_state", slot); !s) return s;
  if (halted_)
    return Error{ErrorCode::halted,
                 "save_state: the World halted: " + halt_reason_ + "; go back to a state saved before"};
  if (Status s = prepare(); !s) return s;
  if (plan_changed_ && capacity_ != 0)  // the next step's new plan would lose it
    if (Status s = adapt(); !s) return s;
  SavedState v;
  v.layout = layout_;
  v.restored = restored_;
  v.time = time;
  v.substep = substep_;
  v.last_max_speed = last_max_speed_;
  v.plan_until = plan_until_;
  v.heat_owed = heat_owed_;
  v.steps = steps;
  v.born = born_;
  v.noted_step = noted_step_;
  v.heat_level = state_.heat_level;
  v.could_melt = could_melt_;
  v.was_emitting = was_emitting_;
  v.plan_changed = plan_changed_;
  take_sound_work();
  v.sound = sound_;
  v.look_now = look_now_;
  v.emitters = emitters_;
  v.motion = state_.motion;
  v.mesh_points = state_.mesh_points;
  v.releases = releases();
  v.census = census_;
  SavedState& to = saved_[static_cast<std::size_t>(slot)];
  to = {};
  if (Status saved = engine->save(slot); !saved) return saved;
  to = std::move(v);
  return {};
}

Status WorldImpl::check_saved(const SavedState& v, int slot) const {
  if (v.layout == 0)
    return invalid("load_state: slot: nothing is saved under ", slot,
                   "; call save_state() first, of a World that has not halted");
  if (dirty_ || v.layout != layout_)
    return invalid(
        "load_state: slot: what was saved under ", slot,
        " is lost: something was added, removed, held, let go, settled or restored, forces or events began "
        "to be watched, sound was made faster (set_velocity beyond max_speed, set_gravity, set_force_field, "
        "set_emitter), a material "
        "(set_material) or the plan changed; save again, or restore a snapshot");
  return {};
}

/// The World has gone back: forgets what was asked for and what was found since.
void WorldImpl::forget_what_followed() {
  for (auto& m : motions_) m.reset();
  for (auto& p : proxies_) p.reset();
  for (auto& m : meshes_) m.set = false;
  halted_ = false;
  halt_step_ = 0;
  halt_reason_.clear();
  carried_ = {};
  places_.reset();
  holes_.clear();
  level_.reset();
  ++restored_;
}

Status WorldImpl::load_state(int slot) {
  if (Status s = check_slot("load_state", slot); !s) return s;
  const SavedState& v = saved_[static_cast<std::size_t>(slot)];
  if (Status s = check_saved(v, slot); !s) return s;
  auto emitters = v.emitters;  // from here on nothing fails
  auto motion = v.motion;
  auto mesh_points = v.mesh_points;
  Census census = v.census;
  collect_samples();
  drop_samples_from(v.time);
  engine->load(slot);
  laid_out_ = {};
  pressed_ = true;
  time = v.time;
  steps = v.steps;
  substep_ = v.substep;
  last_max_speed_ = v.last_max_speed;
  plan_until_ = v.plan_until;
  heat_owed_ = v.heat_owed;
  born_ = v.born;
  noted_step_ = v.noted_step;
  state_.heat_level = v.heat_level;
  could_melt_ = v.could_melt;
  was_emitting_ = v.was_emitting;
  plan_changed_ = v.plan_changed;
  take_sound_work();  // of what is undone
  sound_ = v.sound;
  look_now_ = v.look_now;
  tell_sound();
  emitters_ = std::move(emitters);
  state_.motion = std::move(motion);
  state_.mesh_points = std::move(mesh_points);
  census_ = std::move(census);
  set_releases(v.releases);
  forget_what_followed();
  state_stale_ = true;
  plan_changed_ = plan_changed_ || facts() != facts_;  // settings may have changed since it was saved
  return {};
}

}  // namespace v0
}  // namespace meltsim
