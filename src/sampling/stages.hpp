// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sampling/bodies.hpp"
#include "sampling/event_bodies.hpp"
#include "sampling/force_bodies.hpp"
#include "sampling/lane_bodies.hpp"
#include "sampling/load_bodies.hpp"
#include "sampling/ray_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

/// Probes that are due in this sub-step, from its own neighbour structure. A CPU looks for levels from the top down; a GPU
/// sums at all heights at once, which takes no longer than at one.
template <class E, class T>
void probes(E& ex, const core::Frame<T>& w) {
  spatial::with_tree(w, [&](auto tree) {
    constexpr std::uint32_t parts = sample_parts<E>;
    if constexpr (E::backend == Backend::cpu) {
      if constexpr (core::runs_lanes<E> && !tree()) ex.for_each(w.probes.point_count, PointInLanesBody<T>{w});
      else ex.gather_listed(w.probes.point_count, w.probes.listed, PointBody<T, tree(), parts>{w});
      ex.for_each(w.probes.line_count, LookDownBody<T, tree(), parts>{w});
    } else {
      ex.gather_listed(std::uint64_t{w.probes.point_count} + w.probes.height_count, w.probes.listed,
                       AroundBody<T, tree(), parts>{w});
      ex.for_each(w.probes.line_count, GaugeLevelBody<T>{w});
    }
  });
}

/// One reduction over the particles per force, heat or flux.
template <class E, class T>
void loads(E& ex, const core::Frame<T>& w) {
  const auto sums = [&](core::LoadKind kind, auto body_of_row) {
    const auto k = static_cast<std::uint32_t>(kind);
    for (std::uint32_t row = w.probes.load_begin[k]; row < w.probes.load_begin[k + 1u]; ++row)
      ex.reduce(w.particles, body_of_row(row), w.probes.load_sums + row, LoadValuesBody<T>{w, row});
  };
  spatial::with_periods(w, [&](auto periodic) {
    constexpr bool Periodic = periodic();
    sums(core::LoadKind::liquid_on_body, [&](std::uint32_t row) {
      return LiquidOnBodyBody<T, Periodic>{w, row};
    });
    sums(core::LoadKind::contact_on_body, [&](std::uint32_t row) {
      return ContactOnBodyBody<T, Periodic>{w, row};
    });
    sums(core::LoadKind::liquid_on_wall, [&](std::uint32_t row) {
      return LiquidOnWallBody<T, Periodic>{w, row};
    });
  });
  sums(core::LoadKind::contact_on_wall, [&](std::uint32_t row) { return ContactOnWallBody<T>{w, row}; });
  sums(core::LoadKind::heat_of_body, [&](std::uint32_t row) { return HeatOfBodyBody<T>{w, row}; });
  sums(core::LoadKind::heat_of_wall, [&](std::uint32_t row) { return HeatOfWallBody<T>{w, row}; });
  sums(core::LoadKind::flux, [&](std::uint32_t row) { return FluxBody<T>{w, row}; });
}

/// Forces on watched bodies: one pass over all particles, with neighbours visited only at particles of these bodies.
template <class E, class T>
void forces(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.bodies, ClearForcesBody<T>{w});
  spatial::with_periods(w, [&](auto periodic) {
    ex.sum_by_row(w.particles, WatchedForcesBody<T, periodic()>{w}, w.f.force_sums);
  });
  if (w.f.enthalpy != nullptr)
    ex.sum_by_row(2 * std::uint64_t{w.particles}, HeatGainedBody<T>{w}, w.f.heat_sums);
}

template <class E, class T>
void forces_commit(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.bodies, AddForcesBody<T>{w});
}

/// Which bodies touch, while the neighbours are known.
template <class E, class T>
void touches(E& ex, const core::Frame<T>& w) {
  if (w.touch_entries == 0u) return;
  ex.fill(w.touch_entries, core::none, w.f.touch);
  spatial::with_periods(w, [&](auto periodic) { ex.accumulate(w.particles, TouchBody<T, periodic()>{w}); });
}

/// Events of this sub-step, at its end. Most sub-steps have none: a guard then stops the kernels that write them.
template <class E, class T>
void events(E& ex, const core::Frame<T>& w) {
  ex.fill(w.vertices, core::none, w.f.new_piece);
  ex.accumulate(std::uint64_t{w.particles} + w.vertices, NoticeBody<T>{w});
  ex.accumulate(event_items(w), CountEventsBody<T>{w});
  ex.for_each(1, BeginEventsBody<T>{w});
  ex.set_guard(&w.f.event_head->idle);
  ex.scan(event_items(w), EventRankBody<T>{w}, w.f.event_place);
  ex.accumulate(event_items(w), WriteEventBody<T>{w});
  ex.for_each(1, EndEventsBody<T>{w});
  ex.set_guard(&w.f.status->halted);
  ex.for_each(event_items(w), SeenBody<T>{w});
}

/// Between sub-steps, for World::sample: sorts particles by cell, then averages; not a stage. w.grid: cells of H.
template <class E, class T>
void at_once(E& ex, const core::Frame<T>& w, const core::SampleRoom& room) {
  ex.for_each(w.born, KeyBody<T>{w, room.keys, room.slots});
  if (room.derived_slot != nullptr) ex.for_each(w.particles, DerivedSlotBody<T>{w, room.derived_slot});
  ex.sort(w.born, w.key_bits, room.keys, room.slots, room.keys_sorted, room.slots_sorted);
  ex.gather_listed(w.probes.point_count, w.probes.listed, PointBody<T, false, sample_parts<E>>{w});
}

/// Between sub-steps, for World::cast_rays: likewise, then one thread per ray; not a stage.
template <class E, class T>
void follow_rays(E& ex, const core::Frame<T>& w, const core::SampleRoom& room, const core::RayRoom& rays) {
  ex.for_each(w.born, KeyBody<T>{w, room.keys, room.slots});
  ex.sort(w.born, w.key_bits, room.keys, room.slots, room.keys_sorted, room.slots_sorted);
  ex.reduce(w.particles, ParticleBoundsBody<T>{w}, rays.bounds);
  ex.for_each(rays.count, RayBody<T>{w, rays});
}

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
