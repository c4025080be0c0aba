// SPDX-License-Identifier: Apache-2.0
// The stage table as data. What its rows say is checked at compile time: fed.cpp.
#pragma once

#include <array>
#include <cstdint>

#include "pipeline/field_set.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

enum Field : int {
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) field_##name,
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
  field_count
};

/// State of particles that is copied from slot to slot as it is; it is there wherever there are particles.
inline constexpr FieldSet copied_channels = FieldSet{0}
#define MELTSIM_COPIED(name) | FieldSet{1} << field_##name
#include "meltsim/fields.def"
;

/// Parts of channels that stages touch apart from what others touch: rows of the stage table may name them in
/// place of the whole, and only the schedule (pipeline/schedule.hpp) tells them from it. A row that touches all of such
/// a channel names both.
enum Part : int {
  field_pressure_term = field_count,  ///< velocity's w
  field_acceleration_of_solids,       ///< acceleration of solid particles; under its own name that of liquid
  part_end
};
static_assert(part_end <= FieldSet::size);
struct PartInfo {
  int part, field;
};
inline constexpr PartInfo part_table[] = {{field_pressure_term, field_velocity},
                                          {field_acceleration_of_solids, field_acceleration}};

/// The channels themselves in place of their parts.
constexpr FieldSet whole(FieldSet set) {
  for (const PartInfo& p : part_table)
    if (set.has(p.part)) set = (set & ~(FieldSet{1} << p.part)) | (FieldSet{1} << p.field);
  return set;
}

enum class Owner {
  particle,
  particle_species,
  particle_list,
  particle_bits,
  particle_words,
  id,
  cell,
  cell_count,
  group,
  group_rows,
  tree_node,
  vertex,
  vertex_words,
  vertex_fits,
  vertex_rows,
  vertex_list,
  site,
  site_words,
  mesh_point,
  body,
  material,
  species,
  property,
  emitter_point,
  heat_region,
  heat_region_word,
  heat_region_point,
  touch_entry,
  event_item,
  event,
  world
};
enum class Lifetime { State, Static, Derived, Scratch };
/// Whether state_hash() includes an array of the state, as fields.def says.
enum class Hashed { always, live, freezing, never };

struct FieldInfo {
  const char* name;
  const char* type;
  Owner owner;
  const char* owner_name;
  Lifetime lifetime;
  const char* lifetime_name;
  const char* unit;
};

inline constexpr std::array<FieldInfo, field_count> field_table{{
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) \
  {#name, #type, Owner::owner, #owner, Lifetime::lifetime, #lifetime, unit},
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
}};

/// Facts of a scene, a bit each.
using FactSet = std::uint64_t;

/// Facts: what a scene contains. They decide which stages run.
enum Fact : FactSet {
  fact_particles = 1u << 0,
  fact_fluid = 1u << 1,          ///< liquid now, or later by melting or emission
  fact_solid = 1u << 2,          ///< lattice vertices
  fact_mobile = 1u << 3,         ///< bodies that can move
  fact_contact = 1u << 4,        ///< mobile bodies that can meet another body or piece
  fact_melt = 1u << 5,           ///< a solid can melt
  fact_heat_enthalpy = 1u << 6,  ///< temperatures differ, enthalpy model
  fact_heat_paper = 1u << 7,     ///< temperatures differ, paper model
  fact_heat_boundary = 1u << 8,  ///< heat comes through surfaces or from sources, enthalpy model
  fact_heat_iwasaki = 1u << 9,   ///< temperatures differ, explicit model
  fact_viscosity = 1u << 10,     ///< a liquid's viscosity depends on temperature, contents or shear rate
  fact_freeze = 1u << 11,        ///< liquid can freeze onto a body
  fact_dry = 1u << 12,           ///< no liquid, now or later
  fact_shifting = 1u << 13,      ///< liquid's particles are kept evenly spread
  fact_levels = 1u << 14,  ///< enthalpy model, nothing but what is there heats: temperatures may become level
  // How neighbours are found: one of search_facts.
  fact_packed = 1u << 15,  ///< grid; few cells of the domain are empty: they can be counted one by one
  fact_sorted = 1u << 16,  ///< particles are sorted by a key
  fact_sparse = 1u << 17,  ///< grid; the domain is unbounded or mostly empty
  fact_tree = 1u << 18,    ///< tree
  // Facts that the check below skips: their stages write channels that no other stage reads.
  fact_probes = 1u << 19,     ///< points or levels are sampled
  fact_loads = 1u << 20,      ///< forces, heat or fluxes are
  fact_kinematic = 1u << 21,  ///< bodies that the host moves
  fact_implicit = 1u << 22,   ///< viscosity is implicit
  // Kinds of movable bodies, at least one of them:
  fact_lattice = 1u << 23,  ///< free bodies, which shape matching moves
  fact_rigid = 1u << 24,    ///< rigid bodies and proxies
  // Further facts that the check skips:
  fact_forces = 1u << 25,             ///< what acts on bodies is summed
  fact_events = 1u << 26,             ///< events are noted
  fact_species = 1u << 27,            ///< something is dissolved, or dissolves
  fact_tension = 1u << 28,            ///< a liquid has surface tension
  fact_outlets = 1u << 29,            ///< liquid leaves against a level
  fact_strain = 1u << 30,             ///< a liquid's viscosity depends on its shear rate; with fact_viscosity
  fact_fields = 1u << 31,             ///< force fields; with liquid or bodies that can move
  fact_isotropic = FactSet{1} << 32,  ///< the stress of the pressure is isotropic
  fact_inlets = FactSet{1} << 33,     ///< liquid comes in below a level
  fact_walls = FactSet{1} << 34,      ///< faces of the domain are walls
  fact_reserves =
      FactSet{1} << 35,  ///< liquid comes in to ids in reserve: below a level, or from nozzles that recycle
};

inline constexpr FactSet search_facts[] = {fact_packed, fact_sorted | fact_sparse, fact_sorted | fact_tree};
inline constexpr FactSet any_search = fact_packed | fact_sorted | fact_sparse | fact_tree;

struct StageInfo {
  const char* module;
  const char* stage;
  const char* name;
  FactSet need;
  FieldSet reads, writes;
  FieldSet may;                        ///< reads or writes where the scene has them
  FieldSet reads_apart, writes_apart;  ///< reads, writes and may, parts by their own names
  const char* why;
  const char* why_not;
};

#define F(field) (FieldSet{1} << field_##field)
/// Channels that stages which may touch them only read; their producer names them among what it writes.
inline constexpr FieldSet read_where_there =
    F(viscosity) | F(body_heat) | F(cell_begin) | F(group_ranges) | F(density) | F(group_key) |
    F(group_begin) | F(tree_box) | F(piece) | F(contact_normal) | F(body_motion) | F(carried_position) |
    F(carried_velocity) | F(liquid_bits) | F(shape_velocity) | F(mesh_points) | F(site_vertex) |
    F(vertex_site) | F(field_acceleration) | F(isotropic_diagonal) | F(isotropic_mixed) | F(leak_share) |
    F(gap_push) | F(under) | F(rim_sums) | F(vertex_piece);
inline constexpr std::array stage_table{
#define MELTSIM_STAGE(module, stage, need, reads, writes, may, why, why_not)     \
  StageInfo{#module,    #stage,          #module "." #stage,                     \
            (need),     whole(reads),    whole(writes),                          \
            whole(may), (reads) | (may), (writes) | ((may) & ~read_where_there), \
            why,        why_not},
#include "pipeline/pipeline.def"
#undef MELTSIM_STAGE
};
#undef F
inline constexpr int stage_count = static_cast<int>(stage_table.size());

enum Stage : int {
#define MELTSIM_STAGE(module, stage, need, reads, writes, may, why, why_not) stage_##module##_##stage,
#include "pipeline/pipeline.def"
#undef MELTSIM_STAGE
};

constexpr bool runs(const StageInfo& stage, FactSet facts) { return (stage.need & facts) == stage.need; }

/// Facts that a real scene cannot combine otherwise.
constexpr bool consistent(FactSet f) {
  // The facts that leave the fewest combinations come first: compilers bound the work of a constant expression.
  if (((f & fact_fluid) != 0) == ((f & fact_dry) != 0)) return false;
  if (f != 0 && (f & fact_particles) == 0) return false;
  const auto implies = [f](FactSet a, FactSet b) { return (f & a) == 0 || (f & b) == b; };
  return implies(fact_mobile, fact_solid) && implies(fact_contact, fact_mobile) &&
         implies(fact_melt, fact_solid | fact_fluid) && implies(fact_freeze, fact_melt) &&
         implies(fact_shifting, fact_fluid) &&
         !((f & fact_heat_enthalpy) && (f & (fact_heat_paper | fact_heat_iwasaki))) &&
         !((f & fact_heat_paper) && (f & fact_heat_iwasaki)) &&
         implies(fact_heat_boundary, fact_heat_enthalpy) && implies(fact_levels, fact_heat_enthalpy) &&
         (f & (fact_levels | fact_heat_boundary)) != (fact_levels | fact_heat_boundary);
}

/// Channels that a scene needs: those that its stages touch and the host requests. Enthalpies that neither touches are stored by id.
constexpr FieldSet channels_for(FactSet facts, FieldSet wanted = 0) {
  FieldSet set = wanted;
  for (int i = 0; i < stage_count; ++i)
    if (runs(stage_table[i], facts)) set |= stage_table[i].reads | stage_table[i].writes;
  const FieldSet moved = FieldSet{1} << field_enthalpy;
  if ((facts & fact_particles) != 0 && (set & moved) == 0) set |= FieldSet{1} << field_enthalpy_of_id;
  return set;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
