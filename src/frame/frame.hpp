// SPDX-License-Identifier: Apache-2.0
// Frame: the one argument of every body. Raw views of all channels, sizes, and constants of the step.
// Trivially copyable; passed to kernels by value.
#pragma once

#include <cstdint>

#include "frame/event_rows.hpp"
#include "frame/force_sums.hpp"
#include "frame/piece_sums.hpp"
#include "frame/rigid_sums.hpp"
#include "frame/search_types.hpp"
#include "frame/seepage_sums.hpp"
#include "frame/world_status.hpp"
#include "meltsim/material.hpp"
#include "meltsim/particle_tag.hpp"
#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/force_field.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/heat_boundary.hpp"
#include "meltsim/physics/inlet.hpp"
#include "meltsim/physics/material_table.hpp"
#include "meltsim/physics/math.hpp"
#include "meltsim/physics/mesh_motion.hpp"
#include "meltsim/physics/outlet.hpp"
#include "meltsim/physics/path.hpp"
#include "meltsim/physics/proxy.hpp"
#include "meltsim/physics/rigid_motion.hpp"
#include "meltsim/physics/rigid_push.hpp"
#include "meltsim/physics/sampling.hpp"
#include "meltsim/physics/shape_matching.hpp"
#include "meltsim/physics/solute.hpp"
#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"
#include "meltsim/physics/wall_exchange.hpp"
#include "meltsim/physics/walls.hpp"
#include "meltsim/stage_clock.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

using physics::FieldAccount;
using physics::ForceFields;
using physics::MaterialProperties;
using physics::MaterialRow;
using physics::MeshPoint;
using physics::RegionFit;
using physics::RigidPieceStep;
using physics::SpeciesRow;
using physics::SphKernel;
using physics::WallBox;

inline constexpr std::uint32_t none = 0xffffffffu;
inline constexpr std::uint64_t removed_key = ~std::uint64_t{0};

/// Values of vertex_state: no particle, a solid one, one that melted in this sub-step.
inline constexpr std::uint32_t vertex_free = 0, vertex_live = 1, vertex_melted = 2;

/// Values of site_vertex at a site without a vertex: there is none within w along x either; none along x and y.
inline constexpr std::uint32_t empty_row = 0xfffffffeu, empty_plane = 0xfffffffdu;
MELTSIM_HD bool is_vertex(std::uint32_t n) { return n < empty_plane; }

/// Slots [begin, end).
struct Range {
  std::uint32_t begin = 0, end = 0;
};

/// Neighbours among 32 slots: bit k, slot first + k.
struct alignas(8) NeighbourWord {
  std::uint32_t first, bits;
};

/// A resistivity (1/k) below 0 marks a particle that holds both phases; its size is that of their mixture.
template <class T>
struct alignas(2 * sizeof(T)) HeatOperand {
  T temperature{}, resistivity{};
};

/// Heat that reaches a particle from outside, computed once per sub-step.
template <class T>
struct HeatBoundary {
  T area{}, depth{};       ///< dry surface [m^2], how deep beneath it the particle is [m]
  T source{};              ///< heat released inside [W]
  std::uint32_t held = 0;  ///< 1: a region holds its temperature
};

/// The recurrence of a super-step for the sum over all particles: it is linear, so the sum obeys it too.
struct HeatAccount {
  double rate = 0;  ///< of the current stage [W]; the jump of what a region took hold of [J]
  double rate0 = 0, increment = 0, increment_old = 0;
  double step = 0;  ///< what came in during this sub-step [J]
};

/// How a region moves from where it was built: not at all; displacement + velocity (t - since); along its path.
inline constexpr std::uint32_t region_rests = 0, region_goes_on = 1, region_on_path = 2;
/// A region of space on its own grid of spacing-sized cells, in stored coordinates.
template <class T>
struct HeatRegionRow {
  Vec3<T> min{};
  T inv_cell{};  ///< 1/m
  std::int32_t nx = 0, ny = 0, nz = 0;
  std::uint32_t first_word = 0;  ///< of its bits
  std::uint32_t held = 0;
  double temperature = 0;                     ///< degrees Celsius
  T source{};                                 ///< W/m^3
  double from = 0, until = 0;                 ///< s
  std::uint32_t moves = 0;                    ///< one of those below
  std::uint32_t first_point = 0, points = 0;  ///< of its path
  double since = 0;                           ///< s
  Vec3<double> displacement{};                ///< m
  Vec3<double> velocity{};                    ///< m/s
};

template <class T>
struct BodyHeat {
  physics::SurfaceCondition<T> surface;
  T source{};  ///< W/m^3
};

/// A body's box of lattice sites, padded so that no look-up leaves it.
struct BodyRow {
  std::uint32_t stride_y = 0, stride_z = 0;  ///< sites per step in y, z (x: 1)
  std::int32_t region_half_width = 0;        ///< w
  std::uint32_t motion = 0;                  ///< one of those below
  std::uint32_t first_site = 0;              ///< number of site (0, 0, 0) of its box
  std::uint32_t watched = 0;                 ///< 1: what acts on it is summed (channel body_forces)
  /// Sites along an axis of a body that reaches around it, from one periodic face to the other; 0: it does not.
  std::uint32_t around[3] = {};
  std::uint32_t pad = 0;  ///< sites beyond its box on every side, without a vertex
  /// At alpha = 1, of a bar as long as it (shape_matching.hpp); more where its modulus is out of reach.
  double wave_speed2 = 0;
};
inline constexpr std::uint32_t body_free = 0, body_fixed = 1, body_kinematic = 2, body_rigid = 3,
                               body_proxy = 4;
/// Whether a body moves as a whole by the sums over its pieces.
MELTSIM_HD bool moves_rigidly(const BodyRow& b) { return b.motion == body_rigid || b.motion == body_proxy; }

/// The motion of a kinematic body or proxy, and where its lattice is relative to the pivot. Of a rigid body only
/// spacing.
struct BodyMotionRow {
  physics::RigidMotion motion;       ///< positions in stored coordinates; of a proxy: physics/proxy.hpp
  Vec3<double> low{};                ///< of site (0, 0, 0) of the body's box from the pivot, as built [m]
  double spacing = 0;                ///< in double, as `low` [m]
  std::uint32_t first_vertex = 0;    ///< of the body
  std::uint32_t first_point = none;  ///< of its vertices in mesh_points; none: it does not deform
  double mass = 0;                   ///< of a proxy [kg]
  Mat3<double> inertia{};  ///< of a proxy, about its centre of mass in the lattice as built [kg m^2]
};

/// An impulse on a body, between sub-steps.
struct PushRow {
  MassReach reach;
  SumUnits units;
  MassCounts counts;
  physics::RigidPush push;
};

/// What outlets against a level do in this sub-step, per face.
template <class T>
struct OutletFlow {
  physics::OutletSums sums[6];
  physics::InletSums inlet[6];
  T speed[6]{};  ///< [m/s]
  T depth[6]{};  ///< of what comes in [m]
};

/// Where and what liquid comes in to ids reserved for it: below a level beyond a face, or as the layer of a nozzle that recycles.
template <class T>
struct Inlet {
  std::uint32_t first_point = 0, points = 0;  ///< of a layer
  std::uint32_t first_id = 0, ids = 0;
  Vec3<T> center{}, inwards{}, up{};  ///< of the face, in stored coordinates; unit vectors
  T middle{};                         ///< height of the centre above the floor [m]
  T distance{};                       ///< from layer to layer [m]
  T layer{};                          ///< from point to point along `up` [m]
  double area = 0, head = 0;          ///< B H [m^2], h_L [m]
  double enthalpy = 0;                ///< of every particle [J]
  double solute[most_species] = {};   ///< likewise [kg]
  T mass{}, volume{};
  std::uint32_t tag = 0;
  std::uint32_t on = 0;   ///< of a face; 0: nothing comes in
  Vec3<T> velocity{};     ///< of a nozzle
  std::uint64_t due = 0;  ///< of a nozzle: index of the sub-step at whose end the layer is at `center`
};

/// Rows of Inlets: faces, then nozzles.
inline constexpr std::uint32_t first_nozzle = 6, most_recycling = 8,
                               inlet_rows = first_nozzle + most_recycling;

template <class T>
struct Inlets {
  Inlet<T> row[inlet_rows];
};

template <class T>
struct Clock : StageClock {
  T dt{}, half_dt{};            ///< of this sub-step [s]
  T spring_dt{};                ///< step that goals and contacts use (physics/integrate.hpp) [s]
  std::uint64_t step = 0;       ///< index of this sub-step, from 1
  double end = 0;               ///< at its end [s]
  std::uint64_t sampled = 0;    ///< bit per probe: due in this sub-step
  std::uint64_t sample_at = 0;  ///< where their values begin in ProbeViews::values
  // Settings that a host may change between sub-steps; they are here because the arguments of step.begin are set each time.
  Vec3<T> gravity{};
  physics::SurfaceCondition<T> wall_heat[6];  ///< per face
  std::uint32_t heated_walls = 0;             ///< bit per face: its heat is not insulated
  physics::SurfaceCondition<T> free_surface;  ///< of liquids
  std::uint32_t uneven_conductors = 0;        ///< 1: Surroundings::uneven_conductors
  /// Whether what begins at one time and ends before another acts in this sub-step: by its middle, since sub-steps begin and end with it.
  MELTSIM_HD bool within(double from, double until) const {
    const double middle = this->time + 0.5 * (end - this->time);
    return middle >= from && middle < until;
  }
};

/// The double-buffered channels (owner particle or particle_species, lifetime State): the copy that holds the last good state.
template <class T>
struct PreviousViews {
#define MELTSIM_MOVED(name, type) const type* name = nullptr;
#include "meltsim/fields.def"
};

/// Where sph.advance writes the state at the end of the sub-step, because other threads still read that of its middle.
template <class T>
struct NextViews {
  Vec4<T>* position = nullptr;
  Vec4<T>* velocity = nullptr;
};

/// Most probes of a World: a bit each in Clock::sampled.
inline constexpr std::uint32_t most_probes = 64;

/// A probe on the device: points of kind `point`, lines of kind `level`.
struct ProbeRow {
  std::uint32_t first = 0;                                  ///< of its points or lines
  std::uint32_t width = 0;                                  ///< values per point
  std::uint32_t values = 0;                                 ///< in all
  std::uint32_t fields = 0;                                 ///< bit per physics::SampleField
  std::uint32_t listed = 0;                                 ///< fields
  physics::SampleField field[physics::sample_fields] = {};  ///< in the order of their values
};

/// In stored coordinates.
template <class T>
struct ProbePoint {
  Vec3<T> x;
  std::uint32_t probe = 0;
};

/// The line of a level gauge.
struct ProbeLine {
  std::uint32_t probe = 0;
  std::uint32_t first = 0, heights = 0;  ///< its points in ProbeViews::heights
  double lowest = 0, step = 0;           ///< of them, along "up", in stored coordinates [m]
};

/// Kinds of sums over particles for probes, in the order in which they are computed.
enum class LoadKind : std::uint32_t {
  liquid_on_body,
  contact_on_body,
  liquid_on_wall,
  contact_on_wall,
  heat_of_body,
  heat_of_wall,
  flux
};
inline constexpr std::uint32_t load_kinds = 7;

/// One such sum, in stored coordinates.
struct LoadRow {
  LoadKind kind = LoadKind::flux;
  std::uint32_t probe = 0;
  std::uint32_t body = 0;  ///< index + 1, as in tags
  std::int32_t face = 0;   ///< 0..5
  std::uint32_t force = none,
                moment = none;  ///< where they go among the probe's values; of a flux mass and volume
  bool about_center = false;    ///< moments are about the body's centre of mass
  Vec3<double> about{};         ///< else about this point; of a flux the centre of the opening
  physics::Opening<double> opening;
  double heat_scale = 1;  ///< seconds of heat per second of motion
};

/// Probes (engine/probe_run.hpp); all null where there are none.
template <class T>
struct ProbeViews {
  const ProbeRow* rows = nullptr;
  const ProbePoint<T>*points = nullptr, *heights = nullptr;
  const ProbeLine* lines = nullptr;
  const LoadRow* loads = nullptr;                 ///< ordered by kind
  physics::LoadSums* load_sums = nullptr;         ///< per load
  std::uint32_t load_begin[load_kinds + 1] = {};  ///< first load of a kind
  std::uint32_t point_count = 0, height_count = 0, line_count = 0;
  const std::uint32_t* listed = nullptr;  ///< points, then heights, as CudaExec::gather_listed takes them
  T* profile = nullptr;                   ///< how much liquid there is, per height
  double* values = nullptr;               ///< samples, one after another
  // For World::sample, between sub-steps:
  const std::uint64_t* keys = nullptr;          ///< cells of particles, ascending
  const std::uint32_t* slots = nullptr;         ///< their slots
  std::uint32_t sorted = 0;                     ///< how many
  const Vec4<T>* terms = nullptr;               ///< pressure terms in w, where not in velocity
  const std::uint32_t* derived_slot = nullptr;  ///< per id: where density and terms are, if elsewhere
};

/// Working space of World::sample, an entry per particle each.
struct SampleRoom {
  std::uint64_t *keys = nullptr, *keys_sorted = nullptr;
  std::uint32_t *slots = nullptr, *slots_sorted = nullptr;
  std::uint32_t* derived_slot = nullptr;  ///< null where it is not needed
};

template <class T>
struct Views {
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) type* name = nullptr;
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
};

/// Constants of the scene.
template <class T>
struct Constants {
#define MELTSIM_CONSTANT(name, type, value, doc) type name = static_cast<type>(value);
#include "frame/constants.def"
#undef MELTSIM_CONSTANT
  SphKernel<T> kernel;
  WallBox<T> walls;
  T lowest_phi = T(1);  ///< below it the pressure falls no further: 1, or 0 with tension
  T wall_friction{};
  T wall_wetting{};  ///< cosine of the contact angle of walls
  T volume_rate{};   ///< 1 / relaxation time of a melted particle's volume [1/s]
  physics::WallExchange<T> wall_exchange;
  physics::ConductionShare<T> conduction_share;
  physics::CentralViscosity<T> central_viscosity;
  physics::FreeLayer<T> free_layer;
  std::uint32_t heat_regions = 0;
  std::uint32_t no_slip = 1;
  std::uint32_t open_faces = 0;  ///< bit per face
  physics::Outlets<T> outlets;
  std::uint32_t nozzles = 0;  ///< that recycle
  std::uint32_t inlet_first_point[inlet_rows] = {}, inlet_points[inlet_rows] = {},
                inlet_first_id[inlet_rows] = {},
                inlet_ids[inlet_rows] = {};  ///< as rows of `inlets` have them
  Vec3<T> wall_velocity[6];
  Vec3<T> domain_min{}, domain_max{};
  T gap_scale = T(1);     ///< c of gaps between bodies (physics/gap.hpp)
  T leak_distance2{};     ///< square of the distance below which liquid meets solid as a contact [m^2]
  double heat_bound = 0;  ///< largest sum_j g_ij/C_i that the stage count allows [1/s]
};

/// One burst of an emitter: a layer of its nozzle.
template <class T>
struct Burst {
  std::uint32_t first_point = 0, points = 0;
  Vec3<T> center{};  ///< of this layer, in stored coordinates
  Vec3<T> velocity{}, axis{};
  T radius{}, held{};
  Vec3<T> across{}, upright{};  ///< of a rectangle: unit vectors along its sides; of a disc 0
  T width{}, height{};          ///< its sides [m]
  double enthalpy = 0;
  double solute[most_species] = {};  ///< of every particle [kg]
  T mass{}, volume{};
  std::uint32_t tag = 0;
};

template <class T>
struct Frame {
  Views<T> f;
  PreviousViews<T> before;  ///< the state at the start of the sub-step, in its old order
  NextViews<T> next;        ///< null where sph.forces and step.integrate run one by one
  Constants<T> c;
  Grid<T> grid;
  Tree<T> tree;
  ProbeViews<T> probes;
  std::uint32_t particles = 0;   ///< slots in use: ids handed out, removed ones included, and some to come
  std::uint32_t born = 0;        ///< ids handed out
  std::uint32_t cells = 0;       ///< where they are counted one by one; else 0
  std::uint32_t max_groups = 0;  ///< upper bound of occupied cells
  std::uint32_t vertices = 0;
  std::uint32_t bodies = 0;   ///< that were added, removed ones included
  std::uint32_t species = 0;  ///< arrays of `solute`, each `capacity` long
  std::uint32_t region_words = 0;
  std::int32_t row_width = 0;  ///< half-width from which regions are summed by rows and planes
  std::uint32_t key_bits = 64;
  std::uint64_t capacity = 0;      ///< slots that there is room for
  std::uint64_t words_column = 0;  ///< a column of neighbour_words [bytes]
  std::uint32_t words_parts = 1;   ///< sets of words that a search fills, later joined
  std::uint32_t words_room = 0;    ///< words that a set holds
  bool solids = true;              ///< there are some
  bool one_liquid = false;         ///< no two materials are ever liquid
  bool slots_of_all = true;  ///< slot_of_id is kept for every particle, not only for those of slot_is_known()
  bool count_ahead = false;  ///< step.integrate counts the cells of the next sub-step, which is as long
  bool counted = false;      ///< the sub-step before did
  bool cells_begun = false;  ///< and where cells begin is known since step.begin
  // Arguments of single stages, set by the engine:
  Clock<T> clock;  ///< step.begin
  Burst<T> burst;  ///< step.emit
  std::uint32_t burst_first = 0;
  T heat_dt{};  ///< thermal.*: super-step, time-scaled [s]
  std::uint32_t heat_stages = 0, heat_supersteps = 0;
  std::uint32_t viscous_stages = 0, viscous_supersteps = 0;  ///< sph.diffuse; 0: explicit
  double viscous_dt = 0;                                     ///< of a super-step [s]
  double viscous_bound = 0;  ///< largest exchange over mass that the stages allow [1/s]
  bool inviscid = false;     ///< sph.diffuse takes viscosity in place of this stage
  double solute_dt = 0;      ///< species.exchange: of one sweep, time-scaled [s]
  std::uint32_t solute_supersteps = 0;
  double solute_bound = 0;    ///< largest exchange over mass at which contents are weighted means [1/s]
  double solute_share = 1;    ///< largest share of its mass that a particle exchanges in a sweep [-]
  bool solute_rooms = false;  ///< a species precipitates or has a heat of solution
  SumUnits sum_units;         ///< lsm.balance
  std::uint32_t event_kinds = 0, event_capacity = 0;  ///< bit per EventKind; rows of the ring
  std::uint64_t touch_entries = 0;                    ///< of the table of contacts
};

/// Content of species k of the particle at slot i [kg].
template <class T>
MELTSIM_HD double& solute_at(const Frame<T>& w, std::uint32_t k, std::uint64_t i) {
  return w.f.solute[k * w.capacity + i];
}

/// x within the period of periodic axes.
template <class T>
MELTSIM_HD Vec3<T> wrapped(const Frame<T>& w, Vec3<T> x) {
  if (w.grid.periodic == 0u) return x;
  x.x -= w.grid.period.x * std::floor((x.x - w.c.domain_min.x) * w.grid.inv_period.x);
  x.y -= w.grid.period.y * std::floor((x.y - w.c.domain_min.y) * w.grid.inv_period.y);
  x.z -= w.grid.period.z * std::floor((x.z - w.c.domain_min.z) * w.grid.inv_period.z);
  return x;
}

/// Whether slot_of_id is kept for particles with this tag; also for melted ones: a melted vertex may still be the
/// label of its piece, whose sums are taken about it.
template <class T>
MELTSIM_HD bool slot_is_known(const Frame<T>& w, std::uint32_t tag) {
  return w.slots_of_all || is_solid(tag) || is_removed(tag) || body_of(tag) != 0u;
}

/// Acceleration of the particle at slot i by gravity and force fields [m/s^2].
template <class T>
MELTSIM_HD Vec3<T> pull_at(const Frame<T>& w, std::uint64_t i) {
  const Vec3<T> gravity = w.f.clock->gravity;
  return w.f.field_acceleration != nullptr ? gravity + w.f.field_acceleration[i] : gravity;
}

/// Enthalpy of the particle at slot i, wherever the scene keeps it [J].
template <class T>
MELTSIM_HD double enthalpy_at(const Frame<T>& w, std::uint64_t i) {
  return w.f.enthalpy != nullptr ? w.f.enthalpy[i] : w.f.enthalpy_of_id[w.f.id[i]];
}

/// Whether all neighbours of a liquid particle are the same liquid of the same viscosity.
template <class T>
bool liquid_alone(const Frame<T>& w) {
  return w.one_liquid && !w.solids && w.f.viscosity == nullptr;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
