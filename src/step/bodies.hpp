// SPDX-License-Identifier: Apache-2.0
// Kernels that frame a sub-step: clock, emission, integration with the check that decides whether it counts.
#pragma once

#include "frame/lattice.hpp"
#include "frame/steered.hpp"
#include "meltsim/physics/emission.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/sound_speed.hpp"
#include "shared/advance.hpp"
#include "spatial/rows.hpp"
#include "step/inlet_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace step {

using core::CheckResult;
using core::Frame;

template <class T>
struct BeginBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    *w.f.clock = w.clock;
    w.f.status->time = w.clock.time;
    w.f.status->particles = w.born;  // a World that halts keeps the count of its last sub-step
  }
};

/// Particles in a nozzle that have reached its end become free liquid.
template <class T>
struct LetGoBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const core::Burst<T>& b = w.burst;
    const std::uint32_t tag = w.f.tag[i];
    if (!is_held(tag)) return;
    // Particles in a nozzle keep its velocity to the last bit, which distinguishes them from those of other nozzles.
    const Vec4<T> v = w.f.velocity[i];
    if (v.x != b.velocity.x || v.y != b.velocity.y || v.z != b.velocity.z) return;
    const Vec3<T> x = xyz(w.f.position[i]) - b.center;
    const T along = dot(x, b.axis), margin = T(0.5) * w.c.spacing, reach = b.radius + margin;
    const Vec3<T> across = x - b.axis * along;
    if (along < b.held || dot(across, across) > reach * reach) return;
    if (b.width > T(0) && (std::fabs(dot(x, b.across)) > T(0.5) * b.width + margin ||
                           std::fabs(dot(x, b.upright)) > T(0.5) * b.height + margin))
      return;
    w.f.tag[i] = tag & ~tag_held;
    w.f.velocity[i] = with_w(b.velocity + physics::converging_velocity(across, dot(w.clock.gravity, b.axis),
                                                                       length(b.velocity), b.radius),
                             v.w);
  }
};

/// One layer of a nozzle: the next ids.
template <class T>
struct EmitBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const core::Burst<T>& b = w.burst;
    const auto id = static_cast<std::uint32_t>(w.burst_first + k);
    const Vec3<T> offset = xyz(w.f.emitter_points[b.first_point + k]);
    enter_as(w, id, b.center + offset, b.velocity, b);
  }
};

/// Liquid ahead of an outlet.
template <class T>
struct AheadOfOutletBody {
  Frame<T> w;
  std::uint32_t face;
  MELTSIM_HD physics::OutletSums operator()(std::uint64_t i) const {
    physics::OutletSums s;
    if (!is_fluid(w.f.tag[i])) return s;
    const Vec4<T> x = w.f.position[i];
    const T d = physics::face_distance(w.c.domain_min, w.c.domain_max, xyz(x), face) / w.c.kernel.support;
    if (d < T(physics::outlet_reach) || d >= T(physics::outlet_end)) return s;
    const double dx = static_cast<double>(w.c.spacing);
    const T speed = dot(xyz(w.f.velocity[i]), physics::face_outwards<T>(face));
    s.add(static_cast<double>(x.w) / (dx * dx * dx), static_cast<double>(speed / w.c.sound_speed));
    return s;
  }
};

/// How fast it leaves.
template <class T>
struct OutletSpeedBody {
  Frame<T> w;
  std::uint32_t face;
  MELTSIM_HD void operator()(const physics::OutletSums& s) const {
    w.f.outlet_flow->speed[face] = static_cast<T>(physics::outlet_speed(
        s, static_cast<double>(w.c.spacing), static_cast<double>(w.c.sound_speed),
        static_cast<double>(w.c.outlets.floor[face]), static_cast<double>(w.c.outlets.head[face]),
        static_cast<double>(length(w.f.clock->gravity))));
  }
};

/// Every material gets the stiffness of another sound speed.
template <class T>
struct SetSoundSpeedBody {
  physics::MaterialRow<T>* rows;
  double speed;
  MELTSIM_HD void operator()(std::uint64_t m) const {
    rows[m].tait_stiffness =
        static_cast<T>(physics::tait_stiffness(static_cast<double>(rows[m].density), speed));
  }
};

/// Compression of liquid, from the last sub-step's densities.
template <class T>
struct CompressionBody {
  Frame<T> w;
  MELTSIM_HD core::SoundWork operator()(std::uint64_t i) const {
    core::SoundWork s;
    if (!is_fluid(w.f.tag[i])) return s;
    s.mass =
        static_cast<double>(w.f.mass[i]) *
        physics::compression_share(static_cast<double>(w.f.density[i]), static_cast<double>(w.c.lowest_phi));
    return s;
  }
};

/// The work of a change of c^2.
struct SoundWorkBody {
  core::SoundWork* account;
  double change;  ///< [m^2/s^2]
  MELTSIM_HD void operator()(const core::SoundWork& s) const { account->done += s.mass * change; }
};

/// Quantities that the sound speed follows from.
template <class T>
struct LookBody {
  Frame<T> w;
  bool sized;  ///< densities are of the last sub-step
  MELTSIM_HD core::SoundLook operator()(std::uint64_t i) const {
    core::SoundLook s;
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag) || (is_solid(tag) && (tag & (tag_fixed | tag_kinematic)) != 0u)) return s;
    if (!is_fluid(tag) || is_held(tag) || !sized ||
        static_cast<double>(w.f.density[i]) >= physics::spray_filling)
      s.head = physics::specific_head(cast<double>(xyz(w.f.velocity[i])), cast<double>(w.clock.gravity),
                                      cast<double>(xyz(w.f.position[i])));
    if (is_solid(tag) && w.f.materials[material_of(tag)].modulus_rate > T(0) &&
        w.f.bodies[body_of(tag) - 1u].motion == core::body_free)
      s.elastic = 1u;
    return s;
  }
};

/// Bodies get new motions, ahead of a sub-step.
struct SteerBody {
  core::BodyMotionRow* rows;
  const core::BodyRow* bodies;
  std::uint32_t body[core::most_steered];
  std::uint32_t jumps;  ///< bit per entry
  physics::RigidMotion motion[core::most_steered];
  double reach[core::most_steered], most[core::most_steered];
  Vec3<double> period;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    physics::RigidMotion& m = rows[body[k]].motion;
    if (bodies[body[k]].motion == core::body_proxy)
      m = physics::proxy_set(m, motion[k], ((jumps >> k) & 1u) != 0u, reach[k], most[k], period);
    else m = motion[k];
  }
};

/// Particles of kinematic bodies and proxies get the velocities of the motions that begin now; places: and positions.
template <class T>
struct SetOffBody {
  Frame<T> w;
  double time;
  bool places;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    const bool proxy =
        w.f.vertex_state[v] == core::vertex_live && w.f.bodies[w.f.vertex_body[v]].motion == core::body_proxy;
    if (!proxy && !core::is_carried(w, v)) return;
    const std::uint32_t slot = w.f.slot_of_id[w.f.vertex_id[v]];
    const physics::RigidPoint p = proxy ? core::proxy_point(w, v) : core::carried_point(w, v, time);
    w.f.velocity[slot] = with_w(cast<T>(p.velocity), w.f.velocity[slot].w);
    if (places) w.f.position[slot] = with_w(core::wrapped(w, cast<T>(p.position)), w.f.position[slot].w);
  }
};

/// Place of the particle at slot i relative to the first vertex of its body [m]; of another piece, in the nearest image.
template <class T>
MELTSIM_HD Vec3<double> place_in_body(const Frame<T>& w, std::uint64_t i, std::uint32_t vertex) {
  const std::uint32_t first = w.f.slot_of_id[w.f.vertex_id[vertex]], v = w.f.vertex_of_id[w.f.id[i]];
  const Vec3<double> d =
      cast<double>(spatial::separation(w.grid, xyz(w.f.position[i]), xyz(w.f.position[first])));
  return w.f.vertex_piece[v] == w.f.vertex_piece[vertex]
             ? core::offset_in_piece(w, d, v, vertex,
                                     [&w](std::uint64_t of) { return w.f.region_rotation[of]; })
             : d;
}

template <class T>
struct ReachOfBodyBody {
  Frame<T> w;
  core::PushArguments a;
  MELTSIM_HD bool takes_part(std::uint64_t i) const {
    return is_solid(w.f.tag[i]) && body_of(w.f.tag[i]) == a.body + 1u;
  }
  MELTSIM_HD core::MassReach operator()(std::uint64_t i) const {
    if (!takes_part(i)) return {};
    const Vec3<double> u = place_in_body(w, i, a.vertex);
    return {static_cast<double>(w.f.mass[i]), dot(u, u), 1};
  }
};
template <class T>
struct PushUnitsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(const core::MassReach& reach) const { w.f.push->units = reach.units(); }
};

template <class T>
struct MassOfBodyBody {
  Frame<T> w;
  core::PushArguments a;
  MELTSIM_HD core::MassCounts operator()(std::uint64_t i) const {
    core::MassCounts s;
    if (ReachOfBodyBody<T>{w, a}.takes_part(i))
      s.count(w.f.push->units, static_cast<double>(w.f.mass[i]), place_in_body(w, i, a.vertex));
    return s;
  }
};

template <class T>
struct MakePushBody {
  Frame<T> w;
  core::PushArguments a;
  MELTSIM_HD void operator()(const core::MassCounts& counts) const {
    physics::RigidPush& p = w.f.push->push;
    p = physics::push_of(counts.sums(w.f.push->units), a.linear, a.angular);
    if (!a.sets) return;
    p.velocity = a.linear;
    p.angular_velocity = a.angular;
  }
};

template <class T>
struct PushBody {
  Frame<T> w;
  core::PushArguments a;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_solid(tag) || body_of(tag) != a.body + 1u) return;
    const physics::RigidPush& p = w.f.push->push;
    const Vec3<T> dv =
        cast<T>(p.velocity + cross(p.angular_velocity, place_in_body(w, i, a.vertex) - p.center));
    w.f.velocity[i] = with_w(a.sets ? dv : xyz(w.f.velocity[i]) + dv, w.f.velocity[i].w);
  }
};

/// Particles that a nozzle holds get its new velocity; the old one, to the last bit, tells them from those of others.
template <class T>
struct RespeedBody {
  Frame<T> w;
  Vec3<T> from, to;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const Vec4<T> v = w.f.velocity[i];
    if (is_held(w.f.tag[i]) && v.x == from.x && v.y == from.y && v.z == from.z)
      w.f.velocity[i] = with_w(to, v.w);
  }
};

/// Particles that a nozzle holds move with it: those of its velocity, to the last bit, in its pipe.
template <class T>
struct NozzleShiftBody {
  Frame<T> w;
  Vec3<T> velocity, begin, axis, by;
  T length, reach;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const Vec4<T> v = w.f.velocity[i], x = w.f.position[i];
    if (!is_held(w.f.tag[i]) || v.x != velocity.x || v.y != velocity.y || v.z != velocity.z) return;
    const Vec3<T> d = spatial::separation(w.grid, xyz(x), begin);
    const T along = dot(d, axis);
    const Vec3<T> across = d - axis * along;
    if (along < -w.c.spacing || along > length || dot(across, across) > reach * reach) return;
    w.f.position[i] = with_w(core::wrapped(w, xyz(x) + by), x.w);
  }
};

/// A heat region gets another temperature or source.
template <class T>
struct SetHeatRegionBody {
  core::HeatRegionRow<T>* row;
  std::uint32_t held;
  double temperature;
  T source;
  MELTSIM_HD void operator()(std::uint64_t) const {
    row->held = held;
    row->temperature = temperature;
    row->source = source;
  }
};

/// What a body gives and takes from now on.
template <class T>
struct SetBodyHeatBody {
  core::BodyHeat<T>* row;
  core::BodyHeat<T> heat;
  MELTSIM_HD void operator()(std::uint64_t) const { *row = heat; }
};

/// Where a heat region is from now on.
template <class T>
struct MoveHeatRegionBody {
  core::HeatRegionRow<T>* row;
  double since;
  Vec3<double> displacement, velocity;
  MELTSIM_HD void operator()(std::uint64_t) const {
    row->moves = core::region_goes_on;
    row->since = since;
    row->displacement = displacement;
    row->velocity = velocity;
  }
};

/// A force field changes.
template <class T>
struct SetForceFieldBody {
  core::ForceFields<T>* fields;
  std::uint32_t row, count;
  physics::ForceField<T> field;
  MELTSIM_HD void operator()(std::uint64_t) const {
    fields->row[row] = field;
    fields->count = count;
  }
};

/// Acceleration of a particle by force fields: winds act beside the other fields and all that sph and lsm stages made of it.
template <class T>
struct FieldsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    const bool liquid = is_fluid(tag) && !is_held(tag);
    const bool body = is_solid(tag) && (tag & (tag_fixed | tag_kinematic)) == 0u && !is_removed(tag);
    Vec3<T> a{};
    if (liquid || body) {
      const core::Clock<T>& clock = *w.f.clock;
      const Vec3<T> x = xyz(w.f.position[i]), v = xyz(w.f.velocity[i]);
      const std::uint32_t count = w.f.force_fields->count;
      physics::Winds<T> winds;
      const physics::Weighed<T> weighed{clock.gravity, w.f.position[i].w / w.f.mass[i]};
      bool bared = false;
      for (std::uint32_t k = 0; k < count; ++k) {
        const physics::ForceField<T>& field = w.f.force_fields->row[k];
        if (field.on == 0u || (liquid ? field.liquid : field.bodies) == 0u) continue;
        if (!clock.within(field.from, field.until)) continue;
        if (!physics::in_force_region(field, spatial::separation(w.grid, x, field.center))) continue;
        const Vec3<T> from = spatial::separation(w.grid, x, field.about);
        a += physics::force_field_acceleration(field, from, weighed);
        winds.add(field, from);
        bared =
            bared || (liquid && field.kind == physics::ForceKind::hydrostatic &&
                      physics::hydrostatic_share(field, physics::depth_below(from, weighed.gravity)) == T(1));
      }
      // Without a density where the module sph is switched off.
      if (bared && w.f.density != nullptr && w.f.density[i] < static_cast<T>(physics::least_filled))
        w.f.status->level_bared = 1u;
      a += physics::wind_acceleration(winds, v, w.f.acceleration[i] + a, clock.dt);
      Vec3<T> more = a;
      if (liquid) {
        // The correction of images at a floor follows from the whole acceleration.
        const auto walls = physics::wall_view(w.c.walls, x);
        if (walls.axes != 0u)
          more += physics::floor_push(w.c.walls, w.c.kernel, walls, clock.gravity + a) -
                  physics::floor_push(w.c.walls, w.c.kernel, walls, clock.gravity);
      }
      w.f.acceleration[i] += more;
    }
    w.f.field_acceleration[i] = a;
  }
};

/// Work and impulse of force fields on a particle at its present velocity, over half a sub-step.
template <class T>
struct FieldWorkBody {
  Frame<T> w;
  MELTSIM_HD physics::FieldWork operator()(std::uint64_t i) const {
    return physics::half_field_work(w.f.mass[i], w.f.field_acceleration[i], xyz(w.f.velocity[i]),
                                    w.f.clock->dt);
  }
};
template <class T>
struct KeepFieldWorkBody {
  Frame<T> w;
  MELTSIM_HD void operator()(const physics::FieldWork& s) const { w.f.field_account->begun = s; }
};
template <class T>
struct AddFieldWorkBody {
  Frame<T> w;
  MELTSIM_HD void operator()(const physics::FieldWork& s) const {
    w.f.status->field_work += w.f.field_account->begun.work + s.work;
    w.f.status->field_impulse += w.f.field_account->begun.impulse + s.impulse;
  }
};

/// Positions and velocities of particles of kinematic bodies at the end of the sub-step.
template <class T>
struct CarryBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!core::is_carried(w, v)) return;
    const physics::RigidPoint p = core::carried_point(w, v, w.f.clock->end);
    w.f.carried_position[v] = core::wrapped(w, cast<T>(p.position));
    w.f.carried_velocity[v] = cast<T>(p.velocity);
    if (w.f.carried_volume != nullptr)
      w.f.carried_volume[v] = w.c.spacing * w.c.spacing * w.c.spacing *
                              static_cast<T>(core::carried_volume_ratio(w, v, w.f.clock->end));
  }
};

/// Kick, second half drift, walls, periodic wrap, open faces, in place; and the check (shared/advance.hpp).
template <class T>
struct IntegrateBody {
  Frame<T> w;
  static constexpr bool shared = false;
  static constexpr std::uint32_t resident_warps(std::uint32_t) {
    return sizeof(T) == sizeof(float) ? 40 : 32;
  }
  struct Sum {
    MELTSIM_HD void add(const Sum&) {}
  };
  MELTSIM_HD Sum part(std::uint64_t, std::uint32_t, std::uint32_t) const { return {}; }
  using Item = core::Produced<T>;
  MELTSIM_HD Item read(std::uint64_t i) const {
    Item p;
    p.tag = w.f.tag[i];
    if (w.f.density != nullptr) p.phi = w.f.density[i];
    p.position = w.f.position[i];
    p.velocity = w.f.velocity[i];
    p.acceleration = core::acceleration_of(w, i);
    if (w.f.shift != nullptr) p.shift = w.f.shift[i];
    if (w.f.enthalpy != nullptr) p.enthalpy = w.f.enthalpy[i];
    return p;
  }
  template <class Add>
  MELTSIM_HD core::ParticleCheck<T> finish(std::uint64_t i, Sum, const Item& p, const Add& add) const {
    const Vec3<T> v = core::kicked(w, i, p.tag, xyz(p.velocity), p.acceleration);
    const auto end = core::end_of_step(w, i, p, v, add);
    if (end.moved) {
      w.f.position[i] = end.position;
      w.f.velocity[i] = end.velocity;
    }
    return end.check;
  }
};

/// After a saved state came back: where there was none, the World halts.
template <class T>
struct LoadedBody {
  Frame<T> w;
  const std::uint32_t* missing;
  std::uint64_t step;
  MELTSIM_HD void operator()(std::uint64_t) const {
    core::WorldStatus& s = *w.f.status;
    if (*missing == 0u || s.halted != 0u) return;
    s.halt_step = step;
    s.halt_position = reinterpret_cast<std::uintptr_t>(w.f.position);
    s.halt_velocity = reinterpret_cast<std::uintptr_t>(w.f.velocity);
    s.halt_id = reinterpret_cast<std::uintptr_t>(w.f.id);
    s.halt_advanced = 0u;
    s.halted = static_cast<std::uint32_t>(core::Halt::unsaved);
    s.heat_idle |= core::idle_halted;
  }
};

/// Resets the values that count "since the last synchronize()".
template <class T>
struct ClearBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    core::WorldStatus& s = *w.f.status;
    s.max_speed = s.max_density = 0;
    s.courant_exceeded = 0u;
    s.heat_bound_exceeded = 0;
    s.viscous_bound_exceeded = 0;
    s.solute_bound_exceeded = 0;
    s.cooled_to_zero = 0;
    s.level_bared = 0;
    s.reserve_spent = 0u;
  }
};

/// After a roll-back to where velocities are in another order than the rest: back to the slots of their particles.
template <class T>
struct RestoreBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    w.f.velocity[w.f.slot_of_id[w.before.id[k]]] = w.before.velocity[k];
  }
};

/// When the plan changes: enthalpies go from the order of ids to that of slots, or back.
template <class T>
struct EnthalpyBody {
  Frame<T> w;
  bool to_slots;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t id = w.f.id[i];
    if (to_slots) w.f.enthalpy[i] = w.f.enthalpy_of_id[id];
    else w.f.enthalpy_of_id[id] = w.f.enthalpy[i];
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
