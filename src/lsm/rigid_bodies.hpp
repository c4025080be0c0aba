// SPDX-License-Identifier: Apache-2.0
// Kernels of rigid bodies: exact sums per piece, the motion of every piece, and the new positions of its particles
// (physics/rigid_piece.hpp). Data of a piece are stored at its label vertex.
#pragma once

#include "frame/lattice.hpp"
#include "shared/advance.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

using core::Frame;
using core::none;

/// Whether a vertex is of a rigid body or a proxy.
template <class T>
MELTSIM_HD bool of_rigid(const Frame<T>& w, std::uint64_t v) {
  return core::moves_rigidly(w.f.bodies[w.f.vertex_body[v]]);
}
/// Whether it holds a particle of one.
template <class T>
MELTSIM_HD bool is_rigid(const Frame<T>& w, std::uint64_t v) {
  return w.f.vertex_state[v] == core::vertex_live && of_rigid(w, v);
}

/// Position in the lattice as built relative to another vertex of the body [m].
template <class T>
MELTSIM_HD Vec3<double> rest_offset(const Frame<T>& w, std::uint64_t v, std::uint32_t from) {
  const std::uint32_t body = w.f.vertex_body[v];
  return (core::steps_in_box(w, v, body) - core::steps_in_box(w, from, body)) * w.f.body_motion[body].spacing;
}

/// What positions of a piece are relative to: the particle of its label, which may have melted by now.
template <class T>
MELTSIM_HD Vec3<double> origin_of(const Frame<T>& w, std::uint32_t label) {
  const std::uint32_t id = w.f.vertex_id[label];
  return id == none ? Vec3<double>{} : cast<double>(xyz(w.f.position[w.f.slot_of_id[id]]));
}

/// Empties the sums of a piece.
template <class T>
struct ClearRigidBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (of_rigid(w, v) && w.f.vertex_piece[v] == v) w.f.rigid_sums[v] = core::RigidSums{};
  }
};

/// Adds a particle to the sums of its piece, exactly. Positions are relative to the particle of the piece's label, and a
/// piece may be longer than half a period: its rotation says which image is meant.
template <class T>
struct RigidSumsBody {
  Frame<T> w;
  using Sum = core::RigidSums;
  /// The row of the vertex, or none.
  MELTSIM_HD std::uint32_t operator()(std::uint64_t v, Sum& s) const {
    if (!is_rigid(w, v)) return none;
    const std::uint32_t slot = w.f.slot_of_id[w.f.vertex_id[v]], label = w.f.vertex_piece[v];
    const Vec3<T> velocity = xyz(w.f.velocity[slot]), kick = w.f.acceleration[slot] * w.f.clock->dt;
    if (!finite(kick)) return none;  // step.integrate reports it
    const Vec3<double> q = rest_offset(w, v, label);
    Vec3<double> u = cast<double>(xyz(w.f.position[slot])) - origin_of(w, label);
    if (w.grid.periodic != 0u) {
      const Vec3<double> near = rotate(w.f.rigid_rotation[label], q), period = cast<double>(w.grid.period);
      u = core::nearest_image(u, near, period);
    }
    const Vec3<double> before = cast<double>(velocity);
    core::count_particle(s, w.sum_units, static_cast<double>(w.f.mass[slot]), u, q, before,
                         before + cast<double>(kick));
    return label;
  }
};

/// Moves every piece.
template <class T>
struct RigidStepBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!of_rigid(w, v) || w.f.vertex_piece[v] != v) return;
    const physics::RigidPieceSums sums = core::rigid_sums_of(w.f.rigid_sums[v], w.sum_units);
    const double dt = static_cast<double>(w.f.clock->dt);
    // A site without a particle belongs to no piece, so a proxy takes no step there.
    if (w.f.bodies[w.f.vertex_body[v]].motion == core::body_proxy && sums.mass > 0)
      w.f.rigid_step[v] = step_of_proxy(v, sums, dt);
    else w.f.rigid_step[v] = physics::rigid_step(sums, w.f.rigid_rotation[v], dt);
  }
  /// Step of a proxy from the forces on its particles; mass and inertia are the host's.
  MELTSIM_HD physics::RigidPieceStep step_of_proxy(std::uint64_t v, const physics::RigidPieceSums& sums,
                                                   double dt) const {
    const std::uint32_t body = w.f.vertex_body[v];
    const core::BodyMotionRow& row = w.f.body_motion[body];
    const Vec3<double> gravity = cast<double>(w.f.clock->gravity);
    // Places of the sums are from the particle of the label; the centre of mass in the middle of the sub-step from there.
    Vec3<double> center = row.motion.first.position + row.motion.first.velocity * (0.5 * dt) -
                          origin_of(w, static_cast<std::uint32_t>(v));
    const Vec3<double> rest = -(row.low + core::steps_in_box(w, v, body) * row.spacing);
    if (w.grid.periodic != 0u) {
      const Vec3<double> near = rotate(row.motion.first.orientation, rest),
                         period = cast<double>(w.grid.period);
      center = core::nearest_image(center, near, period);
    }
    const Vec3<double> kick = sums.kicked_momentum - sums.momentum, turn = sums.kicked_spin - sums.spin;
    // Gravity acts on particles, too; on their centre, which need not be the host's.
    const Vec3<double> impulse = kick - gravity * (sums.mass * dt);
    const Vec3<double> angular = turn - cross(sums.first, gravity * dt) - cross(center, impulse);
    physics::RigidPieceStep step = physics::proxy_step(row.mass, row.inertia, rest, row.motion, impulse,
                                                       angular, gravity, w.f.clock->time, dt);
    // From the beginning of the sub-step to the particle of the label in its middle.
    step.center += center - row.motion.first.velocity * (0.5 * dt);
    return step;
  }
};

/// Velocity that the rigid piece adds to a particle beside its own acceleration, as shape matching does for
/// a particle of a free body. Implicit viscosity includes it, so that liquid meets the motion of the piece, not that of a particle
/// that only the pressure accelerates.
template <class T>
struct RigidShapeBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!is_rigid(w, v)) return;
    const std::uint32_t label = w.f.vertex_piece[v], slot = w.f.slot_of_id[w.f.vertex_id[v]];
    const physics::RigidPoint p = physics::point_of(w.f.rigid_step[label], rest_offset(w, v, label));
    w.f.shape_velocity[v] =
        cast<T>(p.velocity - cast<double>(xyz(w.f.velocity[slot]))) - w.f.acceleration[slot] * w.f.clock->dt;
  }
};

/// Where the particles of a piece are at the end of the sub-step, and how fast then.
template <class T>
struct RigidPlaceBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!is_rigid(w, v)) return;
    const std::uint32_t label = w.f.vertex_piece[v];
    const physics::RigidPoint p = physics::point_of(w.f.rigid_step[label], rest_offset(w, v, label));
    w.f.carried_position[v] = core::wrapped(w, cast<T>(origin_of(w, label) + p.position));
    w.f.carried_velocity[v] = cast<T>(p.velocity);
  }
};

/// Stores rotations and slips as state once the sub-step counts. A label keeps the rotation of its piece also where it has
/// melted itself, until pieces are searched again.
template <class T>
struct RigidCommitBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!of_rigid(w, v)) return;
    const std::uint32_t body = w.f.vertex_body[v];
    const physics::RigidPieceStep& step = w.f.rigid_step[w.f.vertex_piece[v]];
    if (!(step.mass > 0)) return;
    if (w.f.bodies[body].motion == core::body_proxy && w.f.vertex_piece[v] == v)
      w.f.body_motion[body].motion = physics::proxy_after(w.f.body_motion[body].motion, step, w.f.clock->time,
                                                          static_cast<double>(w.f.clock->dt));
    const Quat<double> q = step.rotation;
    w.f.rigid_rotation[v] = q;
    w.f.region_rotation[v] = {static_cast<T>(q.w), static_cast<T>(q.x), static_cast<T>(q.y),
                              static_cast<T>(q.z)};
    if (w.f.vertex_state[v] != core::vertex_live) return;
    const Vec4<T> slip = w.f.slip_next[w.f.slot_of_id[w.f.vertex_id[v]]];
    w.f.contact_slip[v] = slip.w > T(0) ? xyz(slip) * (T(1) / slip.w) : Vec3<T>{};
  }
};

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
