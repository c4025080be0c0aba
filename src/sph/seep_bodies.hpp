// SPDX-License-Identifier: Apache-2.0
// Kernels of what seeps between bodies and walls (physics/seepage.hpp) and between bodies (physics/gap.hpp): areas of a particle's
// underside, sums over rims.
#pragma once

#include "shared/at_rest.hpp"
#include "shared/pair_forces.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

using core::Frame;

/// What liquid j tells a particle of a body.
template <class T>
struct LiquidBeside {
  T pressure{};  ///< mean of the pair [Pa]
  T level{};     ///< the same, taken to the height of the particle [Pa]
  T density{};   ///< as far as it weighs: less what hydrostatic fields take out [kg/m^3]
};
/// taken: density of core::at_rest() where the particle is.
template <class T>
MELTSIM_HD LiquidBeside<T> liquid_beside(const Frame<T>& w, std::uint32_t j, std::uint32_t tag, T tau,
                                         const Vec3<T>& x_kj, T taken) {
  const core::MaterialRow<T>& m = w.f.materials[material_of(tag)];
  const T pair = T(0.5) * (w.f.velocity[j].w + m.tait_stiffness * tau);
  const T density = m.density - taken;
  return {pair, pair + density * dot(w.f.clock->gravity, x_kj), density};
}

/// Empties the sums of a piece.
template <class T>
struct ClearRimsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.vertex_piece[v] == v) w.f.rim_sums[v] = core::RimSums{};
  }
};

/// Underside of every particle of a body that can move, per axis, and what presses on it; what it adds to the rim of its piece.
template <class T, bool Periodic>
struct SeepBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool shared = true;
  using Sum = physics::SeepageSums<T>;
  MELTSIM_HD Sum part(std::uint64_t k, std::uint32_t share, std::uint32_t parts) const {
    Sum s;
    if (!core::can_seep(w.f.tag[k])) return s;
    const Vec4<T> xk = w.f.position[k];
    const auto walls = physics::wall_view(w.c.walls, xyz(xk));
    if (walls.axes == 0u) return s;
    const T tau = -w.f.velocity[k].w, taken = core::at_rest(w, xyz(xk)).density;
    spatial::sweep_part<Periodic>(
        w, k, share, parts, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_kj, T r2) {
          s.add(w.c.kernel, walls, neighbour(j, tau, x_kj, taken), xk.w * xj.w, x_kj, r2);
        });
    return s;
  }
  MELTSIM_HD physics::SeepageNeighbour<T> neighbour(std::uint32_t j, T tau, const Vec3<T>& x_kj,
                                                    T taken) const {
    const std::uint32_t tag = w.f.tag[j];
    if (is_solid(tag)) return {true, T(0), T(0), T(0)};
    const LiquidBeside<T> l = liquid_beside(w, j, tag, tau, x_kj, taken);
    return {false, l.pressure, l.level, l.density};
  }
  template <class Add>
  MELTSIM_HD void finish(std::uint64_t k, const Sum& s, const Add& add) const {
    if (!core::can_seep(w.f.tag[k])) return;
    const std::uint32_t v = w.f.vertex_of_id[w.f.id[k]];
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[k]));
    T under[3] = {}, filled[3] = {};
    for (int axis = 0; axis < 3; ++axis) {
      if ((walls.axes >> axis & 1u) == 0u) continue;
      const auto face = physics::seepage_face(s, walls, axis, w.c.spacing, w.f.clock->gravity);
      under[axis] = face.under;
      filled[axis] = face.filled;
      if (face.area > T(0)) to_rim(w.f.rim_sums[w.f.vertex_piece[v]], axis, face, add);
    }
    w.f.under[v] = {{under[0], under[1], under[2]}, {filled[0], filled[1], filled[2]}};
  }
  template <class Add>
  MELTSIM_HD void to_rim(core::RimSums& to, int axis, const physics::SeepageFace<T>& face,
                         const Add& add) const {
    const double dx = static_cast<double>(w.c.spacing), dt = static_cast<double>(w.f.clock->dt);
    add(&to.area[axis], core::counted(static_cast<double>(face.area) / (dx * dx), core::rim_area()));
    add(&to.press[axis], core::counted(static_cast<double>(face.press) * dt, w.sum_units.momentum));
    add(&to.slope[axis], core::counted(static_cast<double>(face.slope) * dx * dt, w.sum_units.momentum));
  }
};

/// Empties the sums of a piece over the rims of its gaps to others.
template <class T>
struct ClearGapsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.vertex_piece[v] == v) w.f.gap_sums[v] = core::GapRimSums{};
  }
};

/// Unit vector along gravity, 0 without.
template <class T>
MELTSIM_HD Vec3<T> down_of(const Frame<T>& w) {
  const Vec3<T> g = w.f.clock->gravity;
  const T size = length(g);
  return size > T(0) ? g * (T(1) / size) : Vec3<T>{};
}

/// Length along gravity by which a particle lies below that of its piece's label [m].
template <class T>
MELTSIM_HD T below_label(const Frame<T>& w, std::uint32_t label, Vec3<T> x) {
  const Vec3<T> at = xyz(w.f.position[w.f.slot_of_id[w.f.vertex_id[label]]]);
  return dot(spatial::separation(w.grid, x, at), down_of(w));
}

/// What every particle at the surface of a body that can move asks of the gap to other pieces; what it adds to the rim of its own.
template <class T, bool Periodic>
struct GapBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool shared = true;
  using Sum = physics::GapSums<T>;
  MELTSIM_HD Sum part(std::uint64_t k, std::uint32_t share, std::uint32_t parts) const {
    Sum s;
    if (!core::asks_of_gap(w.f.tag[k])) return s;
    const Vec4<T> xk = w.f.position[k];
    const auto walls = physics::wall_view(w.c.walls, xyz(xk));
    const T tau = -w.f.velocity[k].w, taken = core::at_rest(w, xyz(xk)).density;
    const std::uint32_t piece = w.f.piece[k];
    spatial::sweep_part<Periodic>(
        w, k, share, parts, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_kj, T r2) {
          s.add(w.c.kernel, walls, neighbour(j, piece, tau, x_kj, taken), xk.w * xj.w, x_kj, r2);
        });
    return s;
  }
  MELTSIM_HD physics::GapNeighbour<T> neighbour(std::uint32_t j, std::uint32_t piece, T tau,
                                                const Vec3<T>& x_kj, T taken) const {
    const std::uint32_t tag = w.f.tag[j];
    physics::GapNeighbour<T> n;
    if (is_solid(tag)) {
      n.solid = true;
      n.own = w.f.piece[j] == piece;
      n.faces = !n.own && (tag & tag_surface) != 0u;
      return n;
    }
    const LiquidBeside<T> l = liquid_beside(w, j, tag, tau, x_kj, taken);
    n.pressure = l.pressure;
    n.level = l.level;
    n.density = l.density;
    return n;
  }
  template <class Add>
  MELTSIM_HD void finish(std::uint64_t k, const Sum& s, const Add& add) const {
    if (!core::asks_of_gap(w.f.tag[k])) return;
    const std::uint32_t label = w.f.piece[k] - 1u;
    const auto face = physics::gap_face(s, w.c.spacing, w.c.gap_scale);
    const Vec3<T> down = down_of(w);
    w.f.gap_push[k] = {face.side, face.filled, dot(face.across, down), length(s.facing)};
    if (!(face.area > T(0))) return;
    const double dx = static_cast<double>(w.c.spacing), dt = static_cast<double>(w.f.clock->dt);
    const T slope = face.weight * length(w.f.clock->gravity);
    const T press = face.press - slope * below_label(w, label, xyz(w.f.position[k]));
    core::GapRimSums& to = w.f.gap_sums[label];
    add(&to.area, core::counted(static_cast<double>(face.area) / (dx * dx), core::rim_area()));
    add(&to.press, core::counted(static_cast<double>(press) * dt, w.sum_units.momentum));
    add(&to.slope, core::counted(static_cast<double>(slope) * dx * dt, w.sum_units.momentum));
  }
};

/// The pressure that a particle asks for in its pairs, once the rims are summed; before, push.z is how far below it the gap is.
template <class T>
struct GapPushBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    if (!core::asks_of_gap(w.f.tag[k])) return;
    Vec4<T>& push = w.f.gap_push[k];
    const std::uint32_t label = w.f.piece[k] - 1u;
    push.z = core::gap_pressure_of(w.f.gap_sums[label], w.sum_units, push.x, push.y,
                                   below_label(w, label, xyz(w.f.position[k])) + push.z, w.c.spacing,
                                   w.f.clock->dt);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
