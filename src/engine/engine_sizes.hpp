// SPDX-License-Identifier: Apache-2.0
// How much memory the channels of a scene take, and by what that depends on the backend.
#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/engine.hpp"
#include "exec/gather.hpp"
#include "exec/lane_positions.hpp"
#include "frame/frame.hpp"
#include "frame/lattice.hpp"
#include "pipeline/fusions.hpp"
#include "spatial/neighbour_words.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// How much of everything a scene takes.
struct Sizes {
  std::uint64_t count[static_cast<int>(Owner::world) + 1] = {};
  std::uint64_t groups = 0, rows = 9;
  std::uint64_t cells = 0;      ///< where they are counted one by one
  bool spare_position = false;  ///< accelerations have room for positions
  int reach = 1;
  std::uint64_t tree_first[Tree<float>::most_levels] = {};
  int tree_levels = 0;
};

/// What depends on the backend goes as on a GPU: on a CPU, too, where both are to have the same bits.
template <class E>
inline constexpr bool as_gpu = E::lists || !sums_by_lanes;

inline bool double_buffered(int field) {
  const FieldInfo& f = field_table[static_cast<std::size_t>(field)];
  return (f.owner == Owner::particle || f.owner == Owner::particle_species) && f.lifetime == Lifetime::State;
}

inline bool is_periodic(const SceneConstants& c, int axis) {
  return c.domain.bounded && c.domain.faces[static_cast<std::size_t>(2 * axis)] == Face::periodic;
}

/// A CPU finds all neighbours of a particle in one go.
template <class E>
std::uint32_t word_parts(std::uint64_t slots) {
  return runs_lanes<E> ? 1u : shared_parts(slots);
}

/// Entries of neighbour_words for at most so many particles.
template <class E>
std::uint64_t most_words(const SceneConstants& c, std::uint64_t capacity, std::uint64_t rows) {
  const auto entries = [&](std::uint64_t n) {
    const std::uint32_t parts = word_parts<E>(n);
    const std::uint32_t room =
        spatial::words_room(c.support / c.spacing, static_cast<std::uint32_t>(rows), parts);
    return std::uint64_t{parts} * (room + 1u) * spatial::words_stride(n);
  };
  return std::max(entries(capacity), entries(std::min(capacity, gather_few - 1u)));
}

/// fuses: sph.advance pays.
template <class E>
Sizes sizes_of(const SceneConstants& c, const SceneLattice& l, const EngineSetup& s, bool fuses) {
  Sizes n;
  const auto set = [&n](Owner o, std::uint64_t v) { n.count[static_cast<int>(o)] = v; };
  n.groups = s.particle_capacity;
  if (c.domain.bounded) n.groups = std::min(n.groups, cell_count(c.domain, c.support, 1));
  if ((s.facts & fact_packed) != 0) {
    n.reach = std::max(1, packed_reach(c.domain, c.support, s.particle_capacity));
    n.cells = n.groups = cell_count(c.domain, c.support, n.reach);
  }
  n.rows = is_periodic(c, 0) ? 18 : 9;
  if ((s.facts & fact_tree) != 0) {
    n.groups = s.particle_capacity;  // a leaf may hold one particle only
    n.rows = tree_rows;
    std::uint64_t nodes = 0;
    for (std::uint64_t level = n.groups; level != 0; level = level == 1 ? 0 : (level + 7) / 8) {
      n.tree_first[n.tree_levels++] = nodes;
      nodes += level;
    }
    set(Owner::tree_node, nodes);
  }
  n.spare_position = fuses && (s.facts & fact_fluid) != 0 &&
                     (s.facts & fusion_table[fusion_advance].never) == 0 &&
                     l.vertex_site.empty();  // what was solid keeps sph.advance away
  set(Owner::particle, s.particle_capacity);
  set(Owner::particle_species, s.particle_capacity * c.species.size());
  set(Owner::particle_list, E::lists ? s.particle_capacity + 1 : 0);
  set(Owner::particle_bits, s.particle_capacity / 32 + 2);
  set(Owner::particle_words, most_words<E>(c, s.particle_capacity, n.rows));
  set(Owner::id, s.particle_capacity);
  set(Owner::cell, n.cells + 2);
  set(Owner::cell_count, n.cells != 0 ? E::count_room(n.cells + 1) : 0);
  set(Owner::group, n.groups + 1);
  set(Owner::group_rows, n.groups * n.rows);
  set(Owner::vertex, l.vertex_site.size());
  set(Owner::vertex_fits, 4 * l.vertex_site.size());
  const bool rows = l.max_half_width >= least_row_width(as_gpu<E>, l.vertex_site.size());
  set(Owner::vertex_rows, rows ? 7 * l.vertex_site.size() : 0);
  set(Owner::vertex_list, rows && E::lists ? l.vertex_site.size() + 1 : 0);
  set(Owner::vertex_words, l.vertex_site.size() * words_for(l.max_half_width));
  set(Owner::site, l.site_vertex.size());
  set(Owner::site_words, l.site_vertex.empty() ? 0 : l.site_vertex.size() / 32 + 2);
  set(Owner::mesh_point, l.mesh_points);
  set(Owner::body, l.bodies.size());
  set(Owner::material, c.materials.size());
  set(Owner::species, c.species.size());
  set(Owner::property, c.properties.size());
  set(Owner::emitter_point, c.emitter_points.size());
  set(Owner::heat_region, c.heat_regions.size());
  set(Owner::heat_region_word, c.heat_region_cells.size());
  const std::uint64_t touch = touch_entries(l.bodies.size(), c.event_kinds);
  set(Owner::touch_entry, touch);
  set(Owner::event_item, c.event_kinds != 0u ? s.particle_capacity + l.vertex_site.size() + touch : 0);
  set(Owner::event, c.event_capacity);
  set(Owner::world, 1);
  return n;
}

/// Of a channel, one of its buffers.
template <class T>
std::uint64_t field_bytes(int field, const Sizes& n) {
  static constexpr std::uint64_t item[] = {
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) sizeof(type),
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
  };
  const std::uint64_t size = field == field_acceleration && n.spare_position ? sizeof(Vec4<T>) : item[field];
  return size * n.count[static_cast<int>(field_table[field].owner)];
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
