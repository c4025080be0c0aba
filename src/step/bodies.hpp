// SPDX-License-Identifier: Apache-2.0
// Kernels that frame a sub-step: clock, emission, integration with the check that decides whether it counts.
#pragma once

#include "core/lattice.hpp"
#include "meltsim/physics/energy.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/walls.hpp"
#include "spatial/cells.hpp"

namespace meltsim {
inline namespace v0 {
namespace step {

using core::CheckResult;
using core::Frame;
using core::Halt;

template <class T>
struct BeginBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    *w.f.clock = w.clock;
    w.f.status->time = w.clock.time;
    w.f.status->particles = w.born;  // a World that halts keeps the count of its last sub-step
  }
};

/// One layer of a nozzle: the next ids.
template <class T>
struct EmitBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const core::Burst<T>& b = w.burst;
    const auto id = static_cast<std::uint32_t>(w.burst_first + k);
    const std::uint32_t slot = w.f.slot_of_id[id];  // until now it held nothing, as if removed
    const Vec3<T> offset = xyz(w.f.emitter_points[b.first_point + k]);
    w.f.position[slot] = with_w(b.center + offset, b.volume);
    w.f.velocity[slot] = with_w(b.velocity, T(0));
    w.f.enthalpy[slot] = b.enthalpy;
    w.f.mass[slot] = b.mass;
    w.f.tag[slot] = b.tag;
    if (w.f.vertex_of_id != nullptr) w.f.vertex_of_id[id] = core::none;
  }
};

/// Velocity v of particle i, kicked by acceleration a; every force stage has written what it has by now.
/// Channels that the plan does not hold are null.
template <class T>
MELTSIM_HD Vec3<T> kicked(const Frame<T>& w, std::uint64_t i, std::uint32_t tag, Vec3<T> v, Vec3<T> a) {
  if ((tag & tag_fixed) != 0u && is_solid(tag)) return v;
  if (w.f.acceleration != nullptr) v = physics::kick(v, a, w.f.clock->dt);
  if (w.f.shape_velocity != nullptr && is_solid(tag)) v += w.f.shape_velocity[w.f.vertex_of_id[w.f.id[i]]];
  return v;
}

template <class T>
MELTSIM_HD Vec3<T> acceleration_of(const Frame<T>& w, std::uint64_t i) {
  return w.f.acceleration != nullptr ? w.f.acceleration[i] : Vec3<T>{};
}

/// Kick, second half drift, walls, periodic wrap, open faces. In passing it looks for the first stage that
/// produced something unusable, which is not moved. Nothing it writes counts before JudgeBody says so: the state of
/// the sub-step before is still there, in its own order. Where it is told that the next sub-step is as long, it counts
/// for that one who will be in which cell.
template <class T>
struct IntegrateBody {
  Frame<T> w;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 24; }
  /// What a sub-step produced for a particle.
  struct Item {
    std::uint32_t tag = 0;
    T phi{};
    Vec4<T> position, velocity;
    Vec3<T> acceleration, shift;
    double enthalpy = 0;
  };
  MELTSIM_HD Item read(std::uint64_t i) const {
    Item p;
    p.tag = w.f.tag[i];
    if (w.f.density != nullptr) p.phi = w.f.density[i];
    p.position = w.f.position[i];
    p.velocity = w.f.velocity[i];
    p.acceleration = acceleration_of(w, i);
    if (w.f.shift != nullptr) p.shift = w.f.shift[i];
    p.enthalpy = w.f.enthalpy[i];
    return p;
  }
  template <class Add>
  MELTSIM_HD CheckResult operator()(std::uint64_t i, const Item& p, const Add& add) const {
    CheckResult r;
    Vec3<T> x = xyz(p.position), v = xyz(p.velocity);
    std::uint32_t tag = p.tag;
    if (!is_removed(tag)) {
      v = kicked(w, i, tag, v, p.acceleration);
      look(i, p, v, r);
      const bool stays = r.bad != 0u || (is_solid(tag) && (tag & tag_fixed) != 0u);
      if (!stays && move(i, p, x, v)) {
        r.removed = 1u;
        tag |= tag_removed;
      }
    }
    if (w.count_ahead && r.bad == 0u) {  // one that is at no place is in no cell; the World halts anyway
      const std::uint32_t cell = spatial::counted_cell(w, tag, x, v);
      w.f.cell_of[i] = cell;
      add.count(w.f.cell_count, cell);
    }
    return r;
  }

 private:
  /// Whether p and its new velocity v can be gone on with.
  MELTSIM_HD void look(std::uint64_t i, const Item& p, Vec3<T> v, CheckResult& r) const {
    const double speed = static_cast<double>(length(v));
    if (is_fluid(p.tag)) r.max_density = static_cast<double>(p.phi);
    // A particle that crosses its whole neighbourhood in one sub-step has met nothing on its way.
    Halt why = Halt::no;
    if (speed * static_cast<double>(w.f.clock->dt) > static_cast<double>(w.c.kernel.support))
      why = Halt::speed;
    double value = speed;
    const auto blame = [&](bool good, Halt stage, double found) {
      if (good) return;
      why = stage;
      value = found;
    };
    // The first stage that went wrong speaks last.
    blame(std::isfinite(p.enthalpy), Halt::heat, p.enthalpy);
    blame(finite(v), Halt::shape, speed);
    blame(finite(p.acceleration), Halt::force, static_cast<double>(length(p.acceleration)));
    blame(std::isfinite(r.max_density), Halt::density, r.max_density);
    // No sum shows it for sure: a GPU's kernel has a distance that is no number for one beyond H.
    blame(finite(xyz(p.position)), Halt::position, 0.0);
    if (why != Halt::no) {
      r.bad = static_cast<std::uint32_t>(why);
      r.bad_id = w.f.id[i];
      r.bad_value = value;
    }
    r.max_speed = speed;
    if (r.max_density > 1.0) {
      r.excess = r.max_density - 1.0;
      r.dense = 1u;
    }
  }
  /// Moves x and v to the end of the sub-step; true: p has left through an open face.
  MELTSIM_HD bool move(std::uint64_t i, const Item& p, Vec3<T>& x, Vec3<T>& v) const {
    x = physics::drift(x, v, w.f.clock->half_dt);
    if (is_fluid(p.tag)) x += p.shift;
    if (w.c.walls.faces != 0u) physics::hold_inside(w.c.walls, w.c.spacing, x, v);
    if (w.grid.periodic != 0u) {
      x.x -= w.grid.period.x * std::floor((x.x - w.c.domain_min.x) * w.grid.inv_period.x);
      x.y -= w.grid.period.y * std::floor((x.y - w.c.domain_min.y) * w.grid.inv_period.y);
      x.z -= w.grid.period.z * std::floor((x.z - w.c.domain_min.z) * w.grid.inv_period.z);
    }
    bool out = false;
    const std::uint32_t open = w.c.open_faces;
    if (open != 0u && is_fluid(p.tag)) {
      out = ((open & 1u) != 0u && x.x < w.c.domain_min.x) || ((open & 2u) != 0u && x.x > w.c.domain_max.x) ||
            ((open & 4u) != 0u && x.y < w.c.domain_min.y) || ((open & 8u) != 0u && x.y > w.c.domain_max.y) ||
            ((open & 16u) != 0u && x.z < w.c.domain_min.z) || ((open & 32u) != 0u && x.z > w.c.domain_max.z);
      if (out) w.f.tag[i] = p.tag | tag_removed;
    }
    w.f.position[i] = with_w(x, p.position.w);
    w.f.velocity[i] = with_w(v, p.velocity.w);
    return out;
  }
};

/// Draws the conclusion; from here on the guard holds if the World halted. One thread: what it reads it reads
/// before it writes anything, so that it waits once.
template <class T>
struct JudgeBody {
  Frame<T> w;
  MELTSIM_HD void operator()(const CheckResult& worst) const {
    core::WorldStatus& s = *w.f.status;
    const core::Clock<T> clock = *w.f.clock;
    const double fastest = s.max_speed, densest = s.max_density;
    const std::int64_t removed = s.removed;
    double heat_in = s.heat_in;
    if (w.f.heat_account != nullptr) heat_in += w.f.heat_account->step;
    if (worst.bad != 0u) {
      s.halt_particle = worst.bad_id;
      s.halt_value = worst.bad_value;
      s.halt_step = clock.step;
      s.halted = worst.bad;
      return;
    }
    s.heat_in = heat_in;
    if (w.f.heat_account != nullptr) w.f.heat_account->step = 0;  // and stays so in a sub-step without heat
    s.removed = removed + static_cast<std::int64_t>(worst.removed);
    s.max_speed = maximum(fastest, worst.max_speed);
    s.max_density = maximum(densest, worst.max_density);
    s.step_speed = worst.max_speed;
    s.step_density = worst.max_density;
    s.step_excess = worst.dense != 0u ? worst.excess / static_cast<double>(worst.dense) : 0.0;
    s.ledger_step = clock.step;
    s.ledger_dt = static_cast<double>(clock.dt);
    if (worst.max_speed * static_cast<double>(clock.dt) >
        static_cast<double>(w.c.courant) * static_cast<double>(w.c.kernel.support))
      s.courant_exceeded = 1u;
  }
};

/// What a particle adds to the ledger: it is the state's alone, so that nobody pays for it who does not ask.
template <class T>
struct LedgerBody {
  Frame<T> w;
  MELTSIM_HD core::LedgerSums operator()(std::uint64_t i) const {
    core::LedgerSums s;
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag)) return s;
    const auto mass = static_cast<double>(w.f.mass[i]);
    const double enthalpy = w.f.enthalpy[i];
    const Vec3<double> x = cast<double>(xyz(w.f.position[i])), v = cast<double>(xyz(w.f.velocity[i]));
    s.mass = mass;
    s.momentum = v * mass;
    s.angular_momentum = cross(x, v) * mass;
    s.kinetic = physics::kinetic_energy(mass, v);
    s.potential = physics::potential_energy(mass, cast<double>(w.c.gravity), x);
    s.thermal = enthalpy;
    s.latent = physics::latent_energy(w.f.materials[material_of(tag)], mass, enthalpy);
    return s;
  }
};

/// Begins anew with what is "since the last synchronize()".
template <class T>
struct ClearBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    core::WorldStatus& s = *w.f.status;
    s.max_speed = s.max_density = 0;
    s.courant_exceeded = 0u;
    s.heat_bound_exceeded = 0;
  }
};

/// After a roll-back: where every id is in the order that was kept.
template <class T>
struct IndexBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    w.f.slot_of_id[w.f.id[i]] = static_cast<std::uint32_t>(i);
  }
};

}  // namespace step
}  // namespace v0
}  // namespace meltsim
