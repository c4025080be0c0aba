// SPDX-License-Identifier: Apache-2.0
// Kernel of surface tension: one gather; formulas in meltsim/physics/surface_tension.hpp.
#pragma once

#include "meltsim/physics/surface_tension.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

/// Attraction between liquids, and between liquid and solids, on all that can move; walls attract by images.
template <class T, bool Periodic>
struct CohereBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    const bool liquid = is_fluid(tag);
    if (!liquid && (!is_solid(tag) || is_held(tag))) return;
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    if (liquid && !(m.cohesion > T(0))) return;
    const Vec4<T> x = w.f.position[i];
    const auto walls = physics::wall_view(w.c.walls, xyz(x));
    Vec3<T> force{};
    spatial::sweep_part<Periodic>(
        w, i, 0u, 1u, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
          const std::uint32_t other = w.f.tag[j];
          const MaterialRow<T>& o = w.f.materials[material_of(other)];
          T strength = 0;
          if (is_fluid(other))
            strength = liquid ? physics::cohesion_of(m.cohesion, o.cohesion)
                              : physics::adhesion_of(o.cohesion, m.wetting);
          else if (liquid && is_solid(other)) strength = physics::adhesion_of(m.cohesion, o.wetting);
          if (!(strength > T(0))) return;
          const T factor = physics::cohesion_factor(x.w, xj.w, strength);
          force += x_ij * (factor * physics::cohesion_shape(w.c.kernel, std::sqrt(r2)));
          if (walls.axes == 0u) return;
          const auto sums = physics::image_sums(walls, w.c.kernel.support2, x_ij, r2, [&](T square) {
            return physics::cohesion_shape(w.c.kernel, std::sqrt(square));
          });
          const auto images = physics::image_force(walls, x_ij, sums, factor * w.c.wall_wetting);
          force += x_ij * images.along + images.normal;
        });
    w.f.acceleration[i] += force * (T(1) / w.f.mass[i]);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
