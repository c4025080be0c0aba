// SPDX-License-Identifier: Apache-2.0
// Kernels of what seeps between bodies and walls (physics/seepage.hpp): areas of a particle's underside, sums over rims.
#pragma once

#include "shared/pair_forces.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

using core::Frame;

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
  Frame<T> w;
  static constexpr bool shared = true;
  using Sum = physics::SeepageSums<T>;
  MELTSIM_HD Sum part(std::uint64_t k, std::uint32_t share, std::uint32_t parts) const {
    Sum s;
    if (!core::can_seep(w.f.tag[k])) return s;
    const Vec4<T> xk = w.f.position[k];
    const auto walls = physics::wall_view(w.c.walls, xyz(xk));
    if (walls.axes == 0u) return s;
    const T tau = -w.f.velocity[k].w;
    spatial::sweep_part<Periodic>(w, k, share, parts,
                                  [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_kj, T r2) {
                                    s.add(w.c.kernel, walls, neighbour(j, tau, x_kj), xk.w * xj.w, x_kj, r2);
                                  });
    return s;
  }
  MELTSIM_HD physics::SeepageNeighbour<T> neighbour(std::uint32_t j, T tau, const Vec3<T>& x_kj) const {
    const std::uint32_t tag = w.f.tag[j];
    if (is_solid(tag)) return {true, T(0), T(0), T(0)};
    const core::MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const T pair = T(0.5) * (w.f.velocity[j].w + m.tait_stiffness * tau);
    return {false, pair, pair + m.density * dot(w.f.clock->gravity, x_kj), m.density};
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
    w.f.under_area[v] = {under[0], under[1], under[2]};
    w.f.under_force[v] = {filled[0], filled[1], filled[2]};
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

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
