// SPDX-License-Identifier: Apache-2.0
// The scene as the host holds it: State and Static channels in order of id, always double. What is stored is
// exact in the World's precision, so upload and download lose nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "frame/frame.hpp"
#include "meltsim/desc.hpp"
#include "pipeline/pipeline.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// State of particles and lattice: what a snapshot holds.
struct SceneState {
  // Per id and per vertex, as fields.def lists them. Of rigid bodies' vertices region_rotation is what rigid_rotation holds.
#define MELTSIM_HELD(name, host, owner, channel, part, first, hashed) std::vector<host> name;
#define MELTSIM_HELD_PER_SPECIES(name, host, owner, channel, part, first, hashed) \
  std::array<std::vector<host>, most_species> name;
#include "meltsim/fields.def"
  std::vector<physics::RigidMotion>
      motion;                           ///< per body; of those that are neither kinematic nor proxies nothing
  std::vector<MeshPoint> mesh_points;   ///< SceneLattice::mesh_points of them
  std::vector<BodyForceTotals> forces;  ///< per body; no part of a snapshot
  // Where events are watched; no part of a snapshot.
  std::vector<std::uint32_t> touched;  ///< the table of contacts
  std::size_t touched_bodies = 0;      ///< its rows
  EventHead event_head;
  std::vector<EventRow> events;  ///< the ring
  std::uint64_t melted = 0, frozen = 0, removed = 0,
                strayed = 0;  ///< before the last upload; removed: strayed, too, and ids in reserve of faces
  std::uint64_t entered = 0;  ///< likewise: came in through faces
  double heat_in = 0;         ///< likewise [J]
  double field_work = 0;      ///< likewise [J]
  Vec3d field_impulse;        ///< likewise [N s]
  bool heat_level = false;    ///< temperatures are level: no heat flows
};

/// Lattices as built; changes only when a body is added.
struct SceneLattice {
  std::vector<std::uint32_t> vertex_site, vertex_body;  ///< per vertex
  std::vector<Vec3i> vertex_coordinates;                ///< on the body's lattice
  std::vector<Vec4<float>> contact_shape;               ///< per vertex, w in spacings (physics/contact.hpp)
  std::vector<std::uint32_t> site_vertex;               ///< per site
  std::vector<BodyRow> bodies;
  std::vector<BodyMotionRow> rests;  ///< per body: where its lattice is relative to the pivot; no motions
  std::uint32_t mesh_points = 0;     ///< vertices of bodies whose mesh the host moves
  int max_half_width = 0;
};

/// Settings that a host may change between sub-steps.
struct Surroundings {
  Vec3d gravity;                                                 ///< [m/s^2]
  std::array<physics::SurfaceCondition<double>, 6> wall_heat{};  ///< per face
  physics::SurfaceCondition<double> free_surface;                ///< of liquids
  bool uneven_conductors =
      false;  ///< two materials in use conduct differently and are not phases of each other
};

/// Constants in double; each engine rounds them once.
struct SceneConstants {
#define MELTSIM_CONSTANT(name, type, value, doc) double name = value;
#include "frame/constants.def"
#undef MELTSIM_CONSTANT
  double support = 0;    ///< H [m]
  double spring_dt = 1;  ///< the step that goals and contacts go by [s]
  bool tension = false;
  bool one_liquid = false;  ///< no two materials are liquid, now or by melting or emission
  Surroundings surroundings;
  DomainDesc domain;                    ///< relative to the origin, but for levels
  std::array<double, 6> outlet_head{};  ///< of the level beyond a face above the floor [m]
  std::vector<MaterialRow<double>> materials;
  std::vector<physics::MaterialProperties<double>> properties;  ///< per material, or empty
  std::vector<SpeciesRow<double>> species;  ///< none where nothing is dissolved or dissolves
  std::vector<Vec3d> emitter_points;
  double largest_mass = 0;
  std::vector<HeatRegionRow<double>> heat_regions;
  std::vector<std::uint32_t> heat_region_cells;
  std::vector<PathPoint> heat_region_path;
  std::vector<BodyHeat<double>> body_heat;            ///< per body, or empty
  std::uint32_t event_kinds = 0, event_capacity = 0;  ///< 0: events are not watched
  ForceFields<double> force_fields;
  Inlets<double> inlets;
  std::uint32_t inlet_faces = 0;  ///< bit per face: it has a row
  std::uint32_t nozzles = 0;      ///< that recycle: rows behind those of faces
};

inline bool is_periodic(const DomainDesc& d, std::size_t axis) {
  return d.bounded && d.faces[2 * axis] == Face::periodic;
}

/// Cells along one axis of a bounded domain.
inline std::int32_t cells_along(double extent, double support) {
  return static_cast<std::int32_t>(std::max(1.0, std::min(std::floor(extent / support), double(1 << 20))));
}

/// Cells in a bounded domain whose cells are support/reach long in x.
inline std::uint64_t cell_count(const DomainDesc& domain, double support, int reach) {
  const Vec3d e = domain.max - domain.min;
  return static_cast<std::uint64_t>(cells_along(e.x, support / reach)) *
         static_cast<std::uint64_t>(cells_along(e.y, support)) *
         static_cast<std::uint64_t>(cells_along(e.z, support));
}

/// How many cells shall span the support in x: 6 leave 305 candidates, 4 leave 315, 1 leaves 420 (68 neighbours, a
/// support of 2.5 spacings). 0: even so, cells are too many to be counted one by one, 4 bytes each; no more than four
/// per particle, though a few thousand cost nothing anyway, and no more than 31 bits number.
inline int packed_reach(const DomainDesc& domain, double support, std::uint64_t particles) {
  if (!domain.bounded) return 0;
  const std::uint64_t most =
      std::min(std::max<std::uint64_t>(4 * particles, 16384), (std::uint64_t{1} << 31) - 1);
  for (const int reach : {6, 4, 2, 1})
    if (cell_count(domain, support, reach) <= most) return reach;
  return 0;
}

/// Rows of a leaf of the tree; what is more is merged. 18: at 61 neighbours leaves have 12 on average, 25 at
/// most.
inline constexpr std::uint32_t tree_rows = 18;
/// Cells of the curve that H spans.
inline constexpr int tree_resolution = 4;

/// The neighbour search of a scene and the reason for its choice.
struct SearchChoice {
  NeighbourSearch search = NeighbourSearch::grid;
  FactSet facts = fact_packed;
  const char* reason = "";
};

inline SearchChoice choose_search(const WorldDesc& desc, double support, std::uint64_t particles) {
  if (desc.neighbour_search == NeighbourSearch::tree)
    return {NeighbourSearch::tree, fact_sorted | fact_tree, "asked for"};
  if (packed_reach(desc.domain, support, particles) != 0)
    return {NeighbourSearch::grid, fact_packed,
            "the domain is bounded and well filled: its cells are counted"};
  return {NeighbourSearch::grid, fact_sorted | fact_sparse,
          "the domain is unbounded or mostly empty: occupied cells are sorted"};
}

/// Sub-steps between two looks at whether temperatures are level.
inline constexpr std::uint64_t level_interval = 64;

/// Room for lattices, with bodies to come; 0: for those that are there. Beyond those that are there: the last body of the room never
/// comes, nor do its sites, the last ones; vertices to come are free ones of it.
struct LatticeRoom {
  static constexpr std::uint32_t spare_sites = 8;
  std::uint64_t vertices = 0, sites = 0, bodies = 0;
};

/// What belongs to a body that was added, beside its part of the lattice, the last one.
struct AddedBody {
  std::uint32_t body = 0, first_vertex = 0;
  std::uint64_t first_site = 0;
  double largest_mass = 0;  ///< of a particle of the scene [kg]
  BodyHeat<double> heat;
};

/// How much to allocate and which stages to run.
struct EngineSetup {
  LatticeRoom room;
  FactSet facts = 0;
  FieldSet channels = 0;
  std::uint32_t particle_capacity = 0;
  std::uint64_t searched = 0;     ///< particles that cells are made for: those without room in reserve
  int threads = 1;                ///< of the host, as WorldDesc has them: for what is uploaded
  bool heat_flows_again = false;  ///< to Engine::adapt: a source has begun
  bool heat_rests_again = false;  ///< to Engine::adapt: it has not after all, and temperatures are level
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
