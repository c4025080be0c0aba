// SPDX-License-Identifier: Apache-2.0
// Forces on one particle of a body, for the step and for probes of kind `force`.
#pragma once

#include "engine/frame.hpp"
#include "meltsim/physics/contact.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// mu of liquid particle i [Pa s].
template <class T>
MELTSIM_HD T viscosity_of(const Frame<T>& w, std::uint64_t i, const MaterialRow<T>& m) {
  return w.f.viscosity != nullptr ? w.f.viscosity[i] : m.viscosity;
}

/// One part of the liquid's force on solid particle k [N]: the negatives of what sph.forces gives the liquid, the images
/// in walls included.
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> liquid_on_solid(const Frame<T>& w, std::uint64_t k, std::uint32_t share,
                                   std::uint32_t parts) {
  Vec3<T> force{};
  const Vec4<T> vk4 = w.f.velocity[k];
  const T vol_k = w.f.position[k].w, tau = -vk4.w;
  const Vec3<T> vk = xyz(vk4);
  const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[k]));
  spatial::sweep_part<Periodic>(
      w, k, share, parts, [&](std::uint32_t i, const Vec4<T>& xi, const Vec3<T>& x_ki, T r2) {
        const std::uint32_t tag_i = w.f.tag[i];
        if (!is_fluid(tag_i)) return;
        const MaterialRow<T>& mi = w.f.materials[material_of(tag_i)];
        const Vec4<T> vi = w.f.velocity[i];
        const physics::CouplingPair<T> p{
            xi.w,  vol_k,       vi.w + mi.tait_stiffness * tau, viscosity_of(w, i, mi), mi.density,
            -x_ki, xyz(vi) - vk};
        force += -physics::coupling_force(w.c.kernel, w.c.artificial_viscosity, w.c.sound_speed, p, r2);
        if (r2 < w.c.leak_distance2)
          force += -physics::leak_force(w.c.spacing, w.f.clock->spring_dt, w.f.mass[i], w.f.mass[k], -x_ki,
                                        xyz(vi) - vk, r2);
        if (walls.axes != 0u) {
          const auto images =
              physics::image_pressure_force(w.c.kernel, walls, x_ki, r2, p.fluid_volume, vol_k, p.terms);
          force += x_ki * images.along + images.normal;
        }
      });
  return force;
}

/// Slip of a solid particle along its contacts [m].
template <class T>
MELTSIM_HD Vec3<T> slip_of(const Frame<T>& w, std::uint64_t i) {
  return w.f.contact_slip == nullptr ? Vec3<T>{} : w.f.contact_slip[w.f.vertex_of_id[w.f.id[i]]];
}

/// Contact of solid particle i, of velocity v, with a wall. The smaller of both friction coefficients holds.
template <class T>
struct WallContact {
  physics::ContactResponse<T> response;
  bool touches = false;
};
template <class T>
MELTSIM_HD WallContact<T> wall_contact(const Frame<T>& w, std::uint64_t i, std::uint32_t tag, Vec3<T> x,
                                       Vec3<T> v, Vec3<T> slip, int face) {
  const T depth = physics::wall_overlap(w.c.walls, T(0.5) * w.c.spacing, x, face);
  if (((w.c.walls.faces >> face) & 1u) == 0u || !(depth > T(0))) return {};
  const T friction = minimum(w.f.materials[material_of(tag)].friction, w.c.wall_friction);
  return {physics::contact_response(physics::body_contact<T>(), depth, physics::wall_normal<T>(face),
                                    v - w.c.wall_velocity[face], slip, w.f.mass[i], friction, w.f.clock->dt,
                                    w.f.clock->spring_dt),
          true};
}

/// Operands of contact of a particle at the surface of a movable body.
template <class T>
struct Toucher {
  std::uint64_t i = 0;
  std::uint32_t tag = 0, piece = 0;
  Vec3<T> velocity{}, slip{};
  Vec4<T> normal{};
};
template <class T>
MELTSIM_HD Toucher<T> toucher(const Frame<T>& w, std::uint64_t i) {
  return {i, w.f.tag[i], w.f.piece[i], xyz(w.f.velocity[i]), slip_of(w, i), w.f.contact_normal[i]};
}

/// Contact of a with particle j of another piece; weight 0 if none. The mean of both friction coefficients holds.
template <class T>
struct PairContact {
  physics::ContactResponse<T> response;
  T weight{};
};
template <class T>
MELTSIM_HD PairContact<T> pair_contact(const Frame<T>& w, const Toucher<T>& a, std::uint32_t j, Vec3<T> x_aj,
                                       T r2) {
  const T reach2 = T(2) * w.c.spacing * w.c.spacing;  // overlap and offset both below one spacing
  if (!(r2 < reach2) || !(r2 > T(0))) return {};
  const std::uint32_t other = w.f.piece[j];
  if (other == 0u || other == a.piece) return {};
  const std::uint32_t tag_j = w.f.tag[j];
  if ((tag_j & tag_surface) == 0u) return {};
  const physics::ContactGeometry<T> g =
      physics::contact_geometry(a.normal, w.f.contact_normal[j], x_aj, r2, w.c.spacing);
  if (!(g.overlap > T(0)) || !(g.weight > T(0))) return {};
  const bool held = (tag_j & tag_fixed) != 0u;
  const T m = held ? w.f.mass[a.i] : physics::reduced_mass(w.f.mass[a.i], w.f.mass[j]);
  const Vec3<T> slip = held ? a.slip : (a.slip - slip_of(w, j)) * T(0.5);
  const T friction =
      T(0.5) * (w.f.materials[material_of(a.tag)].friction + w.f.materials[material_of(tag_j)].friction);
  return {physics::contact_response(physics::body_contact<T>(), g.overlap, g.normal,
                                    a.velocity - xyz(w.f.velocity[j]), slip, m * g.weight, friction,
                                    w.f.clock->dt, w.f.clock->spring_dt),
          g.weight};
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
