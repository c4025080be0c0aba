// SPDX-License-Identifier: Apache-2.0
// Kernels of the liquid and of its coupling to solids. One gather each; formulas in meltsim/physics/.
#pragma once

#include "core/frame.hpp"
#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/heat.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

using core::Frame;
using physics::MaterialRow;

/// V_j [m^3]: of a solid particle the lattice's cell, less for a while after it froze. xj = position[j].
template <class T>
MELTSIM_HD T volume_of(const Frame<T>& w, std::uint64_t j, const Vec4<T>& xj) {
  if (w.f.vertex_grown == nullptr || !is_solid(w.f.tag[j])) return xj.w;
  return xj.w * w.f.vertex_grown[w.f.vertex_of_id[w.f.id[j]]];
}

/// Sum of V W over everything within H of i, and over its images in walls.
template <class T>
MELTSIM_HD T volume_fraction(const Frame<T>& w, std::uint64_t i) {
  T phi = 0;
  const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[i]));
  spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
    T value = physics::kernel_value(w.c.kernel, std::sqrt(r2));
    if (walls.axes != 0u)
      physics::for_each_image(walls, w.c.kernel.support2, x_ij, [&](const Vec3<T>&, T image2) {
        value += physics::kernel_value(w.c.kernel, std::sqrt(image2));
      });
    phi += volume_of(w, j, xj) * value;
  });
  return phi;
}

/// tau_k of every solid particle.
template <class T>
struct SolidTermBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    if (is_solid(w.f.tag[i])) w.f.solid_term[i] = physics::solid_term(volume_fraction(w, i));
  }
};

/// phi and P/phi^2 of every liquid particle.
template <class T>
struct DensityBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_fluid(tag)) {
      w.f.density[i] = T(0);
      w.f.velocity[i].w = T(0);
      return;
    }
    const T phi = volume_fraction(w, i);
    const T pressure =
        physics::tait_pressure(w.f.materials[material_of(tag)].tait_stiffness, phi, w.c.lowest_phi);
    w.f.density[i] = phi;
    w.f.velocity[i].w = physics::pressure_term(pressure, phi);
  }
};

/// mu of every liquid particle, where it depends on temperature.
template <class T>
struct ViscosityBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_fluid(tag)) return;
    w.f.viscosity[i] = physics::viscosity_at(w.f.materials[material_of(tag)],
                                             w.f.enthalpy[i] / static_cast<double>(w.f.mass[i]));
  }
};

/// mu of liquid particle i [Pa s].
template <class T>
MELTSIM_HD T viscosity_of(const Frame<T>& w, std::uint64_t i, const MaterialRow<T>& m) {
  return w.f.viscosity != nullptr ? w.f.viscosity[i] : m.viscosity;
}

/// Pressure, viscosity, gravity and walls on every liquid particle.
template <class T>
struct ForcesBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_fluid(tag)) return;
    const MaterialRow<T>& mi = w.f.materials[material_of(tag)];
    const T vol_i = w.f.position[i].w;
    const Vec4<T> vi = w.f.velocity[i];
    const T mu = viscosity_of(w, i, mi);
    Vec3<T> force{};
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[i]));
    spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
      const Vec4<T> vj = w.f.velocity[j];
      const Vec3<T> v_ij = xyz(vi) - xyz(vj);
      const std::uint32_t tag_j = w.f.tag[j];
      if (is_fluid(tag_j)) {
        const MaterialRow<T>& mj = w.f.materials[material_of(tag_j)];
        const T r = std::sqrt(r2);
        const T f = physics::kernel_gradient_factor(w.c.kernel, r);
        force += physics::pressure_force(vol_i, xj.w, vi.w, vj.w, f, x_ij);
        force += physics::viscous_force(physics::pair_viscosity(mu, viscosity_of(w, j, mj)), vol_i, xj.w,
                                        physics::kernel_laplacian(w.c.kernel, r, r2), -v_ij);
        force += physics::artificial_viscous_force(w.c.kernel, w.c.artificial_viscosity, w.c.sound_speed,
                                                   T(0.5) * (mi.density + mj.density), vol_i, xj.w, f, r2,
                                                   dot(v_ij, x_ij), x_ij);
      } else {
        const T terms = vi.w + mi.tait_stiffness * w.f.solid_term[j];
        const physics::CouplingPair<T> p{vol_i, volume_of(w, j, xj), terms, mu, mi.density, x_ij, v_ij};
        force += physics::coupling_force(w.c.kernel, w.c.artificial_viscosity, w.c.sound_speed, p, r2);
        if (r2 < w.c.leak_distance2)
          force += physics::leak_force(w.c.spacing, w.f.clock->dt, w.f.mass[i], w.f.mass[j], x_ij, v_ij, r2);
      }
      if (walls.axes != 0u) {
        const T term_j = is_fluid(tag_j) ? vj.w : mi.tait_stiffness * w.f.solid_term[j];
        physics::for_each_image(walls, w.c.kernel.support2, x_ij, [&](const Vec3<T>& x, T image2) {
          const T f = physics::kernel_gradient_factor(w.c.kernel, std::sqrt(image2));
          force += physics::pressure_force(vol_i, volume_of(w, j, xj), vi.w, term_j, f, x);
        });
      }
    });
    if (walls.axes != 0u && w.c.no_slip != 0u) force += no_slip(xyz(w.f.position[i]), xyz(vi), mu, vol_i);
    w.f.acceleration[i] = force * (T(1) / w.f.mass[i]) + w.c.gravity;
  }
  /// Traction of every wall within reach, each with its own velocity.
  MELTSIM_HD Vec3<T> no_slip(Vec3<T> x, Vec3<T> v, T mu, T volume) const {
    const auto& b = w.c.walls;
    const T d[6] = {x.x - b.min.x, b.max.x - x.x, x.y - b.min.y, b.max.y - x.y, x.z - b.min.z, b.max.z - x.z};
    Vec3<T> force{};
    for (int k = 0; k < 6; ++k)
      if (((b.faces >> k) & 1u) != 0u && d[k] < b.support)
        force += physics::wall_viscous_force(w.c.wall_exchange, mu, volume, d[k], w.c.wall_velocity[k] - v);
    return force;
  }
};

/// The liquid's push on every solid particle: the exact negatives of what ForcesBody gave the liquid.
template <class T>
struct ReactionBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const std::uint32_t tag = w.f.tag[k];
    if (!is_solid(tag)) return;  // fixed ones too: a host may want the load on an obstacle
    const T vol_k = volume_of(w, k, w.f.position[k]), tau = w.f.solid_term[k];
    const Vec3<T> vk = xyz(w.f.velocity[k]);
    Vec3<T> force{};
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[k]));
    spatial::for_each_neighbour(w, k, [&](std::uint32_t i, const Vec4<T>& xi, const Vec3<T>& x_ki, T r2) {
      const std::uint32_t tag_i = w.f.tag[i];
      if (!is_fluid(tag_i)) return;
      const MaterialRow<T>& mi = w.f.materials[material_of(tag_i)];
      const Vec4<T> vi = w.f.velocity[i];
      const physics::CouplingPair<T> p{
          xi.w,  vol_k,       vi.w + mi.tait_stiffness * tau, viscosity_of(w, i, mi), mi.density,
          -x_ki, xyz(vi) - vk};
      force += -physics::coupling_force(w.c.kernel, w.c.artificial_viscosity, w.c.sound_speed, p, r2);
      if (r2 < w.c.leak_distance2)
        force += -physics::leak_force(w.c.spacing, w.f.clock->dt, w.f.mass[i], w.f.mass[k], -x_ki,
                                      xyz(vi) - vk, r2);
      if (walls.axes != 0u)
        physics::for_each_image(walls, w.c.kernel.support2, x_ki, [&](const Vec3<T>& x, T image2) {
          const T f = physics::kernel_gradient_factor(w.c.kernel, std::sqrt(image2));
          force += physics::pressure_force(p.fluid_volume, vol_k, p.terms, T(0), f, x);
        });
    });
    w.f.acceleration[k] += force * (T(1) / w.f.mass[k]);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
