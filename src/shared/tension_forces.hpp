// SPDX-License-Identifier: Apache-2.0
// Forces of surface tension on one particle, for the step, for watched bodies and for probes of kind `force`; formulas in
// meltsim/physics/surface_tension.hpp.
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/surface_tension.hpp"
#include "meltsim/physics/walls.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Images of a neighbour, each with the shape of grad W at its distance: their sum, that of x_m times it, and of the part of x_m
/// along the planes' normals.
template <class T>
struct GradientImages {
  T shape;
  Vec3<T> x, normal;
};
template <class T>
MELTSIM_HD GradientImages<T> gradient_images(const Frame<T>& w, const physics::WallView<T>& walls,
                                             Vec3<T> x_ij, T r2) {
  const auto sums = physics::image_sums(walls, w.c.kernel.support2, x_ij, r2, [&](T square) {
    return physics::kernel_gradient_shape(w.c.kernel, std::sqrt(square));
  });
  const Vec3<T> steps = physics::image_steps(walls, x_ij, sums), a = sums.across;
  return {sums.all, x_ij * sums.all + steps, Vec3<T>{x_ij.x * a.x, x_ij.y * a.y, x_ij.z * a.z} + steps};
}

template <class T>
MELTSIM_HD physics::SurfaceStress<T> surface_stress_of(const Frame<T>& w, std::uint64_t i) {
  return {w.f.surface_along[i], w.f.surface_shear[i]};
}

/// Force of a solid particle k on liquid i [N]: of surface stress and adhesion.
template <class T>
MELTSIM_HD Vec3<T> tension_of_solid(const Frame<T>& w, const physics::SurfaceStress<T>& stress, Vec3<T> wall,
                                    T strength, T volumes, Vec3<T> x_ik, T r2) {
  const T r = std::sqrt(r2);
  return physics::mirrored_sum(stress, wall, x_ik) *
             (-volumes * physics::kernel_gradient_factor(w.c.kernel, r)) +
         x_ik * (volumes * strength * physics::cohesion_shape(w.c.kernel, r));
}

/// Force of the images of a neighbour on liquid i [N]; strength = that of cohesion with them.
template <class T>
MELTSIM_HD Vec3<T> tension_of_images(const Frame<T>& w, const physics::WallView<T>& walls,
                                     const physics::SurfaceStress<T>& stress, Vec3<T> wall, T strength,
                                     T volumes, Vec3<T> x_ij, T r2) {
  const Vec3<T> x = gradient_images(w, walls, x_ij, r2).x;
  const auto sums = physics::image_sums(walls, w.c.kernel.support2, x_ij, r2, [&](T square) {
    return physics::cohesion_shape(w.c.kernel, std::sqrt(square));
  });
  const auto cohesion = physics::image_force(walls, x_ij, sums, volumes * strength);
  return physics::mirrored_sum(stress, wall, x) * (-volumes * w.c.kernel.grad_scale) +
         (x_ij * cohesion.along + cohesion.normal);
}

/// Strength of cohesion with the images of a neighbour [N/m^7]: of liquid as a wall, of a solid as that solid.
template <class T>
MELTSIM_HD T image_strength(const Frame<T>& w, T strength, std::uint32_t other) {
  return is_solid(other) ? physics::adhesion_of(strength, w.f.materials[material_of(other)].wetting)
                         : T(2) * physics::adhesion_of(strength, w.c.wall_wetting);
}

/// Force of surface tension on a liquid particle [N].
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> tension_on_liquid(const Frame<T>& w, std::uint64_t i, std::uint32_t tag) {
  const T strength = w.f.materials[material_of(tag)].cohesion;
  const T viscosity = w.f.materials[material_of(tag)].skin_viscosity, skin = w.f.surface_skin[i];
  const physics::SurfaceStress<T> own = surface_stress_of(w, i);
  const Vec3<T> wall = xyz(w.f.surface_wall[i]), v = xyz(w.f.velocity[i]);
  const T free = w.f.surface_wall[i].w;
  const Vec4<T> x = w.f.position[i];
  const auto walls = physics::wall_view(w.c.walls, xyz(x));
  Vec3<T> force{};
  spatial::sweep_part<Periodic>(
      w, i, 0u, 1u, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
        const std::uint32_t other = w.f.tag[j];
        const MaterialRow<T>& m = w.f.materials[material_of(other)];
        const T volumes = x.w * xj.w;
        if (is_fluid(other)) {
          const T r = std::sqrt(r2);
          force += (own + surface_stress_of(w, j)) * x_ij *
                   (-volumes * physics::kernel_gradient_factor(w.c.kernel, r));
          const T cohesion = physics::cohesion_of(strength, m.cohesion, free, w.f.surface_wall[j].w);
          force +=
              x_ij * (physics::cohesion_factor(x.w, xj.w, cohesion) * physics::cohesion_shape(w.c.kernel, r));
          const T shared = physics::skin_viscosity_of(viscosity, m.skin_viscosity, skin, w.f.surface_skin[j]);
          if (shared > T(0))
            force += physics::skin_force(w.c.kernel, volumes, shared, x_ij, v - xyz(w.f.velocity[j]), r2);
        } else if (is_solid(other)) {
          force +=
              tension_of_solid(w, own, wall, physics::adhesion_of(strength, m.wetting), volumes, x_ij, r2);
        } else {
          return;
        }
        if (walls.axes != 0u)
          force +=
              tension_of_images(w, walls, own, wall, image_strength(w, strength, other), volumes, x_ij, r2);
      });
  return force;
}

/// The part of that force that images in walls exert [N].
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> tension_of_walls(const Frame<T>& w, std::uint64_t i, std::uint32_t tag) {
  const T strength = w.f.materials[material_of(tag)].cohesion;
  const physics::SurfaceStress<T> own = surface_stress_of(w, i);
  const Vec4<T> x = w.f.position[i];
  const auto walls = physics::wall_view(w.c.walls, xyz(x));
  Vec3<T> force{};
  spatial::sweep_part<Periodic>(
      w, i, 0u, 1u, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
        const std::uint32_t other = w.f.tag[j];
        if (!is_fluid(other) && !is_solid(other)) return;
        force += tension_of_images(w, walls, own, xyz(w.f.surface_wall[i]),
                                   image_strength(w, strength, other), x.w * xj.w, x_ij, r2);
      });
  return force;
}

/// Force of surface tension on a particle of a body [N]: the negatives of what it gives liquid.
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> tension_on_solid(const Frame<T>& w, std::uint64_t k, std::uint32_t tag) {
  const T cosine = w.f.materials[material_of(tag)].wetting, volume = w.f.position[k].w;
  Vec3<T> force{};
  spatial::sweep_part<Periodic>(
      w, k, 0u, 1u, [&](std::uint32_t i, const Vec4<T>& xi, const Vec3<T>& x_ki, T r2) {
        const std::uint32_t other = w.f.tag[i];
        if (!is_fluid(other)) return;
        const T strength = w.f.materials[material_of(other)].cohesion;
        if (!(strength > T(0))) return;
        force += -tension_of_solid(w, surface_stress_of(w, i), xyz(w.f.surface_wall[i]),
                                   physics::adhesion_of(strength, cosine), xi.w * volume, -x_ki, r2);
      });
  return force;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
