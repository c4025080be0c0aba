// SPDX-License-Identifier: Apache-2.0
// Kernel of particle shifting: one gather; formulas in meltsim/physics/shifting.hpp.
#pragma once

#include "meltsim/physics/shifting.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

/// Displacement of every liquid particle beside the flow; step.integrate applies it.
template <class T>
struct ShiftBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    w.f.shift[i] = Vec3<T>{};
    if (!is_fluid(w.f.tag[i])) return;
    const T inv_w_dx = T(1) / physics::kernel_value(w.c.kernel, w.c.spacing);
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[i]));
    Vec3<T> g{};
    spatial::for_each_neighbour(w, i, [&](std::uint32_t, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
      const T volume = xj.w;
      g += physics::shift_term(w.c.kernel, inv_w_dx, volume, std::sqrt(r2), x_ij);
      if (walls.axes != 0u)
        physics::for_each_image(walls, w.c.kernel.support2, x_ij, [&](const Vec3<T>& x, T image2) {
          g += physics::shift_term(w.c.kernel, inv_w_dx, volume, std::sqrt(image2), x);
        });
    });
    w.f.shift[i] = physics::shift_displacement(w.c.kernel, w.c.spacing, w.c.sound_speed, w.f.clock->dt,
                                               w.f.density[i], g);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
