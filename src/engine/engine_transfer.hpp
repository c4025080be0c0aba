// SPDX-License-Identifier: Apache-2.0
// Uploads a scene to the backend and downloads a state from it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "engine/empty_sites.hpp"
#include "engine/engine.hpp"
#include "engine/held.hpp"
#include "engine/rounded.hpp"
#include "exec/host_loops.hpp"
#include "frame/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class E, class V>
void put(E& ex, V* to, const std::vector<V>& from) {
  if (to != nullptr && !from.empty()) ex.upload(to, from.data(), from.size() * sizeof(V));
}

template <class E, class V>
std::vector<V> fetch(const E& ex, const V* from, std::size_t n) {
  std::vector<V> v(n);
  if (n != 0) ex.download(v.data(), from, n * sizeof(V));
  return v;
}

// Arrays of fields.def that come from channels of particles, by slot.
#define MELTSIM_BY_SLOT_particle(...) __VA_ARGS__
#define MELTSIM_BY_SLOT_id(...)
#define MELTSIM_BY_SLOT_vertex(...)

/// Puts a part of every item: `from`, then `to_come`.
template <class Part, class Host, class Item>
void fill_slots(const HostLoops& loops, std::vector<Item>& to, const std::vector<Host>& from,
                const Host& to_come) {
  loops.pieces(to.size(), [&](std::size_t i, std::size_t end) {
    for (; i < end; ++i) Part::put(to[i], i < from.size() ? from[i] : to_come);
  });
}

/// The State channels of particles, by slot. What emitters will fill lies ready as if it had been removed.
template <class T>
struct ParticleArrays {
#define MELTSIM_MOVED(name, type) std::vector<type> name;
#include "meltsim/fields.def"
  ParticleArrays(const SceneState& s, std::size_t capacity, std::size_t species, const HostLoops& loops) {
#define MELTSIM_MOVED(name, type) loops.resize(name, capacity);
#define MELTSIM_HELD(array, host, owner, channel, part, first, hashed) \
  MELTSIM_BY_SLOT_##owner(fill_slots<Part_##part>(loops, channel, s.array, host(first));)
#include "meltsim/fields.def"
    for (std::size_t i = 0; i < capacity; ++i) id[i] = static_cast<std::uint32_t>(i);
    solute.assign(capacity * species, 0.0);
    for (std::size_t k = 0; k < species; ++k)
      std::copy(s.solute[k].begin(), s.solute[k].end(),
                solute.begin() + static_cast<std::ptrdiff_t>(k * capacity));
  }
};

/// Uploads into the buffers that the frame points at.
template <class E, class T>
void put_particles(E& ex, const Frame<T>& w, const ParticleArrays<T>& a) {
#define MELTSIM_MOVED(name, type) put(ex, w.f.name, a.name);
#include "meltsim/fields.def"
  put(ex, w.f.enthalpy_of_id, a.enthalpy);  // slots are ids as yet
}

template <class E, class T>
void put_inlets(E& ex, const Frame<T>& w, const SceneConstants& c) {
  if (w.f.inlets == nullptr) return;
  Inlets<T> inlets;
  for (std::size_t k = 0; k < inlet_rows; ++k) inlets.row[k] = round_inlet<T>(c.inlets.row[k]);
  ex.upload(w.f.inlets, &inlets, sizeof inlets);
}

/// Tables of the scene.
template <class E, class T>
void put_tables(E& ex, const Frame<T>& w, const SceneConstants& c) {
  std::vector<MaterialRow<T>> materials;
  for (const MaterialRow<double>& m : c.materials) {
    materials.push_back(round_row<T>(m));
    if (w.f.properties != nullptr && m.tables != nullptr && !c.properties.empty())  // else they go
      materials.back().tables = w.f.properties + (materials.size() - 1);
  }
  put(ex, w.f.materials, materials);
  std::vector<MaterialProperties<T>> properties;
  for (const MaterialProperties<double>& p : c.properties) properties.push_back(round_properties<T>(p));
  put(ex, w.f.properties, properties);
  std::vector<SpeciesRow<T>> species;
  for (const SpeciesRow<double>& s : c.species) species.push_back(round_row<T>(s));
  put(ex, w.f.species, species);
  std::vector<Vec4<T>> points;
  for (const Vec3d& p : c.emitter_points) points.push_back(with_w(cast<T>(p), T(0)));
  put(ex, w.f.emitter_points, points);
  std::vector<HeatRegionRow<T>> regions;
  for (const HeatRegionRow<double>& r : c.heat_regions)
    regions.push_back({cast<T>(r.min), static_cast<T>(r.inv_cell), r.nx, r.ny, r.nz, r.first_word, r.held,
                       r.temperature, static_cast<T>(r.source), r.from, r.until, r.moves, r.first_point,
                       r.points, r.since, r.displacement, r.velocity});
  put(ex, w.f.heat_regions, regions);
  put(ex, w.f.heat_region_cells, c.heat_region_cells);
  put(ex, w.f.heat_region_path, c.heat_region_path);
  if (w.f.force_fields != nullptr) {
    ForceFields<T> fields;
    fields.count = c.force_fields.count;
    for (std::uint32_t k = 0; k < physics::most_force_fields; ++k)
      fields.row[k] = round_field<T>(c.force_fields.row[k]);
    ex.upload(w.f.force_fields, &fields, sizeof fields);
  }
  put_inlets(ex, w, c);
  std::vector<BodyHeat<T>> body_heat;
  for (const BodyHeat<double>& b : c.body_heat)
    body_heat.push_back({round_condition<T>(b.surface), static_cast<T>(b.source)});
  put(ex, w.f.body_heat, body_heat);
}

/// An array of the state as the channel has it.
template <class Part, class E, class Item, class Host>
void put_as(E& ex, const HostLoops& loops, Item* to, const std::vector<Host>& from) {
  if (to == nullptr) return;
  if constexpr (std::is_same_v<Item, Host> && std::is_same_v<Part, Part_all>) return put(ex, to, from);
  std::vector<Item> items;
  loops.resize(items, from.size());
  fill_slots<Part>(loops, items, from, Host{});
  put(ex, to, items);
}

/// Items from `first` on.
template <class V>
std::vector<V> behind(const std::vector<V>& v, std::uint64_t first) {
  return {v.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(first, v.size())), v.end()};
}

/// Uploads items behind the first ones.
template <class E, class V>
void put_behind(E& ex, V* to, std::uint64_t first, const std::vector<V>& items) {
  if (to != nullptr) put(ex, to + first, items);
}

/// How the surface lies at the vertices from `first` on.
template <class T>
std::vector<Vec4<T>> contact_shapes_behind(const SceneLattice& l, std::uint64_t first, T spacing) {
  std::vector<Vec4<T>> shapes;
  for (std::uint64_t v = first; v < l.contact_shape.size(); ++v)
    shapes.push_back(
        with_w(cast<T>(xyz(l.contact_shape[v])), static_cast<T>(l.contact_shape[v].w) * spacing));
  return shapes;
}

/// Labels of free vertices [first, end) that never were of a piece: each its own.
inline std::vector<std::uint32_t> own_labels(std::uint64_t first, std::uint64_t end) {
  std::vector<std::uint32_t> labels;
  for (std::uint64_t v = first; v < end; ++v) labels.push_back(static_cast<std::uint32_t>(v));
  return labels;
}

/// Vertices, sites and the body that fill the room for what is to come, of the channels in `which`.
template <class E, class T>
void put_room(E& ex, const Frame<T>& w, const SceneLattice& l, const LatticeRoom& room, FieldSet which) {
  const auto wanted = [which](int field, auto* to) { return which.has(field) ? to : nullptr; };
  const std::uint64_t vertices = l.vertex_site.size(), sites = l.site_vertex.size();
  if (room.vertices <= vertices || room.sites < sites + LatticeRoom::spare_sites ||
      room.bodies <= l.bodies.size())
    return;
  const std::uint64_t more = room.vertices - vertices;
  const auto spare_site = static_cast<std::uint32_t>(room.sites - LatticeRoom::spare_sites / 2);
  const std::vector<std::uint32_t> nothing(more, none), site(more, spare_site),
      body(more, static_cast<std::uint32_t>(room.bodies - 1));
  put_behind(ex, wanted(field_vertex_id, w.f.vertex_id), vertices, nothing);
  put_behind(ex, wanted(field_vertex_piece, w.f.vertex_piece), vertices, own_labels(vertices, room.vertices));
  put_behind(ex, wanted(field_vertex_site, w.f.vertex_site), vertices, site);
  put_behind(ex, wanted(field_vertex_body, w.f.vertex_body), vertices, body);
  put_behind(ex, wanted(field_site_vertex, w.f.site_vertex), sites,
             std::vector<std::uint32_t>(room.sites - sites, none));
  BodyRow spare;
  spare.stride_y = spare.stride_z = 1;  // whatever is asked for beside its site is one of its sites
  spare.first_site = spare_site;
  put_behind(ex, wanted(field_bodies, w.f.bodies), room.bodies - 1, std::vector<BodyRow>{spare});
}

/// Uploads the part of the lattice, and of the state, that belongs to the body added last, into the channels that are there.
template <class E, class T>
void put_body(E& ex, const Frame<T>& w, const SceneLattice& l, const SceneState& s, const AddedBody& a) {
  const std::uint64_t v = a.first_vertex;
#define MELTSIM_HELD(array, host, owner, channel, part, first, hashed) \
  if constexpr (Owner::owner == Owner::vertex)                         \
    if (w.f.channel != nullptr) put_as<Part_##part>(ex, HostLoops(1), w.f.channel + v, behind(s.array, v));
#include "meltsim/fields.def"
  put_behind(ex, w.f.vertex_site, v, behind(l.vertex_site, v));
  put_behind(ex, w.f.vertex_body, v, behind(l.vertex_body, v));
  put_behind(ex, w.f.contact_shape, v, contact_shapes_behind(l, v, w.c.spacing));
  put_behind(ex, w.f.rigid_rotation, v, behind(s.region_rotation, v));
  put_behind(ex, w.f.seen_piece, v, behind(s.vertex_piece, v));
  if (w.f.site_vertex != nullptr)
    put(ex, w.f.site_vertex + a.first_site, mark_empty_sites(l, a, HostLoops(1)));
  if (w.f.bodies != nullptr) ex.upload(w.f.bodies + a.body, &l.bodies[a.body], sizeof(BodyRow));
  if (w.f.body_motion != nullptr) {
    BodyMotionRow row = l.rests[a.body];
    row.motion = s.motion[a.body];
    ex.upload(w.f.body_motion + a.body, &row, sizeof row);
  }
  if (w.f.body_forces != nullptr)
    ex.upload(w.f.body_forces + a.body, &s.forces[a.body], sizeof(BodyForceTotals));
  if (w.f.body_heat != nullptr) {
    const BodyHeat<T> heat{round_condition<T>(a.heat.surface), static_cast<T>(a.heat.source)};
    ex.upload(w.f.body_heat + a.body, &heat, sizeof heat);
  }
}

/// Uploads the channels of the lattice and its state that are in `which`.
template <class E, class T>
void put_lattice(E& ex, const Frame<T>& w, const SceneLattice& l, const SceneState& s,
                 const LatticeRoom& room, FieldSet which, const HostLoops& loops) {
  const auto wanted = [which](int field, auto* to) { return which.has(field) ? to : nullptr; };
#define MELTSIM_HELD(array, host, owner, channel, part, first, hashed)      \
  if constexpr (Owner::owner == Owner::vertex || Owner::owner == Owner::id) \
    put_as<Part_##part>(ex, loops, wanted(field_##channel, w.f.channel), s.array);
#include "meltsim/fields.def"
  put(ex, wanted(field_vertex_site, w.f.vertex_site), l.vertex_site);
  put(ex, wanted(field_vertex_body, w.f.vertex_body), l.vertex_body);
  if (wanted(field_contact_shape, w.f.contact_shape) != nullptr)
    put(ex, w.f.contact_shape, contact_shapes_behind(l, 0, w.c.spacing));
  put(ex, wanted(field_rigid_rotation, w.f.rigid_rotation), s.region_rotation);
  if (wanted(field_site_vertex, w.f.site_vertex) != nullptr)
    put(ex, w.f.site_vertex, mark_empty_sites(l, {}, loops));
  put(ex, wanted(field_bodies, w.f.bodies), l.bodies);
  if (wanted(field_body_motion, w.f.body_motion) != nullptr) {
    std::vector<BodyMotionRow> rows = l.rests;
    for (std::size_t b = 0; b < rows.size(); ++b) rows[b].motion = s.motion[b];
    put(ex, w.f.body_motion, rows);
  }
  put(ex, wanted(field_mesh_points, w.f.mesh_points), s.mesh_points);
  put(ex, wanted(field_body_forces, w.f.body_forces), s.forces);
  put_room(ex, w, l, room, which);
}

/// Uploads the state that events are compared with, and events that the host has not taken.
template <class E, class T>
void put_events(E& ex, const Frame<T>& w, const std::vector<std::uint32_t>& tags, const SceneState& s,
                const LatticeRoom& room) {
  if (w.f.event_head == nullptr) return;
  put(ex, w.f.seen_tag, tags);
  put(ex, w.f.seen_piece, s.vertex_piece);
  put_behind(ex, w.f.seen_piece, s.vertex_piece.size(), own_labels(s.vertex_piece.size(), room.vertices));
  put(ex, w.f.seen_touch, s.touched);
  put(ex, w.f.events, s.events);
  ex.upload(w.f.event_head, &s.event_head, sizeof s.event_head);
}

/// The status that a state begins with.
template <class E, class T>
void put_status(E& ex, const Frame<T>& w, const SceneState& s) {
  WorldStatus status;
  status.melted = static_cast<std::int64_t>(s.melted);
  status.frozen = s.frozen;
  status.removed = static_cast<std::int64_t>(s.removed);
  status.strayed = static_cast<std::int64_t>(s.strayed);
  status.entered = static_cast<std::int64_t>(s.entered);
  status.heat_in = s.heat_in;
  status.field_work = s.field_work;
  status.field_impulse = s.field_impulse;
  status.particles = w.born;
  status.heat_idle = s.heat_level ? idle_level : 0u;
  if (w.f.status != nullptr) ex.upload(w.f.status, &status, sizeof status);
}

/// Downloads a channel into its array of the state, if the channel is allocated.
template <class Part, class E, class Item, class Host>
void fetch_as(const E& ex, const Item* from, std::size_t n, std::vector<Host>& to) {
  if (from == nullptr) return;
  const auto items = fetch(ex, from, n);
  to.resize(n);
  for (std::size_t i = 0; i < n; ++i) to[i] = Part::template get<Host>(items[i]);
}

/// Reorders a channel by slot into an array by id; `to_come` fills entries without a particle.
template <class Part, class Host, class Item>
void sort_by_id(const std::vector<Item>& from, const std::vector<std::uint32_t>& id, std::size_t n,
                const std::common_type_t<Host>& to_come, std::vector<Host>& to) {
  to.resize(n, to_come);
  for (std::size_t i = 0; i < from.size(); ++i)
    if (id[i] < n) to[id[i]] = Part::template get<Host>(from[i]);
}

/// Waits; downloads the State channels of the lattice that are allocated.
template <class E, class T>
void download_lattice(const E& ex, const Frame<T>& w, SceneState& s) {
#define MELTSIM_HELD(array, host, owner, channel, part, first, hashed)      \
  if constexpr (Owner::owner == Owner::vertex || Owner::owner == Owner::id) \
    fetch_as<Part_##part>(ex, w.f.channel, Owner::owner == Owner::id ? w.born : s.array.size(), s.array);
#include "meltsim/fields.def"
  if (w.f.rigid_rotation != nullptr) {
    const auto q = fetch(ex, w.f.rigid_rotation, s.region_rotation.size());
    const auto body = fetch(ex, w.f.vertex_body, s.region_rotation.size());
    const auto rows = fetch(ex, w.f.bodies, s.motion.size());
    for (std::size_t v = 0; v < q.size(); ++v)
      if (moves_rigidly(rows[body[v]])) s.region_rotation[v] = q[v];
  }
  if (w.f.body_motion != nullptr) {
    const auto rows = fetch(ex, w.f.body_motion, s.motion.size());
    for (std::size_t b = 0; b < rows.size(); ++b) s.motion[b] = rows[b].motion;
  }
  if (w.f.mesh_points != nullptr) s.mesh_points = fetch(ex, w.f.mesh_points, s.mesh_points.size());
  if (w.f.body_forces != nullptr) s.forces = fetch(ex, w.f.body_forces, s.motion.size());
}

/// Waits; downloads every State channel in order of id.
template <class E, class T>
void download_state(const E& ex, const Frame<T>& w, SceneState& s) {
  const std::size_t n = w.born, slots = w.particles;
#define MELTSIM_MOVED(name, type) \
  const auto name = fetch(ex, w.f.name, w.f.name != nullptr && field_##name != field_solute ? slots : 0);
#include "meltsim/fields.def"
#define MELTSIM_HELD(array, host, owner, channel, part, first, hashed) \
  MELTSIM_BY_SLOT_##owner(sort_by_id<Part_##part, host>(channel, id, n, first, s.array);)
#include "meltsim/fields.def"
  if (w.f.enthalpy == nullptr) fetch_as<Part_all>(ex, w.f.enthalpy_of_id, n, s.enthalpy);
  for (std::uint32_t k = 0; k < w.species && w.f.solute != nullptr; ++k)
    sort_by_id<Part_all, double>(fetch(ex, w.f.solute + k * w.capacity, slots), id, n, 0.0, s.solute[k]);
  s.vertex_of_id.resize(n, none);
  download_lattice(ex, w, s);
  if (w.f.event_head != nullptr) {
    s.event_head = fetch(ex, w.f.event_head, 1).front();
    s.events = fetch(ex, w.f.events, w.event_capacity);
    s.touched = fetch(ex, w.f.seen_touch, w.touch_entries);
    s.touched_bodies = w.bodies;
  }
  if (w.f.status != nullptr) {
    WorldStatus status;
    ex.download(&status, w.f.status, sizeof status);
    s.melted = static_cast<std::uint64_t>(status.melted);
    s.frozen = status.frozen;
    s.removed = static_cast<std::uint64_t>(status.removed);
    s.strayed = static_cast<std::uint64_t>(status.strayed);
    s.entered = static_cast<std::uint64_t>(status.entered);
    s.heat_in = status.heat_in;
    s.field_work = status.field_work;
    s.field_impulse = status.field_impulse;
    s.heat_level = (status.heat_idle & idle_level) != 0u;
  }
}

#undef MELTSIM_BY_SLOT_particle
#undef MELTSIM_BY_SLOT_id
#undef MELTSIM_BY_SLOT_vertex

/// Waits. rolled_back: the World halted. Channels of the halted sub-step are in its own order, which is not the
/// state's.
template <class E, class T>
void download_derived(const E& ex, const Frame<T>& w, bool rolled_back, DerivedState& d) {
  const std::size_t n = w.born, slots = w.particles;
  const auto density = fetch(ex, w.f.density, slots);
  const auto velocity = fetch<E, Vec4<T>>(ex, rolled_back ? w.before.velocity : w.f.velocity, slots);
  const auto id = fetch<E, std::uint32_t>(ex, rolled_back ? w.before.id : w.f.id, slots);
  for (std::size_t i = 0; i < slots; ++i) {
    if (id[i] >= n) continue;  // to come
    d.density[id[i]] = static_cast<double>(density[i]);
    d.pressure_term[id[i]] = static_cast<double>(velocity[i].w);
  }
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
