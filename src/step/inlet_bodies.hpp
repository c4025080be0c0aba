// SPDX-License-Identifier: Apache-2.0
// Kernels of faces through which liquid comes in: how fast it does, and the particles that it brings (physics/inlet.hpp). Nozzles that
// recycle bring theirs likewise.
#pragma once

#include "frame/lattice.hpp"
#include "meltsim/physics/emission.hpp"
#include "meltsim/physics/inlet.hpp"
#include "spatial/around.hpp"

namespace meltsim {
inline namespace v0 {
namespace step {

using core::Frame;

/// Liquid ahead of the face, and how that moves which the face moves.
template <class T>
struct AheadOfInletBody {
  Frame<T> w;
  std::uint32_t face;
  MELTSIM_HD physics::InletSums operator()(std::uint64_t i) const {
    physics::InletSums s;
    const std::uint32_t tag = w.f.tag[i];
    if (!is_fluid(tag)) return s;
    const Vec4<T> x = w.f.position[i];
    const T d = physics::face_distance(w.c.domain_min, w.c.domain_max, xyz(x), face) / w.c.kernel.support;
    if (d >= T(physics::outlet_end)) return s;
    const T speed = dot(xyz(w.f.velocity[i]), physics::face_outwards<T>(face));
    if (d < T(physics::outlet_reach)) {
      if (is_held(tag)) s.moved = static_cast<double>(speed);
      return s;
    }
    const double dx = static_cast<double>(w.c.spacing);
    s.ahead.add(static_cast<double>(physics::inlet_weight(d)) * static_cast<double>(x.w) / (dx * dx * dx),
                static_cast<double>(speed / w.c.sound_speed));
    return s;
  }
};

/// How fast it moves from now on, and how deep it comes in.
template <class T>
struct InletSpeedBody {
  Frame<T> w;
  std::uint32_t face;
  MELTSIM_HD void operator()(const physics::InletSums& s) const {
    const core::Inlet<T>& row = w.f.inlets->row[face];
    const double g = static_cast<double>(length(w.f.clock->gravity));
    const physics::InletFlow b =
        physics::inlet_flow(s.ahead, static_cast<double>(w.c.spacing), static_cast<double>(w.c.sound_speed),
                            row.area, row.head, g);
    double wanted = physics::inlet_speed(b, static_cast<double>(row.layer));
    if (row.on == 0u) wanted = maximum(0.0, wanted);
    const double had = s.moved > physics::InletSums::nothing ? s.moved : 0.0;
    w.f.outlet_flow->speed[face] =
        static_cast<T>(physics::inlet_approach(had, wanted, static_cast<double>(w.f.clock->dt),
                                               static_cast<double>(w.c.kernel.support), row.head, g));
    w.f.outlet_flow->depth[face] = static_cast<T>(b.depth);
  }
};

/// Where a particle comes in at a point of a face: a layer's distance behind what is ahead of the point. Those ahead lie within
/// 0.7 spacings of the line through it, closer than its neighbours in a layer.
template <class T, bool Tree>
struct InletPlaceBody {
  Frame<T> w;
  std::uint32_t face;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const core::Inlet<T>& row = w.f.inlets->row[face];
    const std::uint64_t point = row.first_point + k;
    const Vec3<T> offset = xyz(w.f.emitter_points[point]);
    T place = T(-1);
    if (row.on != 0u && w.f.outlet_flow->speed[face] < T(0) &&
        row.middle + dot(offset, row.up) < w.f.outlet_flow->depth[face]) {
      const Vec3<T> inwards = row.inwards;
      const T across2 = T(0.49) * w.c.spacing * w.c.spacing;
      T room = T(1.25) * row.distance;
      spatial::for_each_around<Tree>(w, row.center + offset, 0u, 1u,
                                     [&](std::uint32_t j, const Vec4<T>&, const Vec3<T>& d, T r2) {
                                       const T along = -dot(d, inwards);
                                       if (is_removed(w.f.tag[j]) || r2 - along * along > across2) return;
                                       room = minimum(room, along);
                                     });
      place = room - row.distance;
    }
    w.f.inlet_place[point] = place;
  }
};

/// Every point of a nozzle gets a particle at the end of the sub-step at which a layer of it is due.
template <class T>
struct NozzlePlaceBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const core::Inlet<T>& nozzle = w.f.inlets->row[row];
    w.f.inlet_place[nozzle.first_point + k] = nozzle.due == w.f.clock->step ? T(0) : T(-1);
  }
};

/// How many of a face's or nozzle's points get a particle.
template <class T>
struct InletRankBody {
  const T* place;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t k) const { return place[k] >= T(0) ? 1u : 0u; }
};

/// How many of the ids in reserve hold nothing, since before this sub-step: where slot_of_id is not kept for liquid, the slot of what has just left
/// is not known. Ids that were of a body stay with it.
template <class T>
struct InletFreeBody {
  Frame<T> w;
  std::uint32_t first;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t k) const {
    const std::uint32_t id = first + static_cast<std::uint32_t>(k), slot = w.f.slot_of_id[id];
    const std::uint32_t tag = w.f.tag[slot];
    return w.f.id[slot] == id && w.f.group_of[slot] == core::none && is_removed(tag) && body_of(tag) == 0u
               ? 1u
               : 0u;
  }
};

/// The first entry of a running count that is n.
MELTSIM_HD std::uint32_t place_of_count(const std::uint32_t* counts, std::uint32_t items, std::uint32_t n) {
  std::uint32_t low = 0, high = items;
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2u;
    if (counts[middle] < n) low = middle + 1u;
    else high = middle;
  }
  return low;
}

/// What a particle that enters consists of. Source: mass, volume, enthalpy, solute, tag.
template <class T, class Source>
MELTSIM_HD void enter_as(const Frame<T>& w, std::uint32_t id, Vec3<T> x, Vec3<T> v, const Source& from) {
  const std::uint32_t slot = w.f.slot_of_id[id];  // until now it held nothing, as if removed
  w.f.position[slot] = with_w(x, from.volume * T(physics::entering_share));
  w.f.velocity[slot] = with_w(v, T(0));
  if (w.f.enthalpy != nullptr) w.f.enthalpy[slot] = from.enthalpy;
  else w.f.enthalpy_of_id[id] = from.enthalpy;
  if (w.f.solute != nullptr)
    for (std::uint32_t s = 0; s < w.species; ++s) core::solute_at(w, s, slot) = from.solute[s];
  w.f.mass[slot] = from.mass;
  w.f.tag[slot] = from.tag | tag_held;
  if (w.f.vertex_of_id != nullptr) w.f.vertex_of_id[id] = core::none;
}

/// The particles that come in get ids of the reserve, both in ascending order.
template <class T>
struct EnterBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const core::Inlet<T>& r = w.f.inlets->row[row];
    const std::uint64_t point = r.first_point + k;
    const T place = w.f.inlet_place[point];
    if (!(place >= T(0))) return;
    const std::uint32_t which = place_of_count(w.f.inlet_free + r.first_id, r.ids, w.f.inlet_rank[point]);
    if (which == r.ids) return;  // EnteredBody tells
    const Vec3<T> v = row < core::first_nozzle ? r.inwards * -w.f.outlet_flow->speed[row] : r.velocity;
    enter_as(w, r.first_id + which, r.center + xyz(w.f.emitter_points[point]) + r.inwards * place, v, r);
  }
};

/// How many have come in.
template <class T>
struct EnteredBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD void operator()(std::uint64_t) const {
    const core::Inlet<T>& r = w.f.inlets->row[row];
    const std::uint32_t due = w.f.inlet_rank[r.first_point + r.points - 1u],
                        free = w.f.inlet_free[r.first_id + r.ids - 1u];
    core::WorldStatus& s = *w.f.status;
    const std::uint32_t came = minimum(due, free);
    s.removed -= static_cast<std::int64_t>(came);
    s.entered += static_cast<std::int64_t>(came);
    if (due > free) s.reserve_spent = 1u;
  }
};

/// What comes in through a face, and the level beyond it, change; or a layer of a nozzle is due.
template <class T>
struct SetInletBody {
  core::Inlets<T>* inlets;
  std::uint32_t row;
  core::Inlet<T> now;
  MELTSIM_HD void operator()(std::uint64_t) const { inlets->row[row] = now; }
};

}  // namespace step
}  // namespace v0
}  // namespace meltsim
