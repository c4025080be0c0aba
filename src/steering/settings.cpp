// SPDX-License-Identifier: Apache-2.0
// Settings that a host changes between steps: gravity, heat of walls and regions, the time scale of heat. They travel with the
// next sub-step's parameters.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "description/nozzle.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Checks a change by checking the whole description with it.
Status checked(const char* call, const WorldDesc& desc) {
  Status s = core::validate(desc);
  if (!s) return Error{s.error().code, std::string(call) + ": " + s.error().message};
  return s;
}
}  // namespace

core::Surroundings WorldImpl::surroundings(double at) const {
  core::Surroundings s;
  s.gravity = desc.gravity;
  s.free_surface = core::condition_at(desc.heat.free_surface, at);
  s.uneven_conductors = uneven_conductors();
  for (std::size_t f = 0; f < 6; ++f)
    if (desc.domain.bounded) s.wall_heat[f] = core::condition_at(desc.domain.heat[f], at);
  return s;
}

/// To the engine, which holds the scene; and another plan where the change asks for one.
void WorldImpl::surround() {
  if (dirty_) return;  // prepare() does it
  engine->surround(surroundings(time));
  plan_changed_ = plan_changed_ || facts() != facts_;
}

/// Height of all that was added, along another gravity: that of its box.
void WorldImpl::see_along(Vec3d gravity) {
  const double g = length(gravity);
  if (!(g > 0) || !(seen_.high >= seen_.low)) return;
  const Vec3d up = gravity * (-1 / g);
  seen_.low = infinity;
  seen_.high = -infinity;
  for (int corner = 0; corner < 8; ++corner) {
    const double at = dot(up, {corner & 1 ? seen_.min.x : seen_.max.x, corner & 2 ? seen_.min.y : seen_.max.y,
                               corner & 4 ? seen_.min.z : seen_.max.z});
    seen_.low = std::min(seen_.low, at);
    seen_.high = std::max(seen_.high, at);
  }
}

Status WorldImpl::set_gravity(Vec3d gravity) {
  WorldDesc changed = desc;
  changed.gravity = gravity;
  if (Status s = checked("set_gravity", changed); !s) return s;
  const double g = length(gravity), before = length(desc.gravity);
  // The same direction, to rounding: heights along it stand.
  const bool turned = !(g > 0 && before > 0 && dot(gravity, desc.gravity) >= g * before * (1 - 1e-12));
  for (const EmitterRecord& e : emitters_)
    if (turned && e.reservoir())
      return invalid("set_gravity: gravity: emitter \"", e.desc.name,
                     "\" has a level, which needs gravity along ", desc.gravity, ", got ", gravity,
                     "; keep its direction");
  see_added();
  desc.gravity = gravity;
  if (steps == 0) {
    see_all_anew();
    return {};
  }
  const double sound = sound_speed_;
  look_now_ = true;
  if (turned) see_along(gravity);
  if (sound > 0) derive_sound_speed();
  if (turned && std::any_of(probes_.begin(), probes_.end(),
                            [](const ProbeRecord& p) { return p.desc.kind == ProbeKind::level; }))
    probes_stale_ = true;
  if (dirty_) return {};
  derive_limits();
  surround();
  if (sound_speed_ != sound) plan_changed_ = true;
  return {};
}

namespace {
bool same(const std::vector<PropertyPoint>& a, const std::vector<PropertyPoint>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const PropertyPoint& p, const PropertyPoint& q) {
                      return p.temperature == q.temperature && p.value == q.value;
                    });
}

/// Error of the first member that must not change and does.
Status unchanged(const MaterialDesc& was, const MaterialDesc& is) {
  const std::string p = "set_material: material \"" + was.name + "\": ";
  const auto refuse = [&p](const char* field, const std::string& numbers) {
    return invalid(
        p, field, ": must stay as it is", numbers,
        "; what its particles hold is counted by it. Add another material, or build another World");
  };
  const struct {
    const char* field;
    double was, is;
  } numbers[] = {{"density", was.density, is.density},
                 {"heat_capacity", was.heat_capacity, is.heat_capacity},
                 {"melting_point", was.melting_point, is.melting_point},
                 {"melting_range", was.melting_range, is.melting_range},
                 {"latent_heat", was.latent_heat, is.latent_heat},
                 {"solubility", was.solubility, is.solubility},
                 {"heat_of_solution", was.heat_of_solution, is.heat_of_solution},
                 {"region_half_width", double(was.region_half_width), double(is.region_half_width)}};
  for (const auto& n : numbers)
    if (n.was != n.is) return refuse(n.field, core::text(", ", n.was, ", got ", n.is));
  if (was.name != is.name) return refuse("name", ", got \"" + is.name + "\"");
  if (was.freezes != is.freezes) return refuse("freezes", "");
  if (!(was.melts_into == is.melts_into)) return refuse("melts_into", "");
  if (!(was.dissolves_in == is.dissolves_in)) return refuse("dissolves_in", "");
  if (!same(was.heat_capacity_points, is.heat_capacity_points)) return refuse("heat_capacity_points", "");
  if (!same(was.density_points, is.density_points)) return refuse("density_points", "");
  if (!same(was.solubility_points, is.solubility_points)) return refuse("solubility_points", "");
  return {};
}
}  // namespace

Status WorldImpl::set_material(MaterialId id, const MaterialDesc& m) {
  if (!valid(id))
    return invalid("set_material: material: no material of this World has index ", id.index,
                   " and generation ", id.generation, "; pass what add_material() of this World returned");
  if (Status s = core::validate(m); !s) return Error{s.error().code, "set_material: " + s.error().message};
  if (Status s = unchanged(materials[id.index], m); !s) return s;
  const MaterialDesc before = std::exchange(materials[id.index], m);
  const auto derive = [this] {
    properties_ = material_properties();
    if (!rows_.empty()) rows_ = material_rows();  // they point to properties
  };
  const auto take_back = [&] {
    materials[id.index] = before;
    derive();
  };
  try {
    derive();
    if (Status s = check_curves(); !s) {
      take_back();
      return Error{s.error().code, "set_material: " + s.error().message};
    }
  } catch (...) {
    take_back();
    throw;
  }
  const bool tension = m.surface_tension != before.surface_tension;  // sound may have to be faster
  if (dirty_ && tension) pass_over_particles(), added_ = true;
  if (dirty_) return {};  // prepare() goes by it
  if (tension) {
    look_now_ = true;
    derive_sound_anew();
    if (dirty_) return {};
  }
  derive_limits();  // stable_dt() tells what the next step will be
  look_for_refusal();
  plan_changed_ = true;
  ++layout_;  // a state saved before would come back with the plan of then
  return {};
}

Status WorldImpl::set_heat_time_scale(double scale) {
  WorldDesc changed = desc;
  changed.heat.time_scale = scale;
  if (Status s = checked("set_heat_time_scale", changed); !s) return s;
  for (const MaterialDesc& m : materials)
    if (Status s = check_expansion(m, scale); !s) return s;
  desc.heat.time_scale = scale;
  surround();
  if (std::any_of(probes_.begin(), probes_.end(),
                  [](const ProbeRecord& p) { return p.desc.kind == ProbeKind::heat; }))
    probes_stale_ = true;
  return {};
}

Status WorldImpl::set_wall_heat(int face, const SurfaceHeatDesc& heat) {
  if (face < 0 || face > 5)
    return invalid("set_wall_heat: face: must be 0..5, in the order -x, +x, -y, +y, -z, +z, got ", face);
  WorldDesc changed = desc;
  changed.domain.heat[static_cast<std::size_t>(face)] = heat;
  if (Status s = checked("set_wall_heat", changed); !s) return s;
  desc.domain.heat[static_cast<std::size_t>(face)] = heat;
  surround();
  return {};
}

Status WorldImpl::set_free_surface_heat(const SurfaceHeatDesc& heat) {
  WorldDesc changed = desc;
  changed.heat.free_surface = heat;
  if (Status s = checked("set_free_surface_heat", changed); !s) return s;
  desc.heat.free_surface = heat;
  surround();
  return {};
}

Status WorldImpl::set_body_heat(BodyId id, const SurfaceHeatDesc& heat, double source) {
  if (Status s = check_body("set_body_heat", id); !s) return s;
  BodyRecord& body = bodies_[id.index];
  const std::string what = "set_body_heat: body \"" + body.desc.name + "\": ";
  if (Status s = core::validate(heat, desc.heat.model, what + "surface."); !s) return s;
  if (!std::isfinite(source)) return invalid(what, "source: must be finite W/m^3, got ", source);
  if (source != 0 && desc.heat.model != HeatModel::enthalpy)
    return invalid(what,
                   "source: needs heat.model enthalpy; the others know no heat, only temperatures of pairs");
  const bool planned = takes_new_plan(), there = bodies_heat();
  if (!planned) fetch_state();
  body.desc.surface = heat;
  body.desc.heat_source = source;
  if (!planned) dirty_ = true;
  else if (there) engine->set_body_heat(id.index, {core::condition_at(heat, time), source});
  plan_changed_ = plan_changed_ || (planned && (!there || facts() != facts_));
  return {};
}

/// Whether the engine has heat of bodies: a surface or a source of any of them.
bool WorldImpl::bodies_heat() const {
  return std::any_of(bodies_.begin(), bodies_.end(), [](const BodyRecord& b) {
    return b.desc.heat_source != 0 ||
           core::condition_of(b.desc.surface).kind != physics::SurfaceHeat::insulated;
  });
}

/// What walls, the free surface and bodies give and take in a sub-step, where that depends on the time.
void WorldImpl::follow_heat(double at) {
  const auto& walls = desc.domain.heat;
  if (core::is_timed(desc.heat.free_surface) || std::any_of(walls.begin(), walls.end(), core::is_timed))
    engine->surround(surroundings(at));
  for (const std::uint32_t b : timed_bodies_)
    engine->set_body_heat(b, {core::condition_at(bodies_[b].desc.surface, at), bodies_[b].desc.heat_source});
}

/// Once per step: sub-steps are too short to look at every body.
void WorldImpl::find_timed_bodies() {
  timed_bodies_.clear();
  for (std::uint32_t b = 0; b < bodies_.size(); ++b)
    if (!bodies_[b].gone && core::is_timed(bodies_[b].desc.surface)) timed_bodies_.push_back(b);
}

Status WorldImpl::set_heat_region(HeatRegionId id, const std::optional<double>& temperature, double source) {
  HeatRegionRecord* const region = region_of(id);
  if (region == nullptr) return no_such_region("set_heat_region", id);
  HeatRegionDesc changed = region->desc;
  changed.temperature = temperature;
  changed.source =
      source == 0 && !temperature
          ? 1
          : source;  // a heater may be turned down to 0, where one that is added has to do something
  if (Status s = core::validate(changed, desc.heat.model); !s)
    return Error{s.error().code, "set_heat_region: " + s.error().message};
  region->desc.temperature = temperature;
  region->desc.source = source;
  if (dirty_ || !region->acts) return {};  // rows are made of the description when it begins to act
  engine->set_heat_region(region_row(*region), temperature.has_value(), temperature.value_or(0), source);
  return {};
}

Status WorldImpl::check_pushed(const char* call, BodyId id) const {
  if (Status s = check_body(call, id); !s) return s;
  if (bodies_[id.index].proxy())
    return invalid(call, ": body \"", bodies_[id.index].desc.name,
                   "\": motion: a proxy moves as its host says; use set_proxy");
  if (bodies_[id.index].held)
    return invalid(call, ": body \"", bodies_[id.index].desc.name,
                   "\": is held where it is; let it go with hold(body, false) first");
  if (bodies_[id.index].desc.fixed)
    return invalid(
        call, ": body \"", bodies_[id.index].desc.name,
        "\": motion: only a free or rigid body can be pushed; ",
        bodies_[id.index].kinematic() ? "use set_motion" : "build it with SolidDesc::motion free or rigid");
  return {};
}

Status WorldImpl::push(const char* call, const core::PushArguments& a) {
  if (halted_)
    return Error{ErrorCode::halted,
                 core::text(call, ": the World halted: ", halt_reason_, "; restore a snapshot to go on")};
  if (Status s = prepare(); !s) return s;
  if (plan_changed_ && (facts_ & core::fact_mobile) == 0)  // nothing could move as yet
    if (Status s = adapt(); !s) return s;
  engine->push(a);
  look_now_ = true;
  state_stale_ = true;
  return {};
}

Status WorldImpl::set_velocity(BodyId id, Vec3d velocity, Vec3d angular_velocity) {
  if (Status s = check_pushed("set_velocity", id); !s) return s;
  const BodyRecord& body = bodies_[id.index];
  const std::string what = "set_velocity: body \"" + body.desc.name + "\": ";
  if (!finite(velocity)) return invalid(what, "velocity: must be finite, got ", velocity);
  if (!finite(angular_velocity))
    return invalid(what, "angular_velocity: must be finite, got ", angular_velocity);
  const double fastest = length(velocity) + length(angular_velocity) * body.reach;
  if (Status s = check_numbers(what, materials[body.desc.material.index],
                               materials[body.desc.material.index].density, 0, {fastest, 0, 0});
      !s)
    return s;
  if (Status s = push("set_velocity", {id.index, body.first_vertex, true, velocity, angular_velocity}); !s)
    return s;
  see_speed(fastest);
  return {};
}

/// A speed that something moves at: it counts like things added at that speed.
void WorldImpl::see_speed(double speed) {
  if (!(speed > seen_.speed)) return;
  seen_.speed = speed;
  const double sound = sound_speed_;
  if (sound > 0) derive_sound_anew();
  if (dirty_) return;
  derive_limits();
  if (sound_speed_ != sound) plan_changed_ = true;
}

Status WorldImpl::apply_impulse(BodyId id, Vec3d impulse, Vec3d angular_impulse) {
  if (Status s = check_pushed("apply_impulse", id); !s) return s;
  const BodyRecord& body = bodies_[id.index];
  const std::string what = "apply_impulse: body \"" + body.desc.name + "\": ";
  const double density = materials[body.desc.material.index].density;
  const double particle = density * desc.spacing * desc.spacing * desc.spacing;
  // The whole impulse on one particle must still give a representable speed.
  const auto check = [&](const char* field, Vec3d v, double by) -> Status {
    if (!finite(v)) return invalid(what, field, ": must be finite, got ", v);
    return check_numbers(what + field + ": ", materials[body.desc.material.index], density, 0,
                         {length(v) / by, 0, 0});
  };
  if (Status s = check("impulse", impulse, particle); !s) return s;
  if (Status s = check("angular_impulse", angular_impulse, particle * desc.spacing); !s) return s;
  return push("apply_impulse", {id.index, body.first_vertex, false, impulse, angular_impulse});
}

/// Whether there is memory for what a nozzle brings that is `now` instead of `before`: without it no step, and no other setting, would
/// be possible any more.
Status WorldImpl::check_emission(const std::string& what, const EmitterRecord& now,
                                 const EmitterRecord& before) const {
  const std::uint64_t total = born_ + planned_emission() - to_come(before) + to_come(now);
  if (total <= capacity_) return {};
  if (has_memory_for(total, facts_, species_used_)) return {};
  return Error{
      ErrorCode::out_of_memory,
      core::text(what, "speed: would emit ", to_come(now),
                 " particles until its end, more than there is memory for; lower it, or add the emitter "
                 "with max_particles or an earlier `until`")};
}

/// Whether a setting of an emitter can be taken; r has the speed and the temperature that it asks for.
Status WorldImpl::check_setting(EmitterId id, const EmitterRecord& r, const EmitterSetting& setting,
                                const std::string& what) const {
  if (setting.level)
    return invalid(what, "level: this emitter is a nozzle; add one with a level, or set its speed");
  EmitterDesc asked = r.desc;
  asked.from =
      std::min(std::max(asked.from, 0.0), asked.until);  // a changed speed moves where its layers count from
  if (Status s = core::validate(asked, desc.spacing); !s)
    return Error{s.error().code, "set_emitter: " + s.error().message};
  if (setting.center) {
    asked.center = *setting.center;
    std::vector<Vec3d> disc(emitter_points_.begin() + r.first_point,
                            emitter_points_.begin() + r.first_point + r.points);
    if (!finite(asked.center)) return invalid(what, "center: must be finite, got ", asked.center);
    if (Status s = check_nozzle(asked, what, disc, &emitters_[id.index]); !s) return s;
    if (Status s = check_faces(asked, what, disc); !s) return s;
  }
  return check_state_of(r.desc, what, r.contents, core::unit(r.desc.axis) * r.desc.speed);
}

/// When layers come after a change of speed: the next one when the last one has gone on by the distance of layers.
void WorldImpl::count_layers_anew(EmitterRecord& r, const EmitterRecord& before) const {
  if (r.desc.speed == before.desc.speed || time <= before.desc.from) return;
  const std::uint64_t next = layers_due(before, time);
  const double gone = next == 0 ? r.layer_distance : before.desc.speed * (time - due(before, next - 1));
  const double then = time + std::max(0.0, r.layer_distance - gone) / r.desc.speed;
  r.desc.from = then - double(next) * r.layer_distance / r.desc.speed;
}

/// Moves a nozzle whose liquid has this velocity, and the liquid in it.
void WorldImpl::move_nozzle(EmitterRecord& r, Vec3d velocity, Vec3d center) {
  const Vec3d begin = r.desc.center - origin_ - core::unit(r.desc.axis) * r.lead;
  engine->shift(velocity, begin, (r.held_layers + 1) * r.layer_distance,
                core::nozzle_reach_across(r.desc) + 0.5 * desc.spacing, center - r.desc.center);
  r.desc.center = center;
  state_stale_ = true;
}

/// Whether what an emitter emits from now on fits in beside temperatures that are level without an upload.
bool WorldImpl::keeps_level(const EmitterRecord& r) {
  if (!state_.heat_level || !emits(r)) return true;
  if (!edits_in_place()) return false;
  core::WorldStatus status;
  const auto runs = find({1, 1, 1}, {}, status);
  if (!runs || !*runs || !comes_in_place(r.desc.temperature, status)) return false;
  plan_changed_ = true;
  return true;
}

Status WorldImpl::set_emitter(EmitterId id, const EmitterSetting& setting) {
  if (!valid(id))
    return invalid("set_emitter: emitter: no emitter of this World has index ", id.index, " and generation ",
                   id.generation, "; pass what add_emitter() of this World returned");
  if (halted_)
    return Error{ErrorCode::halted, core::text("set_emitter: the World halted: ", halt_reason_,
                                               "; restore a snapshot to go on")};
  EmitterRecord r = emitters_[id.index];
  const std::string what = "set_emitter: emitter \"" + r.desc.name + "\": ";
  if (r.reservoir()) return set_reservoir(id, setting, what);
  const double before = r.desc.speed;
  if (setting.speed) r.desc.speed = *setting.speed;
  if (setting.temperature) r.desc.temperature = *setting.temperature;
  if (Status s = check_setting(id, r, setting, what); !s) return s;
  if (setting.on) r.on = *setting.on;
  count_layers_anew(r, emitters_[id.index]);
  limit_layers(r);
  constexpr double most_points = 4e9;  // ids are 32 bits
  if (!r.recycles() && double(r.layers) * r.points > most_points)
    return Error{ErrorCode::capacity,
                 core::text(what, "speed: would emit ", double(r.layers) * r.points,
                            " particles until its end; shorten it or set max_particles")};
  if (Status s = prepare(); !s) return s;
  if (Status s = check_emission(what, r, emitters_[id.index]); !s) return s;
  const Vec3d axis = core::unit(r.desc.axis);
  if (setting.center) move_nozzle(r, axis * before, *setting.center);  // by its speed, before that changes
  emitters_[id.index] = r;
  if (r.desc.speed != before) {
    engine->respeed(axis * before, axis * r.desc.speed);
    state_stale_ = true;
    see_speed(r.desc.speed);
  }
  const bool warmer = setting.temperature && !keeps_level(r);
  if (warmer || born_ + planned_emission() > capacity_) {
    fetch_state();
    dirty_ = true;
    measure_ = measure_ || warmer;
  }
  return {};
}

}  // namespace v0
}  // namespace meltsim
