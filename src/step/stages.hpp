// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "step/bodies.hpp"
#include "step/edit_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace step {

template <class E, class T>
void begin(E& ex, const core::Frame<T>& w) {
  ex.for_each(1, BeginBody<T>{w});
}

/// The same, and where cells begin that the sub-step before has counted, in one launch; not a stage.
template <class E, class T>
void begin_cells(E& ex, const core::Frame<T>& w) {
  ex.begin_buckets(w.cells + 1, w.f.cell_count, w.f.cell_begin, BeginBody<T>{w});
}

/// One burst; called by the engine once per layer that is due, before step.begin.
template <class E, class T>
void emit(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.burst.points, EmitBody<T>{w});
}

/// Before a burst: the nozzle releases the layer that has reached its end; not a stage.
template <class E, class T>
void let_go(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, LetGoBody<T>{w});
}

/// Ahead of a sub-step: the first n rows of `steered` hold; not a stage.
template <class E, class T>
void steer(E& ex, const core::Frame<T>& w, const core::Steered* steered, std::uint32_t n) {
  SteerBody body{w.f.body_motion, w.f.bodies, {}, 0u, {}, {}, {}, cast<double>(w.grid.period)};
  for (std::uint32_t k = 0; k < n; ++k) {
    body.body[k] = steered[k].body;
    body.motion[k] = steered[k].motion;
    body.reach[k] = steered[k].reach;
    body.most[k] = steered[k].most;
    if (steered[k].jumps) body.jumps |= 1u << k;
  }
  ex.for_each(n, body);
}
/// After it; not a stage.
template <class E, class T>
void set_off(E& ex, const core::Frame<T>& w, double time, bool places) {
  ex.for_each(w.vertices, SetOffBody<T>{w, time, places});
}

/// Between sub-steps; not a stage.
template <class E, class T>
void set_heat_region(E& ex, const core::Frame<T>& w, std::uint32_t row, bool held, double temperature,
                     double source) {
  ex.for_each(
      1, SetHeatRegionBody<T>{w.f.heat_regions + row, held ? 1u : 0u, temperature, static_cast<T>(source)});
}

/// Between sub-steps; not a stage.
template <class E, class T>
void set_body_heat(E& ex, const core::Frame<T>& w, std::uint32_t body, const core::BodyHeat<T>& heat) {
  ex.for_each(1, SetBodyHeatBody<T>{w.f.body_heat + body, heat});
}

/// Between sub-steps; not a stage.
template <class E, class T>
void move_heat_region(E& ex, const core::Frame<T>& w, std::uint32_t row, double since,
                      Vec3<double> displacement, Vec3<double> velocity) {
  ex.for_each(1, MoveHeatRegionBody<T>{w.f.heat_regions + row, since, displacement, velocity});
}

/// Between sub-steps; not a stage.
template <class E, class T>
void set_force_field(E& ex, const core::Frame<T>& w, std::uint32_t row, const physics::ForceField<T>& field,
                     std::uint32_t count) {
  ex.for_each(1, SetForceFieldBody<T>{w.f.force_fields, row, count, field});
}

/// After all other forces except those of shape matching, and before implicit viscosity.
template <class E, class T>
void fields(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, FieldsBody<T>{w});
  ex.reduce(w.particles, FieldWorkBody<T>{w}, &w.f.field_account->sum, KeepFieldWorkBody<T>{w});
}
/// After step.integrate.
template <class E, class T>
void work(E& ex, const core::Frame<T>& w) {
  ex.reduce(w.particles, FieldWorkBody<T>{w}, &w.f.field_account->sum, AddFieldWorkBody<T>{w});
}

/// Between sub-steps; not a stage.
template <class E, class T>
void set_sound_speed(E& ex, const core::Frame<T>& w, std::uint32_t materials, double speed, double change,
                     core::SoundWork* sum, core::SoundWork* account) {
  if (change != 0) ex.reduce(w.particles, CompressionBody<T>{w}, sum, SoundWorkBody{account, change});
  ex.for_each(materials, SetSoundSpeedBody<T>{w.f.materials, speed});
}

/// Between sub-steps; not a stage.
template <class E, class T>
void look(E& ex, const core::Frame<T>& w, bool sized, core::SoundLook* to) {
  ex.reduce(w.particles, LookBody<T>{w, sized}, to);
}

/// Between sub-steps; not a stage.
template <class E, class T>
void push(E& ex, const core::Frame<T>& w, const core::PushArguments& a) {
  ex.reduce(w.particles, ReachOfBodyBody<T>{w, a}, &w.f.push->reach, PushUnitsBody<T>{w});
  ex.reduce(w.particles, MassOfBodyBody<T>{w, a}, &w.f.push->counts, MakePushBody<T>{w, a});
  ex.for_each(w.particles, PushBody<T>{w, a});
}

/// Liquid that nozzles hold moves at another velocity from now on; not a stage.
template <class E, class T>
void respeed(E& ex, const core::Frame<T>& w, Vec3<double> from, Vec3<double> to) {
  ex.for_each(w.particles, RespeedBody<T>{w, cast<T>(from), cast<T>(to)});
}

/// Liquid in a nozzle moves with it; not a stage.
template <class E, class T>
void shift(E& ex, const core::Frame<T>& w, Vec3<double> velocity, Vec3<double> begin, double length,
           double reach, Vec3<double> by) {
  const Vec3<double> axis = velocity * (1 / meltsim::length(velocity));
  ex.for_each(w.particles, NozzleShiftBody<T>{w, cast<T>(velocity), cast<T>(begin), cast<T>(axis),
                                              cast<T>(by), static_cast<T>(length), static_cast<T>(reach)});
}

/// Running count of particles of a box, range by range; not a stage.
template <class E, class T>
void count_in_box(E& ex, const core::Frame<T>& w, const core::FoundBox& box, std::uint64_t ranges,
                  std::uint32_t* counts) {
  ex.scan(ranges, CountInBoxBody<T>{w, box}, counts);
}
/// Behind it: those particles; not a stage.
template <class E, class T>
void list_in_box(E& ex, const core::Frame<T>& w, const core::FoundBox& box, std::uint64_t ranges,
                 const std::uint32_t* counts, core::FoundParticle* list) {
  ex.for_each(ranges, ListInBoxBody<T>{w, box, counts, list});
}

/// Between sub-steps; not stages.
template <class E, class T>
void append(E& ex, const core::Frame<T>& w, const core::PreviousViews<T>& from, std::uint32_t first,
            std::uint32_t vertex, std::uint64_t n) {
  ex.for_each(n, AppendBody<T>{w, from, first, vertex, n});
}
template <class E, class T>
void take_out(E& ex, const core::Frame<T>& w, const core::FoundParticle* list, std::uint64_t n) {
  ex.for_each(n, TakeOutBody<T>{w, list});
}
template <class E, class T>
void move(E& ex, const core::Frame<T>& w, const core::FoundParticle* list, std::uint64_t n) {
  ex.for_each(n, MoveBody<T>{w, list});
}
template <class E, class T>
void take_body(E& ex, const core::Frame<T>& w, std::uint32_t body, std::uint32_t first, std::uint32_t count,
               core::TakenSum* sum) {
  if (w.f.site_live != nullptr) ex.accumulate(count, EmptySitesBody<T>{w, first});
  ex.reduce(count, TakeBodyBody<T>{w, first, body}, sum);
}

template <class E, class T>
void list_body(E& ex, const core::Frame<T>& w, std::uint32_t body, std::uint32_t first, std::uint32_t count,
               core::FoundParticle* list) {
  ex.for_each(count, ListBodyBody<T>{w, first, body, list});
}
template <class E, class T>
void hold(E& ex, const core::Frame<T>& w, const core::FoundParticle* list, std::uint64_t n, bool on,
          std::uint32_t first, std::uint32_t count) {
  ex.for_each(n, HoldBody<T>{w, list});
  if (on && w.f.rigid_rotation != nullptr && w.f.region_rotation != nullptr)
    ex.for_each(count, RoundRotationsBody<T>{w, first});
}

template <class E, class T>
void outlets(E& ex, const core::Frame<T>& w) {
  for (std::uint32_t f = 0; f < 6u; ++f)
    if (((w.c.outlets.levels >> f) & 1u) != 0u)
      ex.reduce(w.particles, AheadOfOutletBody<T>{w, f}, &w.f.outlet_flow->sums[f], OutletSpeedBody<T>{w, f});
}

template <class E, class T>
void inlets(E& ex, const core::Frame<T>& w) {
  for (std::uint32_t f = 0; f < 6u; ++f)
    if (((w.c.outlets.inlets >> f) & 1u) != 0u)
      ex.reduce(w.particles, AheadOfInletBody<T>{w, f}, &w.f.outlet_flow->inlet[f], InletSpeedBody<T>{w, f});
}

/// Particles of a row of `inlets` whose places are known.
template <class E, class T>
void enter_row(E& ex, const core::Frame<T>& w, std::uint32_t row) {
  const std::uint32_t points = w.c.inlet_points[row], ids = w.c.inlet_ids[row];
  const std::uint32_t point = w.c.inlet_first_point[row], id = w.c.inlet_first_id[row];
  ex.scan(points, InletRankBody<T>{w.f.inlet_place + point}, w.f.inlet_rank + point);
  ex.scan(ids, InletFreeBody<T>{w, id}, w.f.inlet_free + id);
  ex.for_each(points, EnterBody<T>{w, row});
  ex.for_each(1, EnteredBody<T>{w, row});
}

/// After step.integrate: neighbours are those of the middle of the sub-step.
template <class E, class T>
void enter(E& ex, const core::Frame<T>& w) {
  for (std::uint32_t f = 0; f < core::first_nozzle; ++f) {
    if (((w.c.outlets.inlets >> f) & 1u) == 0u) continue;
    spatial::with_tree(w, [&](auto tree) {
      ex.for_each(w.c.inlet_points[f], InletPlaceBody<T, tree()>{w, f});
    });
    enter_row(ex, w, f);
  }
  for (std::uint32_t row = core::first_nozzle; row < core::first_nozzle + w.c.nozzles; ++row) {
    ex.for_each(w.c.inlet_points[row], NozzlePlaceBody<T>{w, row});
    enter_row(ex, w, row);
  }
}

/// Between sub-steps; not a stage.
template <class E, class T>
void set_inlet(E& ex, const core::Frame<T>& w, std::uint32_t row, const core::Inlet<T>& now) {
  ex.for_each(1, SetInletBody<T>{w.f.inlets, row, now});
}

template <class E, class T>
void carry(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, CarryBody<T>{w});
}

template <class E, class T>
void integrate(E& ex, const core::Frame<T>& w) {
  ex.gather_reduce(w.particles, IntegrateBody<T>{w}, w.f.check, core::JudgeBody<T>{w});
}

/// Resets reported extremes; not a stage.
template <class E, class T>
void clear(E& ex, const core::Frame<T>& w) {
  ex.for_each(1, ClearBody<T>{w});
}

/// After a saved state was copied back, unless *missing; not a stage.
template <class E, class T>
void loaded(E& ex, const core::Frame<T>& w, const std::uint32_t* missing, std::uint64_t step) {
  ex.for_each(1, LoadedBody<T>{w, missing, step});
}

/// Marks an interrupted sub-step, which does not count; not a stage.
template <class E, class T>
void give_up(E& ex, const core::Frame<T>& w) {
  ex.for_each(1, core::GiveUpBody<T>{w});
}

/// After a roll-back, behind reindex; not a stage.
template <class E, class T>
void restore(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, RestoreBody<T>{w});
}

/// When the plan changes; not stages.
template <class E, class T>
void enthalpy_to_slots(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, EnthalpyBody<T>{w, true});
}
template <class E, class T>
void enthalpy_to_ids(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, EnthalpyBody<T>{w, false});
}

/// After a roll-back; not a stage.
template <class E, class T>
void reindex(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, IndexBody<T>{w});
}

}  // namespace step
}  // namespace v0
}  // namespace meltsim
