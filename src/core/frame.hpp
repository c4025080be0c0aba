// SPDX-License-Identifier: Apache-2.0
// Frame: the one argument of every body. Raw views of all channels, sizes, and constants of the step.
// Trivially copyable; passed to kernels by value.
#pragma once

#include <cstdint>

#include "meltsim/particle_tag.hpp"
#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/heat_boundary.hpp"
#include "meltsim/physics/material_table.hpp"
#include "meltsim/physics/math.hpp"
#include "meltsim/physics/shape_matching.hpp"
#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/wall_exchange.hpp"
#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

using physics::MaterialProperties;
using physics::MaterialRow;
using physics::RegionFit;
using physics::SphKernel;
using physics::WallBox;

inline constexpr std::uint32_t none = 0xffffffffu;
inline constexpr std::uint64_t removed_key = ~std::uint64_t{0};

/// Of site_vertex, where there is no vertex: and none within w along x either; nor along x and y.
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

/// What reaches a particle from outside, worked out once per sub-step.
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

/// A region of space on its own grid of spacing-sized cells, in stored coordinates.
template <class T>
struct HeatRegionRow {
  Vec3<T> min{};
  T inv_cell{};  ///< 1/m
  std::int32_t nx = 0, ny = 0, nz = 0;
  std::uint32_t first_word = 0;  ///< of its bits
  std::uint32_t held = 0;
  double temperature = 0;      ///< degrees Celsius
  T source{};                  ///< W/m^3
  double from = 0, until = 0;  ///< s
};

template <class T>
struct BodyHeat {
  physics::SurfaceCondition<T> surface;
  T source{};  ///< W/m^3
};

/// Exact sums over a piece: integers in units chosen by the host, so that no order of addition changes a bit.
struct PieceSums {
  std::int64_t mass = 0;
  std::int64_t momentum[3] = {}, spin[3] = {}, first[3] = {}, second[6] = {};
  static constexpr int words = 16;  ///< all of them, one after the other
};
static_assert(sizeof(PieceSums) == PieceSums::words * sizeof(std::int64_t));

/// What one integer of a sum stands for, a power of two, and how many make one of it.
struct SumUnit {
  double size = 1, per = 1;
};

/// Of mass [kg], momentum [kg m/s], spin [kg m^2/s], first [kg m] and second [kg m^2].
struct SumUnits {
  SumUnit mass, momentum, spin, first, second;
};

/// Units at least as large as these and at most twice as large.
inline SumUnits sum_units(double mass, double momentum, double spin, double first, double second) {
  const auto unit = [](double least) {
    const int exponent = std::ilogb(least) + 1;
    return SumUnit{std::ldexp(1.0, exponent), std::ldexp(1.0, -exponent)};
  };
  return {unit(mass), unit(momentum), unit(spin), unit(first), unit(second)};
}

MELTSIM_HD physics::RigidResidual residual_of(const PieceSums& s, const SumUnits& q) {
  physics::RigidResidual r;
  const auto d = [](std::int64_t n, const SumUnit& unit) { return static_cast<double>(n) * unit.size; };
  r.mass = d(s.mass, q.mass);
  r.momentum = {d(s.momentum[0], q.momentum), d(s.momentum[1], q.momentum), d(s.momentum[2], q.momentum)};
  r.spin = {d(s.spin[0], q.spin), d(s.spin[1], q.spin), d(s.spin[2], q.spin)};
  r.first = {d(s.first[0], q.first), d(s.first[1], q.first), d(s.first[2], q.first)};
  const double xx = d(s.second[0], q.second), yy = d(s.second[1], q.second), zz = d(s.second[2], q.second);
  const double yz = d(s.second[3], q.second), zx = d(s.second[4], q.second), xy = d(s.second[5], q.second);
  r.second.m[0][0] = xx;
  r.second.m[1][1] = yy;
  r.second.m[2][2] = zz;
  r.second.m[1][2] = r.second.m[2][1] = yz;
  r.second.m[0][2] = r.second.m[2][0] = zx;
  r.second.m[0][1] = r.second.m[1][0] = xy;
  return r;
}

/// A body's box of lattice sites, padded so that no look-up leaves it.
struct BodyRow {
  std::uint32_t stride_y = 0, stride_z = 0;  ///< sites per step in y, z (x: 1)
  std::int32_t region_half_width = 0;        ///< w
  std::uint32_t fixed = 0;
};

template <class T>
struct Clock {
  T dt{}, half_dt{};          ///< of this sub-step [s]
  T spring_dt{};              ///< what goals and contacts go by (physics/integrate.hpp) [s]
  std::uint64_t step = 0;     ///< index of this sub-step, from 1
  double time = 0;            ///< at its start [s]
  std::uint32_t rebuild = 0;  ///< 1: a kept grid is not kept
};

/// Which check stopped the World; order = order of the stages.
enum class Halt : std::uint32_t { no = 0, position, density, force, shape, heat, speed };

/// Sums over all particles as they are, in stored coordinates.
struct LedgerSums {
  double mass = 0;
  Vec3<double> momentum, angular_momentum;  ///< about the stored origin
  double kinetic = 0, potential = 0;        ///< potential at the stored origin is 0
  double thermal = 0, latent = 0;
  MELTSIM_HD static LedgerSums combine(LedgerSums a, const LedgerSums& b) {
    a.mass += b.mass;
    a.momentum += b.momentum;
    a.angular_momentum += b.angular_momentum;
    a.kinetic += b.kinetic;
    a.potential += b.potential;
    a.thermal += b.thermal;
    a.latent += b.latent;
    return a;
  }
};

/// What a sub-step comes to: the worst of all particles, how many left, how far liquid is compressed. Ties go to the
/// smaller id, so that nothing hangs on the order.
struct CheckResult {
  double max_speed = 0, max_density = 0;
  std::uint64_t excess = 0;  ///< sum of rho/rho0 - 1 where above 0, in units of 1/excess_units
  double bad_value = 0;
  std::uint32_t dense = 0, removed = 0;  ///< how many are in that sum; how many left
  std::uint32_t bad = 0;                 ///< Halt
  std::uint32_t bad_id = 0xffffffffu;
  static constexpr double excess_units = 1u << 22, most_excess = 16;  // a warp's sum fits 32 bits
  MELTSIM_HD static CheckResult combine(const CheckResult& a, const CheckResult& b) {
    CheckResult r;
    r.max_speed = maximum(a.max_speed, b.max_speed);
    r.max_density = maximum(a.max_density, b.max_density);
    r.excess = a.excess + b.excess;
    r.dense = a.dense + b.dense;
    r.removed = a.removed + b.removed;
    const bool take_b =
        b.bad != 0u && (a.bad == 0u || b.bad < a.bad || (b.bad == a.bad && b.bad_id < a.bad_id));
    r.bad = take_b ? b.bad : a.bad;
    r.bad_id = take_b ? b.bad_id : a.bad_id;
    r.bad_value = take_b ? b.bad_value : a.bad_value;
    return r;
  }
  /// Into what others hand in as well, where nothing is bad. Add: raise(x, v), x = max(x, v) for v >= 0, and add(x, n).
  template <class Add>
  MELTSIM_HD void hand_in(CheckResult& to, const Add& add) const {
    add.raise(to.max_speed, max_speed);
    add.raise(to.max_density, max_density);
    if (dense != 0u) {
      add.add(to.excess, excess);
      add.add(to.dense, dense);
    }
    if (removed != 0u) add.add(to.removed, removed);
  }
};

/// The same of one particle.
template <class T>
struct ParticleCheck {
  T speed{}, phi{};
  std::uint32_t excess = 0, counts = 0;  ///< counts: 65,536 where dense, and 1 where it left
  std::uint32_t bad = 0, bad_id = 0xffffffffu;
  double bad_value = 0;
  static constexpr std::uint32_t dense = 1u << 16;
  MELTSIM_HD bool plain() const { return bad == 0u; }
  MELTSIM_HD CheckResult result() const {
    CheckResult r = of(speed, phi, excess, counts);
    r.bad = bad;
    r.bad_id = bad_id;
    r.bad_value = bad_value;
    return r;
  }
  /// Of up to 32 at once, where none is bad. Lanes: largest(x), x >= 0, and sum(n) over all of them.
  template <class Lanes>
  MELTSIM_HD CheckResult over(const Lanes& lanes) const {
    return of(lanes.largest(speed), lanes.largest(phi), lanes.sum(excess), lanes.sum(counts));
  }

 private:
  MELTSIM_HD static CheckResult of(T speed, T phi, std::uint32_t excess, std::uint32_t counts) {
    CheckResult r;
    r.max_speed = static_cast<double>(speed);
    r.max_density = static_cast<double>(phi);
    r.excess = excess;
    r.dense = counts / dense;
    r.removed = counts % dense;
    return r;
  }
};

struct WorldStatus {
  std::uint32_t halted = 0;         ///< Halt
  std::uint32_t halt_particle = 0;  ///< id
  std::uint64_t halt_step = 0;
  double halt_value = 0;
  /// Where the state of that sub-step's beginning lies: addresses of its positions, velocities and ids. Where
  /// sph.advance made the sub-step, velocities are those in the new order.
  std::uint64_t halt_position = 0, halt_velocity = 0, halt_id = 0;
  std::uint32_t halt_advanced = 0;
  double time = 0;         ///< start of the last sub-step that began [s]
  double max_speed = 0;    ///< since the last synchronize()
  double max_density = 0;  ///< likewise, phi
  std::uint32_t courant_exceeded = 0;
  std::uint32_t groups = 0;                 ///< occupied cells of this step
  std::int64_t died = 0;                    ///< vertices that melted in this step; 0 again once pieces know
  std::uint32_t born = 0;                   ///< vertices that liquid froze onto in this step
  std::uint32_t pieces_stale = 1;           ///< something melted or froze since the last search ended
  std::uint32_t particles = 0;              ///< ids in use when this sub-step began
  std::int64_t melted = 0;                  ///< since the scene was uploaded
  std::uint64_t frozen = 0;                 ///< likewise
  std::int64_t removed = 0;                 ///< likewise
  double heat_in = 0;                       ///< likewise [J]
  LedgerSums sums;                          ///< of the particles as they are, once asked for (step::ledger)
  double step_speed = 0, step_density = 0;  ///< largest speed and phi of the last sub-step that counts
  double step_excess = 0;                   ///< its mean of rho/rho0 - 1 where above 0
  std::uint64_t ledger_step = 0;            ///< its index; 0: none since the upload
  double ledger_dt = 0;
  std::int64_t heat_bound_exceeded =
      0;  ///< particle-stages that exchanged faster than the stage count allows
};

/// Cells of the search grid, in stored coordinates.
template <class T>
struct Grid {
  Vec3<T> min{};
  Vec3<T> inv_cell{};  ///< 1/m
  std::int32_t nx = 1, ny = 1, nz = 1;
  std::uint32_t periodic = 0;  ///< bit per axis
  Vec3<T> period{};            ///< 0 where not periodic
  Vec3<T> inv_period{};
  std::int32_t reach = 1;  ///< cells in x that H spans: narrow ones leave fewer candidates out of reach
  std::uint32_t rows = 9;  ///< candidate rows per group: 9, or 18 when x is periodic
  std::int32_t line_cells[9] =
      {};  ///< how many cells away another line of cells along x lies (spatial/cells.hpp)
};

/// Whether any particle did.
struct Moved {
  std::uint32_t any = 0;
  MELTSIM_HD static Moved combine(const Moved& a, const Moved& b) { return {a.any | b.any}; }
};

struct KeptSearch {
  std::uint32_t keep = 0;
  std::uint32_t built = 0;  ///< how often since the upload
};

/// A grid that is kept for several sub-steps.
template <class T>
struct Kept {
  T reach2{};  ///< (H + skin)^2 [m^2]
  T moved2{};  ///< (skin / 2)^2, less what is rounded [m^2]
};

/// Of a node of the search tree. An empty one is low > high.
template <class T>
struct TreeBox {
  Vec3<T> low, high;
};

/// The search tree: leaves in order of a space-filling curve, eight nodes to one of the next level. It is
/// sized for a leaf per particle; how many there are is known on the device only.
template <class T>
struct Tree {
  static constexpr int most_levels = 12;  // 8^11 leaves and more
  Vec3<T> min{};
  T inv_cell{};                           ///< of the curve [1/m]
  std::uint32_t bits = 0;                 ///< of the curve, per axis
  int levels = 0;                         ///< allocated
  std::uint64_t first[most_levels] = {};  ///< node of a level
  T reach{};  ///< boxes farther apart hold no neighbours: H and what is rounded [m]
};

/// The double-buffered channels (owner particle, lifetime State): the copy that holds the last good state.
template <class T>
struct PreviousViews {
  const Vec4<T>* position = nullptr;
  const Vec4<T>* velocity = nullptr;
  const double* enthalpy = nullptr;
  const T* mass = nullptr;
  const std::uint32_t* tag = nullptr;
  const std::uint32_t* id = nullptr;
};

/// Where sph.advance puts the state at the end of the sub-step, as others still read that of its middle.
template <class T>
struct NextViews {
  Vec4<T>* position = nullptr;
  Vec4<T>* velocity = nullptr;
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
  SphKernel<T> kernel;
  WallBox<T> walls;
  Vec3<T> gravity{};
  T spacing{};
  T sound_speed{};
  T artificial_viscosity{};
  T lowest_phi = T(1);  ///< below it the pressure falls no further: 1, or 0 with tension
  T wall_friction{};
  T volume_rate{};                            ///< 1 / relaxation time of a melted particle's volume [1/s]
  physics::SurfaceCondition<T> wall_heat[6];  ///< per face
  std::uint32_t heated_walls = 0;             ///< bit per face: its heat is not insulated
  physics::WallExchange<T> wall_exchange;
  T first_layer{};  ///< share of a plane surface that its first layer serves
  std::uint32_t heat_regions = 0;
  std::uint32_t no_slip = 1;
  std::uint32_t open_faces = 0;  ///< bit per face
  Vec3<T> wall_velocity[6];
  Vec3<T> domain_min{}, domain_max{};
  T leak_distance2{};     ///< square of the distance below which liquid meets solid as a contact [m^2]
  T courant{};            ///< share of H a particle may move per sub-step before a flag is raised
  double heat_bound = 0;  ///< largest sum_j g_ij/C_i that the stage count allows [1/s]
};

/// One burst of an emitter: a layer of its nozzle.
template <class T>
struct Burst {
  std::uint32_t first_point = 0, points = 0;
  Vec3<T> center{};  ///< of this layer, in stored coordinates
  Vec3<T> velocity{};
  double enthalpy = 0;
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
  Kept<T> kept;
  std::uint32_t particles = 0;   ///< slots in use: ids handed out, removed ones included, and some to come
  std::uint32_t born = 0;        ///< ids handed out
  std::uint32_t cells = 0;       ///< where they are counted one by one; else 0
  std::uint32_t max_groups = 0;  ///< upper bound of occupied cells
  std::uint32_t vertices = 0;
  std::uint32_t region_words = 0;
  std::int32_t row_width = 0;  ///< half-width from which regions are summed by rows and planes
  std::uint32_t key_bits = 64;
  std::uint64_t bits_stride = 0;   ///< entries per row of far_bits
  std::uint64_t words_column = 0;  ///< a column of neighbour_words [bytes]
  std::uint32_t words_parts = 1;   ///< sets of words that a search fills, later joined
  std::uint32_t words_room = 0;    ///< words that a set holds
  bool solids = true;              ///< there are some
  bool one_liquid = false;         ///< no two materials are ever liquid
  bool slots_of_all = true;   ///< slot_of_id is kept for everyone, not only for solids and what is to come
  bool count_ahead = false;   ///< step.integrate counts who will be in which cell; it follows the same step
  bool counted = false;       ///< it did in the sub-step before
  bool cells_begun = false;   ///< and where cells begin is known since step.begin
  bool heat_at_hand = false;  ///< thermal.operands is done where the state is put in order
  // Arguments of single stages, set by the engine:
  Clock<T> clock;  ///< step.begin
  Burst<T> burst;  ///< step.emit
  std::uint32_t burst_first = 0;
  T heat_dt{};  ///< thermal.*: super-step, time-scaled [s]
  std::uint32_t heat_stages = 0, heat_supersteps = 0;
  SumUnits sum_units;  ///< lsm.balance
};

/// Whether a particle of liquid has nothing beside it but the same liquid, equally viscous.
template <class T>
bool liquid_alone(const Frame<T>& w) {
  return w.one_liquid && !w.solids && w.f.viscosity == nullptr;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
