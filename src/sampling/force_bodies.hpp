// SPDX-License-Identifier: Apache-2.0
// Kernels of the bodies that a host watches: impulses on them in a sub-step, heat that they got, and their sum over the
// sub-steps since the host took them. They run after all forces and heat and before step.integrate; the sum runs after it.
#pragma once

#include "frame/lattice.hpp"
#include "sampling/load_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

/// The body of a solid particle that is watched; none of others.
template <class T>
MELTSIM_HD std::uint32_t watched_body(const Frame<T>& w, std::uint32_t tag) {
  if (!is_solid(tag) || is_removed(tag)) return core::none;
  const std::uint32_t body = body_of(tag) - 1u;
  return w.f.bodies[body].watched != 0u ? body : core::none;
}

/// Whether moments on a body are about its pivot: of a kinematic body or proxy.
template <class T>
MELTSIM_HD bool has_pivot(const Frame<T>& w, std::uint32_t body) {
  const std::uint32_t motion = w.f.bodies[body].motion;
  return w.f.body_motion != nullptr && (motion == core::body_kinematic || motion == core::body_proxy);
}

/// The point that moments on a body are summed about, in the middle of the sub-step: the pivot if it has one, else the last centre
/// of mass.
template <class T>
MELTSIM_HD Vec3<double> reference_of(const Frame<T>& w, std::uint32_t body) {
  if (!has_pivot(w, body)) return w.f.body_forces[body].center;
  const physics::RigidMotion& m = w.f.body_motion[body].motion;
  const double half = 0.5 * static_cast<double>(w.f.clock->dt);
  return w.f.bodies[body].motion == core::body_proxy ? m.first.position + m.first.velocity * half
                                                     : physics::place_at(m, w.f.clock->time + half).position;
}

/// Empties the sums of a body.
template <class T>
struct ClearForcesBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t b) const {
    w.f.force_sums[b] = core::ForceSums{};
    w.f.heat_sums[b] = core::HeatSums{};
  }
};

/// Forces on a particle. On a body that can move the whole force is its acceleration beyond gravity; on a held one it is
/// the force that probes read.
template <class T, bool Periodic>
struct WatchedForcesBody {
  Frame<T> w;
  using Sum = core::ForceSums;
  /// The row of the body, or none.
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i, Sum& s) const {
    const std::uint32_t tag = w.f.tag[i], body = watched_body(w, tag);
    if (body == core::none) return body;
    Vec3<T> pressure = spatial::sum_part<Periodic>(w, core::PressureOnSolid<T>{{w}}, i, 0u, 1u).force;
    const Vec3<T> rest = core::rest_force_on(w, i);
    pressure += seeping_on<Periodic>(w, i) + rest;
    if (w.f.surface_along != nullptr) pressure += core::tension_on_solid<Periodic>(w, i);
    if (w.f.isotropic_diagonal != nullptr)
      pressure += spatial::sum_part<Periodic>(w, core::IsotropicForce<T>{w}, i, 0u, 1u).force;
    const Vec3<T> contact = contact_force_on<Periodic>(w, i, tag);
    const T mass = w.f.mass[i];
    Vec3<T> all;
    if ((tag & tag_fixed) == 0u && w.f.acceleration != nullptr)
      all = (w.f.acceleration[i] - w.f.clock->gravity) * mass +
            ((tag & tag_kinematic) != 0u ? rest : Vec3<T>{});
    else all = liquid_force_on<Periodic>(w, i) + contact;
    if (!finite(all) || !finite(pressure)) return core::none;  // step.integrate reports it
    const Vec3<double> arm =
        cast<double>(spatial::separation(w.grid, xyz(w.f.position[i]), cast<T>(reference_of(w, body))));
    const double dt = static_cast<double>(w.f.clock->dt);
    s.mass = core::counted(static_cast<double>(mass), w.sum_units.mass);
    core::count(arm * static_cast<double>(mass), w.sum_units.first, s.first);
    core::count_impulse(s.all, w.sum_units, arm, cast<double>(all), dt);
    core::count_impulse(s.pressure, w.sum_units, arm, cast<double>(pressure), dt);
    core::count_impulse(s.contact, w.sum_units, arm, cast<double>(contact), dt);
    return body;
  }
};

/// Enthalpy of a particle now, of items below the number of slots; less that at the beginning of the sub-step, where particles
/// had another order, of the others.
template <class T>
struct HeatGainedBody {
  Frame<T> w;
  using Sum = core::HeatSums;
  /// The row of the body, or none.
  MELTSIM_HD std::uint32_t operator()(std::uint64_t k, Sum& s) const {
    const bool now = k < w.particles;
    const std::uint64_t i = now ? k : k - w.particles;
    const std::uint32_t body = watched_body(w, now ? w.f.tag[i] : w.before.tag[i]);
    if (body == core::none) return body;
    const core::SumUnit unit = core::heat_unit(w.sum_units.mass);
    s.enthalpy = now ? core::counted(w.f.enthalpy[i], unit) : -core::counted(w.before.enthalpy[i], unit);
    return body;
  }
};

/// Adds the sums of a sub-step once it counts.
template <class T>
struct AddForcesBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t b) const {
    const auto body = static_cast<std::uint32_t>(b);
    if (w.f.bodies[body].watched == 0u) return;
    const core::ForceSums& s = w.f.force_sums[body];
    core::BodyForceTotals& t = w.f.body_forces[body];
    t.seconds += static_cast<double>(w.f.clock->dt);
    t.heat += static_cast<double>(w.f.heat_sums[body].enthalpy) * core::heat_unit(w.sum_units.mass).size;
    const double mass = static_cast<double>(s.mass) * w.sum_units.mass.size;
    if (!(mass > 0)) return;  // it has melted
    const Vec3<double> from = reference_of(w, body);
    const Vec3<double> center =
        has_pivot(w, body) ? Vec3<double>{} : core::sum_of(s.first, w.sum_units.first) * (1 / mass);
    const auto add = [&](core::Impulses& to, const core::ImpulseSum& sum) {
      const core::Impulses more = core::impulses_of(sum, w.sum_units, center);
      to.linear += more.linear;
      to.angular += more.angular;
    };
    add(t.all, s.all);
    add(t.pressure, s.pressure);
    add(t.contact, s.contact);
    t.center = from + center;
  }
};

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
