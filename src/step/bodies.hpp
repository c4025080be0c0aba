// SPDX-License-Identifier: Apache-2.0
// Kernels that frame a sub-step: clock, emission, the check before anything is committed, integration.
#pragma once

#include "core/lattice.hpp"
#include "meltsim/physics/energy.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/walls.hpp"

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

/// Looks for the first stage that produced something unusable, before anything is committed; keeps the
/// ledger.
template <class T>
struct CheckBody {
  Frame<T> w;
  /// What a sub-step produced for a particle.
  struct Item {
    std::uint32_t tag = 0;
    T phi{}, mass{};
    Vec3<T> position, velocity, acceleration, shift;
    double enthalpy = 0;
  };
  MELTSIM_HD Item read(std::uint64_t i) const {
    Item p;
    p.tag = w.f.tag[i];
    if (w.f.density != nullptr) p.phi = w.f.density[i];
    p.mass = w.f.mass[i];
    p.position = xyz(w.f.position[i]);
    p.velocity = xyz(w.f.velocity[i]);
    p.acceleration = acceleration_of(w, i);
    if (w.f.shift != nullptr) p.shift = w.f.shift[i];
    p.enthalpy = w.f.enthalpy[i];
    return p;
  }
  MELTSIM_HD CheckResult operator()(std::uint64_t i) const { return (*this)(i, read(i)); }
  MELTSIM_HD CheckResult operator()(std::uint64_t i, const Item& p) const {
    CheckResult r;
    if (is_removed(p.tag)) return r;
    const Vec3<T> v = kicked(w, i, p.tag, p.velocity, p.acceleration);
    const double speed = static_cast<double>(length(v));
    Vec3<T> x = p.position;
    if (is_fluid(p.tag)) {
      r.max_density = static_cast<double>(p.phi);
      x += p.shift;
    }
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
    blame(finite(p.position), Halt::position, 0.0);
    if (why != Halt::no) {
      r.bad = static_cast<std::uint32_t>(why);
      r.bad_id = w.f.id[i];
      r.bad_value = value;
    }
    r.max_speed = speed;
    r.sums = ledger_of(p.tag, static_cast<double>(p.mass), x, v, p.enthalpy);
    if (r.max_density > 1.0) {
      r.sums.excess = r.max_density - 1.0;
      r.sums.dense = 1.0;
    }
    return r;
  }
  /// What a particle adds to the ledger once this sub-step is committed. Positions are those after the
  /// second half drift, before walls hold anything back.
  MELTSIM_HD core::LedgerSums ledger_of(std::uint32_t tag, double mass, Vec3<T> position, Vec3<T> velocity,
                                        double enthalpy) const {
    core::LedgerSums s;
    const Vec3<double> v = cast<double>(velocity);
    const Vec3<double> x = cast<double>(position) + v * static_cast<double>(w.f.clock->half_dt);
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

/// Draws the conclusion; from here on the guard holds if the World halted.
template <class T>
struct JudgeBody {
  Frame<T> w;
  const CheckResult* result;
  MELTSIM_HD void operator()(std::uint64_t) const {
    core::WorldStatus& s = *w.f.status;
    if (result->bad != 0u) {
      s.halt_particle = result->bad_id;
      s.halt_value = result->bad_value;
      s.halt_step = w.f.clock->step;
      s.halted = result->bad;
      return;
    }
    if (w.f.heat_account != nullptr) {  // zero in a sub-step without heat
      s.heat_in += w.f.heat_account->step;
      w.f.heat_account->step = 0;
    }
    s.max_speed = maximum(s.max_speed, result->max_speed);
    s.max_density = maximum(s.max_density, result->max_density);
    s.sums = result->sums;
    s.step_speed = result->max_speed;
    s.step_density = result->max_density;
    s.ledger_step = w.f.clock->step;
    s.ledger_dt = static_cast<double>(w.f.clock->dt);
    if (result->max_speed * static_cast<double>(w.f.clock->dt) >
        static_cast<double>(w.c.courant) * static_cast<double>(w.c.kernel.support))
      s.courant_exceeded = 1u;
  }
};

/// Kick, second half drift, walls, periodic wrap, open faces.
template <class T>
struct IntegrateBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t i, const Add& add) const {
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag) || (is_solid(tag) && (tag & tag_fixed) != 0u)) return;
    Vec3<T> v = kicked(w, i, tag, xyz(w.f.velocity[i]), acceleration_of(w, i));
    Vec3<T> x = physics::drift(xyz(w.f.position[i]), v, w.f.clock->half_dt);
    if (w.f.shift != nullptr && is_fluid(tag)) x += w.f.shift[i];
    if (w.c.walls.faces != 0u) physics::hold_inside(w.c.walls, w.c.spacing, x, v);
    if (w.grid.periodic != 0u) {
      x.x -= w.grid.period.x * std::floor((x.x - w.c.domain_min.x) * w.grid.inv_period.x);
      x.y -= w.grid.period.y * std::floor((x.y - w.c.domain_min.y) * w.grid.inv_period.y);
      x.z -= w.grid.period.z * std::floor((x.z - w.c.domain_min.z) * w.grid.inv_period.z);
    }
    const std::uint32_t open = w.c.open_faces;
    if (open != 0u && is_fluid(tag)) {
      const bool out =
          ((open & 1u) != 0u && x.x < w.c.domain_min.x) || ((open & 2u) != 0u && x.x > w.c.domain_max.x) ||
          ((open & 4u) != 0u && x.y < w.c.domain_min.y) || ((open & 8u) != 0u && x.y > w.c.domain_max.y) ||
          ((open & 16u) != 0u && x.z < w.c.domain_min.z) || ((open & 32u) != 0u && x.z > w.c.domain_max.z);
      if (out) {
        w.f.tag[i] = tag | tag_removed;
        add(&w.f.status->removed, 1);
      }
    }
    // The rotation of a region is state: it is taken over only now that the step counts.
    if (w.f.region_fit != nullptr && is_solid(tag)) {
      const std::uint32_t vertex = w.f.vertex_of_id[w.f.id[i]];
      w.f.region_rotation[vertex] = core::fitted_rotation(w, vertex);
    }
    if (w.f.slip_next != nullptr && w.f.contact_slip != nullptr && is_solid(tag)) {  // likewise
      const Vec4<T> slip = w.f.slip_next[i];
      w.f.contact_slip[w.f.vertex_of_id[w.f.id[i]]] = slip.w > T(0) ? xyz(slip) * (T(1) / slip.w) : Vec3<T>{};
    }
    const T operand = w.f.velocity[i].w;
    w.f.position[i] = with_w(x, w.f.position[i].w);
    w.f.velocity[i] = with_w(v, operand);
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
