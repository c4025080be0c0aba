// SPDX-License-Identifier: Apache-2.0
// Adding liquid, and taking out liquid and bodies, while the World runs: on the backend, where they are, without the scene
// being uploaded anew. What it comes to is what an upload comes to, to the bit.
#include <algorithm>
#include <tuple>

#include "description/point_grid.hpp"
#include "description/validate.hpp"
#include "engine/held.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

bool WorldImpl::edits_in_place() const {
  return takes_new_plan() && origin_set_ && !engine->host_captures() && laid_out_.empty();
}

/// Whether the plan has what these contents need: where nothing is dissolved as yet, there are no channels for them.
bool WorldImpl::holds_contents(const Contents& contents) const {
  return species_used_ || std::all_of(contents.begin(), contents.end(), [](double c) { return c == 0; });
}

/// Something with contents of its own has come. Whether all hold the same is not measured: where they do, an exchange changes
/// no bit.
void WorldImpl::mix() {
  if (!species_used_ || !contents_level_) return;
  contents_level_ = false;
  plan_changed_ = true;
}

/// Fills found_. false: the World has halted meanwhile.
Result<bool> WorldImpl::find(Vec3d low, Vec3d high, core::WorldStatus& status) {
  auto s = engine->find(low, high, found_);
  if (!s) return s.error();
  status = *s;
  note_halt(status, engine->fault());
  status.particles = static_cast<std::uint32_t>(born_);
  return status.halted == 0 && !halted_;
}

/// Whether neighbours of so many particles would be found as they are.
bool WorldImpl::same_search(std::uint64_t particles) const {
  const double support = core::support_of(desc);
  const core::SearchChoice other = core::choose_search(desc, support, particles);
  return other.search == search_.search && other.facts == search_.facts &&
         core::packed_reach(desc.domain, support, particles) ==
             core::packed_reach(desc.domain, support, searched_);
}

/// What the plan holds of the scene, beside facts.
WorldImpl::Derived WorldImpl::derived() const {
  return std::make_tuple(spring_dt_, static_dt_, rest_dt_, sound_dt_, heat_lambda_, viscous_lambda_,
                         solute_lambda_, diffuses_, strong_pull_, contrast_, one_liquid_, changes_phase_);
}

void WorldImpl::half_changed() noexcept {
  halted_ = true;
  try {
    halt_reason_ = "memory ran out while something was added or removed, which is half done";
  } catch (...) {  // the call that fails says it
  }
}

/// As after an upload: of what lies on the backend no copy, view or saved state holds any more, and the plan follows.
void WorldImpl::edited_in_place() { edited_in_place(derived()); }
void WorldImpl::edited_in_place(const Derived& before) {
  const Change change(*this);
  weigh_materials();
  derive_limits();
  look_for_refusal();
  places_.reset();
  state_stale_ = true;
  noted_step_ = steps + 1;
  lose_saved_states();
  plan_changed_ = plan_changed_ || derived() != before || facts() != facts_;
}

/// False: they cannot be read now. range: of temperatures that are level with one that is added, empty where they are not level.
bool WorldImpl::stays_level(double temperature, std::uint32_t idle, std::optional<LevelRange>& range) {
  range.reset();
  if ((idle & core::idle_level) == 0u) return true;
  if (!level_) {
    core::ReadParts parts;
    parts.sums = true;
    const auto s = read_now(parts);
    if (!s) return false;
    LevelRange there;
    if (s->extents.coldest <= s->extents.hottest) {
      there.see(s->extents.coldest);
      there.see(s->extents.hottest);
    }
    for (const EmitterRecord& e : emitters_)
      if (emits(e)) there.see(e.desc.temperature);
    level_ = there;
  }
  range = *level_;
  range->see(temperature);
  if (!is_level(*range)) range.reset();
  return true;
}

/// Something of a temperature will come: heat flows then, unless that is level with it. False: that takes an upload.
bool WorldImpl::comes_in_place(double temperature, const core::WorldStatus& status) {
  std::optional<LevelRange> range;
  if (!stays_level(temperature, status.heat_idle, range)) return false;
  if ((status.heat_idle & core::idle_level) != 0u && !range && !engine->append({}, false, core::none))
    return false;
  level_ = range;
  state_.heat_level = range.has_value();
  return true;
}

/// Whether a new plan is enough for what is added now, beside particles.
bool WorldImpl::takes_new_plan() const { return !dirty_ && !halted_ && steps > 0 && capacity_ != 0; }

/// What is within same_place of particles that are to come, in found_. Whether the World runs.
Result<bool> WorldImpl::find_around(const std::vector<Vec3d>& positions, Vec3d origin,
                                    core::WorldStatus& status) {
  Vec3d low = positions.front() - origin, high = low;
  for (const Vec3d& p : positions) {
    const Vec3d x = p - origin;
    low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
  }
  const double reach = core::same_place * desc.spacing;
  const Vec3d margin{reach, reach, reach};
  return find(low - margin, high + margin, status);
}

/// Liquid `more` of material m is on the backend. Whether its plan may be another now.
bool WorldImpl::liquid_joined(const core::SceneState& more, std::uint32_t m,
                              const physics::MaterialRow<double>& row) {
  const std::uint64_t n = more.position.size();
  born_ += n;
  census_.fluid = true;
  census_.supercooled =
      census_.supercooled || physics::freezes(row, more.enthalpy.front() / more.mass.front());
  const bool first = liquid_used_[m] == 0u || largest_density(m) > densest_added_;
  note_liquid(m);
  densest_added_ = std::max(densest_added_, largest_density(m));
  const double g = length(desc.gravity);
  const Vec3d up = g > 0 ? desc.gravity * (-1.0 / g) : Vec3d{};
  for (std::size_t k = 0; k < n; ++k) {
    see(more.position[k] + origin_, up);
    seen_.speed = std::max(seen_.speed, length(more.velocity[k]));
  }
  seen_particles_ = static_cast<std::size_t>(born_);
  const double sound = sound_speed_;
  derive_sound_speed();
  look_now_ = true;
  return first || sound_speed_ != sound;
}

/// Empty where it takes an upload: no room in reserve, another search, temperatures that are to be measured.
std::optional<Result<std::uint64_t>> WorldImpl::add_in_place(const FluidDesc& f, const Contents& contents,
                                                             const std::vector<Vec3d>& positions,
                                                             Vec3d origin, Vec3d cell) {
  const std::uint64_t coming = planned_emission();
  if (!edits_in_place() || born_ + coming >= capacity_ || !holds_contents(contents)) return std::nullopt;
  const std::uint32_t m = f.material.index;
  const physics::MaterialRow<double> row = material_rows()[m];
  const double h = physics::enthalpy_of(row, f.temperature);
  const double density = mixed_density(physics::rest_density(row, h), contents);
  if (Status s = check_numbers("fluid: ", materials[m], density, h, f.velocity); !s) return s.error();
  core::WorldStatus status;
  const auto runs = find_around(positions, origin, status);
  if (!runs) return runs.error();
  if (!*runs) return std::nullopt;
  core::PointGrid taken(core::same_place * desc.spacing);
  for (const core::FoundParticle& p : found_) taken.add(p.position, p.id);
  core::SceneState more;
  for (const Vec3d& p : positions) {
    const Vec3d x = p - origin;
    if (!taken.near(x, [](std::uint32_t) { return true; }))
      append(more, x, f.velocity, density, h, m, core::none, contents, cell);
  }
  const std::uint64_t n = more.position.size();
  if (n == 0) return all_taken(positions.size());
  const std::uint64_t total = born_ + n + coming;
  if (total > capacity_ || !same_search(total)) return std::nullopt;
  std::optional<LevelRange> range;
  const double added = physics::temperature_of(row, more.enthalpy.front() / more.mass.front());
  if (!stays_level(added, status.heat_idle, range)) return std::nullopt;
  const Change change(*this);
  if (Status s = engine->append(more, range.has_value(), core::none); !s) return s.error();
  level_ = range;
  state_.heat_level = range.has_value();
  searched_ = total;
  const bool another_plan = liquid_joined(more, m, row);
  mix();
  edited_in_place();
  plan_changed_ = plan_changed_ || another_plan;
  return n;
}

/// A body that was added, of `particles`, is on the backend; `displaced` liquid has left.
void WorldImpl::body_joined(std::uint32_t index, const core::SceneState& particles, std::uint64_t displaced,
                            core::WorldStatus status, const physics::MaterialRow<double>& row) {
  const BodyRecord& body = bodies_[index];
  const std::uint64_t n = particles.position.size(), total = born_ + n + planned_emission();
  born_ += n;
  searched_ = total;
  status.particles = static_cast<std::uint32_t>(born_);
  status.removed += static_cast<std::int64_t>(displaced);
  census_.live.resize(bodies_.size(), 0);
  census_.live[index] = 1;
  recount(status);
  census_.molten = census_.molten || (row.melts != 0u && leaves_lattice(body.desc.material.index) &&
                                      physics::liquid_fraction(
                                          row, particles.enthalpy.front() / particles.mass.front()) >= 1.0);
  for (std::size_t v = body.first_vertex; v < body.first_vertex + n; ++v)
    census_.apart = census_.apart || state_.vertex_piece[v] != body.first_vertex;
  const double g = length(desc.gravity);
  const Vec3d up = g > 0 ? desc.gravity * (-1.0 / g) : Vec3d{};
  for (std::size_t k = 0; k < n; ++k) {
    see(particles.position[k] + origin_, up);
    seen_.speed = std::max(seen_.speed, length(particles.velocity[k]));
  }
  seen_.speed = std::max(seen_.speed, body.desc.max_speed);
  seen_particles_ = static_cast<std::size_t>(born_);
  seen_bodies_ = bodies_.size();
  const double sound = sound_speed_;
  derive_sound_speed();
  look_now_ = true;
  mix();
  plan_changed_ = plan_changed_ || sound_speed_ != sound;
}

std::optional<Status> WorldImpl::remove_in_place(std::uint32_t index) {
  if (!edits_in_place()) return std::nullopt;
  core::WorldStatus status;
  const auto runs = find({1, 1, 1}, {}, status);
  if (!runs) return Status{runs.error()};
  if (!*runs) return std::nullopt;
  BodyRecord& body = bodies_[index];
  const Change change(*this);
  const auto taken = engine->take_body(index, body.first_vertex, body.vertices_in_lattice);
  if (!taken) return Status{taken.error()};
  body.taken = *taken;
  forget_body(index);
  if (index < census_.live.size()) census_.live[index] = 0;
  if (level_ && !level_->equal()) level_.reset();  // the rest may be closer together
  status.removed += static_cast<std::int64_t>(*taken);
  recount(status);
  edited_in_place();
  return Status{};
}

std::optional<Result<std::uint64_t>> WorldImpl::remove_liquid_in_place(const Shape& shape) {
  if (!edits_in_place()) return std::nullopt;
  const Box box = shape.bounds();
  core::WorldStatus status;
  const auto runs = find(box.min - origin_, box.max - origin_, status);
  if (!runs) return runs.error();
  if (!*runs) return std::nullopt;
  found_.erase(std::remove_if(found_.begin(), found_.end(),
                              [&](const core::FoundParticle& p) {
                                return !is_fluid(p.tag) || !shape.contains(p.position + origin_);
                              }),
               found_.end());
  if (found_.empty()) return std::uint64_t{0};
  const Change change(*this);
  if (Status s = engine->take_out(found_); !s) return s.error();
  const std::uint64_t n = found_.size();
  if (level_ && !level_->equal()) level_.reset();
  status.removed += static_cast<std::int64_t>(n);
  recount(status);
  edited_in_place();
  return n;
}

}  // namespace v0
}  // namespace meltsim
