// SPDX-License-Identifier: Apache-2.0
// Results of a sub-step: checks of every particle, their reduction, and the status of the World.
#pragma once

#include <cstdint>

#include "meltsim/material.hpp"
#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Which check stopped the World; order = order of the stages.
enum class Halt : std::uint32_t {
  no = 0,
  position,
  density,
  force,
  shape,
  heat,
  speed,
  interrupted,
  unsaved
};

enum HeatIdle : std::uint32_t { idle_level = 1u, idle_halted = 2u };
/// Kinds of phase change that take place although no heat flows.
enum HeatPending : std::uint32_t { pending_melt = 1u, pending_freeze = 2u };

/// How far apart temperatures are [degrees Celsius], and whether something is to change phase.
struct HeatSpread {
  double low = 1e300, high = -1e300;
  std::uint32_t pending = 0;
  MELTSIM_HD static HeatSpread combine(HeatSpread a, const HeatSpread& b) {
    a.low = minimum(a.low, b.low);
    a.high = maximum(a.high, b.high);
    a.pending |= b.pending;
    return a;
  }
};

/// Sums over all particles, in stored coordinates.
struct LedgerSums {
  double mass = 0;
  Vec3<double> momentum, angular_momentum;  ///< about the stored origin
  double kinetic = 0, potential = 0;        ///< potential at the stored origin is 0
  double thermal = 0, latent = 0, latent_max = 0;
  MELTSIM_HD static LedgerSums combine(LedgerSums a, const LedgerSums& b) {
    a.mass += b.mass;
    a.momentum += b.momentum;
    a.angular_momentum += b.angular_momentum;
    a.kinetic += b.kinetic;
    a.potential += b.potential;
    a.thermal += b.thermal;
    a.latent += b.latent;
    a.latent_max += b.latent_max;
    return a;
  }
};

/// Quantities that the sound speed follows from, over all moving particles.
struct SoundLook {
  double head = -1e300;       ///< largest v^2/2 - g.x, x relative to the stored origin [m^2/s^2]
  std::uint32_t elastic = 0;  ///< 1: a deformable body has a youngs_modulus
  MELTSIM_HD static SoundLook combine(SoundLook a, const SoundLook& b) {
    a.head = maximum(a.head, b.head);
    a.elastic |= b.elastic;
    return a;
  }
};

/// Work of changes of the sound speed.
struct SoundWork {
  double mass = 0;  ///< sum of m u/c^2 at the change [kg]
  double done = 0;  ///< since the host took it last [J]
  MELTSIM_HD static SoundWork combine(SoundWork a, const SoundWork& b) {
    a.mass += b.mass;
    return a;
  }
};

/// The same of species: contents, and of them what is dissolved [kg], heat that this has taken up [J].
struct ContentSums {
  double solute[most_species] = {}, dissolved[most_species] = {}, solution = 0;
  MELTSIM_HD static ContentSums combine(ContentSums a, const ContentSums& b) {
    for (int k = 0; k < most_species; ++k) {
      a.solute[k] += b.solute[k];
      a.dissolved[k] += b.dissolved[k];
    }
    a.solution += b.solution;
    return a;
  }
};

/// Result of a sub-step: the worst check of all particles, how many left, the compression of liquid. Ties go to the
/// smaller id, so that the result does not depend on the order.
struct CheckResult {
  double max_speed = 0, max_density = 0;
  std::uint64_t excess = 0;  ///< sum of rho/rho0 - 1 where above 0, in units of 1/excess_units
  double bad_value = 0;
  std::uint32_t dense = 0, removed = 0,
                strayed = 0;  ///< how many are in that sum, left, fell out of the scene
  std::uint32_t bad = 0;      ///< Halt
  std::uint32_t bad_id = 0xffffffffu;
  static constexpr double excess_units = 1u << 22, most_excess = 16;  // a warp's sum fits 32 bits
  MELTSIM_HD static CheckResult combine(const CheckResult& a, const CheckResult& b) {
    CheckResult r;
    r.max_speed = maximum(a.max_speed, b.max_speed);
    r.max_density = maximum(a.max_density, b.max_density);
    r.excess = a.excess + b.excess;
    r.dense = a.dense + b.dense;
    r.removed = a.removed + b.removed;
    r.strayed = a.strayed + b.strayed;
    const bool take_b =
        b.bad != 0u && (a.bad == 0u || b.bad < a.bad || (b.bad == a.bad && b.bad_id < a.bad_id));
    r.bad = take_b ? b.bad : a.bad;
    r.bad_id = take_b ? b.bad_id : a.bad_id;
    r.bad_value = take_b ? b.bad_value : a.bad_value;
    return r;
  }
  /// Adds this result, which must have no bad check, to a shared one. Add: raise(x, v), x = max(x, v) for v >= 0, and add(x, n).
  template <class Add>
  MELTSIM_HD void hand_in(CheckResult& to, const Add& add) const {
    add.raise(to.max_speed, max_speed);
    add.raise(to.max_density, max_density);
    if (dense != 0u) {
      add.add(to.excess, excess);
      add.add(to.dense, dense);
    }
    if (removed != 0u) add.add(to.removed, removed);
    if (strayed != 0u) add.add(to.strayed, strayed);
  }
};

/// The same of one particle.
template <class T>
struct ParticleCheck {
  T speed{}, phi{};
  std::uint32_t excess = 0, counts = 0;  ///< counts: one of those below, or two, or none
  std::uint32_t bad = 0, bad_id = 0xffffffffu;
  double bad_value = 0;
  static constexpr std::uint32_t removed = 1u, strayed = 1u << 8,
                                 dense = 1u << 16;  // up to 32 of each add up
  MELTSIM_HD bool plain() const { return bad == 0u; }
  MELTSIM_HD CheckResult result() const {
    CheckResult r = of(speed, phi, excess, counts);
    r.bad = bad;
    r.bad_id = bad_id;
    r.bad_value = bad_value;
    return r;
  }
  /// Combined result of up to 32 particles without a bad check. Lanes: largest(x), x >= 0, and sum(n) over all of them.
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
    r.strayed = counts % dense / strayed;
    r.removed = counts % strayed;
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
  std::uint32_t reserve_spent = 0;          ///< a face had no ids left for what was to come in
  std::uint32_t groups = 0;                 ///< occupied cells of this step
  std::int64_t died = 0;                    ///< vertices that melted in this step; 0 once pieces are searched
  std::uint32_t born = 0;                   ///< vertices that liquid froze onto in this step
  std::uint32_t pieces_stale = 1;           ///< something melted or froze since the last search ended
  std::uint32_t particles = 0;              ///< ids in use when this sub-step began
  std::int64_t melted = 0;                  ///< since the scene was uploaded
  std::uint64_t frozen = 0;                 ///< likewise
  std::int64_t removed = 0;                 ///< likewise: all that are marked so
  std::int64_t strayed = 0;                 ///< those of them that fell out of the scene
  std::int64_t entered = 0;                 ///< likewise: came in through faces, no longer marked as removed
  double heat_in = 0;                       ///< likewise [J]
  double field_work = 0;                    ///< likewise, of force fields [J]
  Vec3<double> field_impulse;               ///< likewise [N s]
  double step_speed = 0, step_density = 0;  ///< largest speed and phi of the last sub-step that counts
  double step_excess = 0;                   ///< its mean of rho/rho0 - 1 where above 0
  std::uint64_t ledger_step = 0;            ///< its index; 0: none since the upload
  double ledger_dt = 0;
  std::int64_t cooled_to_zero = 0;  ///< particle-stages held at 0 K
  std::uint64_t level_bared = 0;    ///< 1: liquid below the level of a hydrostatic field has a free surface
  std::int64_t heat_bound_exceeded =
      0;  ///< particle-stages that exchanged faster than the stage count allows
  std::int64_t viscous_bound_exceeded =
      0;  ///< particles that exchanged momentum faster than the stage count allows
  std::int64_t solute_bound_exceeded =
      0;  ///< particles that exchanged a species faster than its sweeps allow
  /// Bits of HeatIdle: while one is set, kernels of heat do nothing. thermal.level sets the first, so that heat ends in a
  /// sub-step that follows from the state, not from when the host reads it.
  std::uint32_t heat_idle = 0;
  std::uint32_t heat_pending = 0;  ///< bits of HeatPending, as thermal.level met them when it set that
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
