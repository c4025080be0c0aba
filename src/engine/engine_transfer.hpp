// SPDX-License-Identifier: Apache-2.0
// A scene to the backend, a state from it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/empty_sites.hpp"
#include "engine/engine.hpp"
#include "engine/frame.hpp"
#include "engine/rounded.hpp"

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

/// The State channels of particles, by slot. What emitters will fill lies ready as if it had been removed.
template <class T>
struct ParticleArrays {
  std::vector<Vec4<T>> position, velocity;
  std::vector<T> mass;
  std::vector<double> enthalpy;
  std::vector<double> solute;  ///< an array of `capacity` per species
  std::vector<std::uint32_t> tag, id;
  ParticleArrays(const SceneState& s, std::size_t capacity, std::size_t species)
      : position(capacity, Vec4<T>{0, 0, 0, 1}),
        velocity(capacity),
        mass(capacity, T(1)),
        enthalpy(capacity, 0.0),
        solute(capacity * species, 0.0),
        tag(capacity, tag_removed),
        id(capacity) {
    for (std::size_t i = 0; i < capacity; ++i) id[i] = static_cast<std::uint32_t>(i);
    for (std::size_t i = 0; i < s.position.size(); ++i) {
      position[i] = with_w(cast<T>(s.position[i]), static_cast<T>(s.volume[i]));
      velocity[i] = with_w(cast<T>(s.velocity[i]), T(0));
      mass[i] = static_cast<T>(s.mass[i]);
      enthalpy[i] = s.enthalpy[i];
      tag[i] = s.tag[i];
    }
    for (std::size_t k = 0; k < species; ++k)
      std::copy(s.solute[k].begin(), s.solute[k].end(),
                solute.begin() + static_cast<std::ptrdiff_t>(k * capacity));
  }
};

/// To the buffers that the frame points at.
template <class E, class T>
void put_particles(E& ex, const Frame<T>& w, const ParticleArrays<T>& a) {
  put(ex, w.f.position, a.position);
  put(ex, w.f.velocity, a.velocity);
  put(ex, w.f.enthalpy, a.enthalpy);
  put(ex, w.f.enthalpy_of_id, a.enthalpy);  // slots are ids as yet
  put(ex, w.f.solute, a.solute);
  put(ex, w.f.mass, a.mass);
  put(ex, w.f.tag, a.tag);
  put(ex, w.f.id, a.id);
}

/// Tables of the scene.
template <class E, class T>
void put_tables(E& ex, const Frame<T>& w, const SceneConstants& c) {
  std::vector<MaterialRow<T>> materials;
  for (const MaterialRow<double>& m : c.materials) {
    materials.push_back(round_row<T>(m));
    if (w.f.properties != nullptr && m.tables != nullptr)
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
                       r.temperature, static_cast<T>(r.source), r.from, r.until});
  put(ex, w.f.heat_regions, regions);
  put(ex, w.f.heat_region_cells, c.heat_region_cells);
  std::vector<BodyHeat<T>> body_heat;
  for (const BodyHeat<double>& b : c.body_heat)
    body_heat.push_back({round_condition<T>(b.surface), static_cast<T>(b.source)});
  put(ex, w.f.body_heat, body_heat);
}

/// Those channels of the lattice and its state that are in `which`.
template <class E, class T>
void put_lattice(E& ex, const Frame<T>& w, const SceneLattice& l, const SceneState& s, FieldSet which) {
  const auto wanted = [which](int field, auto* to) { return ((which >> field) & 1u) != 0 ? to : nullptr; };
  put(ex, wanted(field_vertex_of_id, w.f.vertex_of_id), s.vertex_of_id);
  put(ex, wanted(field_vertex_id, w.f.vertex_id), s.vertex_id);
  put(ex, wanted(field_vertex_site, w.f.vertex_site), l.vertex_site);
  put(ex, wanted(field_vertex_body, w.f.vertex_body), l.vertex_body);
  put(ex, wanted(field_vertex_state, w.f.vertex_state), s.vertex_state);
  put(ex, wanted(field_vertex_piece, w.f.vertex_piece), s.vertex_piece);
  if (wanted(field_region_rotation, w.f.region_rotation) != nullptr) {
    std::vector<Quat<T>> q;
    for (const Quat<double>& r : s.region_rotation)
      q.push_back({static_cast<T>(r.w), static_cast<T>(r.x), static_cast<T>(r.y), static_cast<T>(r.z)});
    put(ex, w.f.region_rotation, q);
  }
  put(ex, wanted(field_rigid_rotation, w.f.rigid_rotation), s.region_rotation);
  if (wanted(field_contact_slip, w.f.contact_slip) != nullptr) {
    std::vector<Vec3<T>> slip;
    for (const Vec3d& x : s.contact_slip) slip.push_back(cast<T>(x));
    put(ex, w.f.contact_slip, slip);
  }
  if (wanted(field_site_vertex, w.f.site_vertex) != nullptr) put(ex, w.f.site_vertex, mark_empty_sites(l));
  put(ex, wanted(field_bodies, w.f.bodies), l.bodies);
  if (wanted(field_body_motion, w.f.body_motion) != nullptr) {
    std::vector<BodyMotionRow> rows = l.rests;
    for (std::size_t b = 0; b < rows.size(); ++b) rows[b].motion = s.motion[b];
    put(ex, w.f.body_motion, rows);
  }
  put(ex, wanted(field_mesh_points, w.f.mesh_points), s.mesh_points);
  put(ex, wanted(field_body_forces, w.f.body_forces), s.forces);
}

/// What events are compared with, and those that the host has not taken.
template <class E, class T>
void put_events(E& ex, const Frame<T>& w, const std::vector<std::uint32_t>& tags, const SceneState& s) {
  if (w.f.event_head == nullptr) return;
  put(ex, w.f.seen_tag, tags);
  put(ex, w.f.seen_piece, s.vertex_piece);
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
  status.heat_in = s.heat_in;
  status.particles = w.born;
  status.heat_idle = s.heat_level ? idle_level : 0u;
  if (w.f.status != nullptr) ex.upload(w.f.status, &status, sizeof status);
}

/// Waits; the State channels of the lattice that are there.
template <class E, class T>
void download_lattice(const E& ex, const Frame<T>& w, SceneState& s) {
  if (w.f.vertex_of_id != nullptr) s.vertex_of_id = fetch(ex, w.f.vertex_of_id, w.born);
  if (w.f.vertex_id != nullptr) s.vertex_id = fetch(ex, w.f.vertex_id, w.vertices);
  if (w.f.vertex_state != nullptr) s.vertex_state = fetch(ex, w.f.vertex_state, w.vertices);
  if (w.f.vertex_piece != nullptr) s.vertex_piece = fetch(ex, w.f.vertex_piece, w.vertices);
  if (w.f.region_rotation != nullptr) {
    const auto q = fetch(ex, w.f.region_rotation, w.vertices);
    s.region_rotation.resize(q.size());
    for (std::size_t v = 0; v < q.size(); ++v)
      s.region_rotation[v] = {static_cast<double>(q[v].w), static_cast<double>(q[v].x),
                              static_cast<double>(q[v].y), static_cast<double>(q[v].z)};
  }
  if (w.f.rigid_rotation != nullptr) {
    const auto q = fetch(ex, w.f.rigid_rotation, w.vertices);
    const auto body = fetch(ex, w.f.vertex_body, w.vertices);
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
  if (w.f.contact_slip != nullptr) {
    const auto slip = fetch(ex, w.f.contact_slip, w.vertices);
    s.contact_slip.resize(slip.size());
    for (std::size_t v = 0; v < slip.size(); ++v) s.contact_slip[v] = cast<double>(slip[v]);
  }
}

/// Waits; every State channel in order of id.
template <class E, class T>
void download_state(const E& ex, const Frame<T>& w, SceneState& s) {
  const std::size_t n = w.born, slots = w.particles;
  const auto position = fetch(ex, w.f.position, slots), velocity = fetch(ex, w.f.velocity, slots);
  const bool moved = w.f.enthalpy != nullptr;
  const auto enthalpy = fetch(ex, moved ? w.f.enthalpy : w.f.enthalpy_of_id, slots);
  const auto mass = fetch(ex, w.f.mass, slots);
  const auto tag = fetch(ex, w.f.tag, slots), id = fetch(ex, w.f.id, slots);
  for (std::uint32_t k = 0; k < w.species && w.f.solute != nullptr; ++k) {
    const auto solute = fetch(ex, w.f.solute + k * w.capacity, slots);
    s.solute[k].resize(n);
    for (std::size_t i = 0; i < slots; ++i)
      if (id[i] < n) s.solute[k][id[i]] = solute[i];
  }
  s.position.resize(n);
  s.velocity.resize(n);
  s.enthalpy.resize(n);
  s.mass.resize(n);
  s.volume.resize(n);
  s.tag.resize(n);
  s.vertex_of_id.resize(n, none);
  for (std::size_t i = 0; i < slots; ++i) {
    const std::uint32_t k = id[i];
    if (k >= n) continue;  // to come
    s.position[k] = cast<double>(xyz(position[i]));
    s.velocity[k] = cast<double>(xyz(velocity[i]));
    s.enthalpy[k] = enthalpy[moved ? i : k];
    s.mass[k] = static_cast<double>(mass[i]);
    s.volume[k] = static_cast<double>(position[i].w);
    s.tag[k] = tag[i];
  }
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
    s.heat_in = status.heat_in;
    s.heat_level = (status.heat_idle & idle_level) != 0u;
  }
}

/// Waits. rolled_back: the World halted. What it has of that sub-step stands in the order of that one, which is not the
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
