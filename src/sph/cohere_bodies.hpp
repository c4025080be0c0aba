// SPDX-License-Identifier: Apache-2.0
// Kernels of surface tension: one gather for the stress of a surface, one for its forces; formulas in
// meltsim/physics/surface_tension.hpp.
#pragma once

#include "shared/tension_forces.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

/// Surface stress of every particle of liquid with tension, 0 of all others.
template <class T, bool Periodic>
struct SurfaceStressBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    physics::SurfaceStress<T> stress;
    Vec3<T> wall{};
    T free{}, skin{};
    const std::uint32_t tag = w.f.tag[i];
    const T tension = is_fluid(tag) ? w.f.materials[material_of(tag)].tension : T(0);
    if (tension > T(0)) {
      const physics::SurfaceSums<T> sums = sums_of(i, tag, tension);
      stress = physics::surface_stress(w.c.kernel, tension, w.f.density[i], sums);
      wall = physics::wall_direction(sums);
      free = physics::free_share(w.c.kernel, sums);
      skin = physics::skin_share(w.c.kernel, sums);
    }
    w.f.surface_along[i] = stress.along;
    w.f.surface_shear[i] = stress.shear;
    w.f.surface_wall[i] = Vec4<T>{wall.x, wall.y, wall.z, free};
    w.f.surface_skin[i] = skin;
  }
  MELTSIM_HD physics::SurfaceSums<T> sums_of(std::uint64_t i, std::uint32_t tag, T tension) const {
    physics::SurfaceSums<T> sums;
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[i]));
    spatial::sweep_part<Periodic>(
        w, i, 0u, 1u, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
          const T shape = physics::kernel_gradient_shape(w.c.kernel, std::sqrt(r2));
          const std::uint32_t other = w.f.tag[j];
          T cosine = w.c.wall_wetting;
          if (is_fluid(other)) {
            T share = 1;
            if (material_of(other) != material_of(tag))
              share = physics::liquid_share(tension, w.f.materials[material_of(other)].tension);
            sums.add(xj.w, share, shape, x_ij);
          } else if (is_solid(other)) {
            cosine = w.f.materials[material_of(other)].wetting;
            sums.add_solid(xj.w, cosine, shape, x_ij * shape, x_ij * shape);
          } else {
            return;
          }
          if (walls.axes == 0u) return;
          const auto images = core::gradient_images(w, walls, x_ij, r2);
          sums.add_solid(xj.w, cosine, images.shape, images.x, images.normal);
        });
    return sums;
  }
};

/// Forces of the surface stress, of cohesion and of the skin, on liquid and on bodies that can move.
template <class T, bool Periodic>
struct CohereBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    Vec3<T> force{};
    if (is_fluid(tag)) force = core::tension_on_liquid<Periodic>(w, i, tag);
    else if (is_solid(tag) && !is_held(tag)) force = core::tension_on_solid<Periodic>(w, i, tag);
    else return;
    w.f.acceleration[i] += force * (T(1) / w.f.mass[i]);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
