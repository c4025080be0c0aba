// SPDX-License-Identifier: Apache-2.0
// Whether there is memory for what is to come: by the channels that it will take, which the engine knows.
#include <algorithm>
#include <string>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/trial.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

/// Whether the backend has memory for so many particles in a scene of these facts, as an upload will ask; solutes: with what is
/// dissolved in them.
bool WorldImpl::has_memory_for(std::uint64_t particles, core::FactSet facts, bool solutes) const {
  const double support = core::support_of(desc);
  core::SceneConstants c;  // what sizes follow from
  c.spacing = desc.spacing;
  c.support = support;
  c.domain = desc.domain;
  if (solutes) c.species.resize(species_.size());
  if (event_watch_) {
    c.event_kinds = event_watch_->kinds;
    c.event_capacity = event_watch_->capacity;
  }
  const std::uint64_t room = std::min<std::uint64_t>(particles + desc.reserved_particles, core::none - 1);
  facts =
      (facts & ~search_.facts) | core::fact_particles | core::choose_search(desc, support, particles).facts;
  core::EngineSetup setup = setup_of(facts);
  setup.searched = particles;
  setup.particle_capacity = static_cast<std::uint32_t>(room);
  std::uint64_t there = engine->free_bytes();
  for (int field = 0; field < core::field_count; ++field) there += engine->channel_bytes(field);
  return engine->bytes_needed(c, lattice_, setup) <= there;
}

/// Whether there is memory for all that an emitter that is to come will bring, in the scene as it is with it. After find_solids().
Status WorldImpl::check_memory(const EmitterRecord& e, const std::string& what) {
  const std::uint64_t there = dirty_ ? state_.position.size() : born_;
  const Trial trial(emitters_, liquid_there_, liquid_used_, solid_used_, densest_added_, species_used_,
                    contents_level_, state_.heat_level, level_, census_, seen_, seen_particles_,
                    seen_emitters_, seen_bodies_, added_, look_now_, sound_speed_, one_liquid_, contrast_,
                    may_melt_, spring_dt_, spring_share_, static_dt_, rest_dt_, sound_dt_, heat_lambda_,
                    viscous_lambda_, viscous_dt_, solute_lambda_, diffuses_, strong_pull_, changes_phase_,
                    rows_);
  emitters_.push_back(e);
  added_ = true;
  if (dirty_) take_census();
  look_at_added();
  species_used_ = species_used_ || species_present();
  contents_level_ = dirty_ ? contents_level() : contents_level_ && !species_used_;
  if (dirty_ && (steps == 0 || state_.heat_level)) state_.heat_level = temperatures_level();
  if (!dirty_ && state_.heat_level) {  // where they are not known, heat may flow
    state_.heat_level = level_.has_value();
    if (level_) level_->see(e.desc.temperature);
    state_.heat_level = state_.heat_level && is_level(*level_);
  }
  if (dirty_) find_materials();
  if (emits(e)) note_liquid(e.desc.material.index);
  weigh_materials();
  derive_limits();
  const std::uint64_t coming = planned_emission() + e.ids;
  if (has_memory_for(there + coming, facts(), species_used_)) return {};
  return Error{ErrorCode::out_of_memory,
               core::text(what, e.desc.max_particles != 0 || e.ids != 0 ? "max_particles: " : "until: ",
                          to_come(e) + e.ids, " particles are more than there is memory for; emit fewer")};
}

}  // namespace v0
}  // namespace meltsim
