// SPDX-License-Identifier: Apache-2.0
// Memory of the channels of a scene, and how it depends on the backend.
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

/// Numbers of items of a scene.
struct Sizes {
  std::uint64_t count[static_cast<int>(Owner::world) + 1] = {};
  std::uint64_t groups = 0, rows = 9;
  std::uint64_t cells = 0;      ///< where they are counted one by one
  bool spare_position = false;  ///< accelerations have room for positions
  int reach = 1;
  std::uint64_t tree_first[Tree<float>::most_levels] = {};
  int tree_levels = 0;
};

/// Sizes that depend on the backend are those of a GPU; also on a CPU if both must give the same bits.
template <class E>
inline constexpr bool as_gpu = E::lists || !sums_by_lanes;

inline bool double_buffered(int field) {
  const FieldInfo& f = field_table[static_cast<std::size_t>(field)];
  return (f.owner == Owner::particle || f.owner == Owner::particle_species) && f.lifetime == Lifetime::State;
}

/// A CPU finds all neighbours of a particle in one pass.
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

inline void set_size(Sizes& n, Owner owner, std::uint64_t count) { n.count[static_cast<int>(owner)] = count; }

/// Slots or vertices that kernels run over, of a room for so many: in steps, so that what comes little by little does not make every
/// sub-step differ from the last one.
inline std::uint32_t stepped(std::uint64_t used, std::uint64_t room) {
  const std::uint64_t step = std::max<std::uint64_t>(room / 8, 1);
  if (used == 0) return 0;
  return static_cast<std::uint32_t>(std::min(room, (used + step - 1) / step * step));
}

/// Sizes of the neighbour search: cells, or levels of the tree.
inline void size_search(Sizes& n, const SceneConstants& c, const EngineSetup& s) {
  n.groups = s.particle_capacity;
  if (c.domain.bounded) n.groups = std::min(n.groups, cell_count(c.domain, c.support, 1));
  if ((s.facts & fact_packed) != 0) {
    n.reach = std::max(1, packed_reach(c.domain, c.support, s.searched));
    n.cells = n.groups = cell_count(c.domain, c.support, n.reach);
  }
  n.rows = is_periodic(c.domain, 0) ? 18 : 9;
  if ((s.facts & fact_tree) == 0) return;
  n.groups = s.particle_capacity;  // a leaf may hold one particle only
  n.rows = tree_rows;
  std::uint64_t nodes = 0;
  for (std::uint64_t level = n.groups; level != 0; level = level == 1 ? 0 : (level + 7) / 8) {
    n.tree_first[n.tree_levels++] = nodes;
    nodes += level;
  }
  set_size(n, Owner::tree_node, nodes);
}

template <class E>
void size_particles(Sizes& n, const SceneConstants& c, std::uint64_t capacity) {
  set_size(n, Owner::particle, capacity);
  set_size(n, Owner::particle_species, capacity * c.species.size());
  set_size(n, Owner::particle_list, E::lists ? capacity + 1 : 0);
  set_size(n, Owner::particle_bits, capacity / 32 + 2);
  set_size(n, Owner::particle_words, most_words<E>(c, capacity, n.rows));
  set_size(n, Owner::id, capacity);
  set_size(n, Owner::cell, n.cells + 2);
  set_size(n, Owner::cell_count, n.cells != 0 ? E::count_room(n.cells + 1) : 0);
  set_size(n, Owner::group, n.groups + 1);
  set_size(n, Owner::group_rows, n.groups * n.rows);
}

template <class E>
void size_lattices(Sizes& n, const SceneLattice& l, const LatticeRoom& room) {
  const std::uint64_t vertices = std::max<std::uint64_t>(l.vertex_site.size(), room.vertices);
  const std::uint64_t sites = std::max<std::uint64_t>(l.site_vertex.size(), room.sites);
  const bool rows = l.max_half_width >= least_row_width(as_gpu<E>, vertices);
  set_size(n, Owner::vertex, vertices);
  set_size(n, Owner::vertex_fits, 4 * vertices);
  set_size(n, Owner::vertex_rows, rows ? 7 * vertices : 0);
  set_size(n, Owner::vertex_list, rows && E::lists ? vertices + 1 : 0);
  set_size(n, Owner::vertex_words, vertices * words_for(l.max_half_width));
  set_size(n, Owner::site, sites);
  set_size(n, Owner::site_words, sites == 0 ? 0 : sites / 32 + 2);
  set_size(n, Owner::mesh_point, l.mesh_points);
  set_size(n, Owner::body, std::max<std::uint64_t>(l.bodies.size(), room.bodies));
}

inline void size_tables(Sizes& n, const SceneConstants& c) {
  constexpr std::uint64_t few = 16;  // materials that may come without another table
  set_size(n, Owner::material, (c.materials.size() + few - 1) / few * few);
  set_size(n, Owner::species, c.species.size());
  set_size(n, Owner::property, c.properties.size());
  set_size(n, Owner::emitter_point, c.emitter_points.size());
  set_size(n, Owner::heat_region, c.heat_regions.size());
  set_size(n, Owner::heat_region_word, c.heat_region_cells.size());
  set_size(n, Owner::heat_region_point, c.heat_region_path.size());
  set_size(n, Owner::world, 1);
}

/// After size_lattices().
inline void size_events(Sizes& n, const SceneConstants& c, std::uint64_t capacity) {
  const auto items = [&n](Owner owner) { return n.count[static_cast<int>(owner)]; };
  const std::uint64_t touch = touch_entries(items(Owner::body), c.event_kinds);
  set_size(n, Owner::touch_entry, touch);
  set_size(n, Owner::event_item, c.event_kinds != 0u ? capacity + items(Owner::vertex) + touch : 0);
  set_size(n, Owner::event, c.event_capacity);
}

/// fuses: sph.advance pays.
template <class E>
Sizes sizes_of(const SceneConstants& c, const SceneLattice& l, const EngineSetup& s, bool fuses) {
  Sizes n;
  size_search(n, c, s);
  n.spare_position = fuses && (s.facts & fact_fluid) != 0 &&
                     (s.facts & fusion_table[fusion_advance].never) == 0 &&
                     l.vertex_site.empty();  // what was solid keeps sph.advance away
  size_particles<E>(n, c, s.particle_capacity);
  size_lattices<E>(n, l, s.room);
  size_tables(n, c);
  size_events(n, c, s.particle_capacity);
  return n;
}

/// Size of one buffer of a channel.
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
