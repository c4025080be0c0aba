// SPDX-License-Identifier: Apache-2.0
// Kernels of probes that sum over particles: forces on bodies and walls, heat into them, flux through an opening. Each
// body gives what one particle adds. They run behind all forces and heat, before step.integrate.
#pragma once

#include "meltsim/physics/heat_boundary.hpp"
#include "meltsim/physics/sampling.hpp"
#include "sampling/bodies.hpp"
#include "shared/advance.hpp"
#include "shared/heat_operand.hpp"
#include "shared/isotropic_forces.hpp"
#include "shared/pair_forces.hpp"
#include "shared/tension_forces.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

using core::LoadRow;
using physics::LoadSums;

/// Whether this sum is due, of a particle that is there.
template <class T>
MELTSIM_HD bool counts(const Frame<T>& w, const LoadRow& row, std::uint32_t tag) {
  return is_due(w, row.probe) && !is_removed(tag);
}

/// A solid particle of the row's body.
MELTSIM_HD bool belongs(const LoadRow& row, std::uint32_t tag) {
  return is_solid(tag) && body_of(tag) == row.body;
}

/// Place of x relative to the point that moments are about.
template <class T>
MELTSIM_HD Vec3<double> place_of(const Frame<T>& w, const LoadRow& row, Vec3<T> x) {
  if (row.about_center) return cast<double>(x);
  return cast<double>(spatial::separation(w.grid, x, cast<T>(row.about)));
}

/// The point of a face beside x.
template <class T>
MELTSIM_HD Vec3<T> on_face(const Frame<T>& w, Vec3<T> x, int face) {
  return x + physics::wall_normal<T>(face) * physics::wall_overlap(w.c.walls, T(0), x, face);
}

/// The force of the gaps between solid particle i and walls and other bodies, into which liquid seeps.
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> seeping_on(const Frame<T>& w, std::uint64_t i) {
  const std::uint32_t tag = w.f.tag[i];
  Vec3<T> force = core::seepage_on(w, i, tag, xyz(w.f.position[i]));
  if (w.f.gap_push == nullptr || (tag & tag_surface) == 0u) return force;
  const core::GapSide<T> side = core::gap_side(w, i);
  spatial::sweep_part<Periodic>(w, i, 0u, 1u,
                                [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
                                  force += core::gap_force(w, side, j, xj.w, x_ij, r2);
                                });
  return force;
}

/// The liquid's force on solid particle i: sph.reaction, what seeps into gaps, what hydrostatic fields take out, and surface
/// tension where a liquid has it.
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> liquid_force_on(const Frame<T>& w, std::uint64_t i) {
  Vec3<T> force = spatial::sum_part<Periodic>(w, core::LiquidOnSolid<T>{w}, i, 0u, 1u).force;
  force += seeping_on<Periodic>(w, i) + core::rest_force_on(w, i);
  if (w.f.surface_along != nullptr) force += core::tension_on_solid<Periodic>(w, i);
  if (w.f.isotropic_diagonal != nullptr)
    force += spatial::sum_part<Periodic>(w, core::IsotropicForce<T>{w}, i, 0u, 1u).force;
  return force;
}

/// The liquid's force on a body, also on one that is held.
template <class T, bool Periodic>
struct LiquidOnBodyBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD LoadSums operator()(std::uint64_t i) const {
    LoadSums s;
    const LoadRow& r = w.probes.loads[row];
    const std::uint32_t tag = w.f.tag[i];
    if (!counts(w, r, tag) || !belongs(r, tag)) return s;
    s.add(static_cast<double>(w.f.mass[i]), place_of(w, r, xyz(w.f.position[i])),
          cast<double>(liquid_force_on<Periodic>(w, i)));
    return s;
  }
};

/// What keeps a particle inside walls at the end of the sub-step [N]: spray arrives with no pressure before it, and a body that is
/// thrown faster than its contact can stop it within a spacing.
template <class T>
MELTSIM_HD Vec3<T> hold_force(const Frame<T>& w, std::uint64_t i, std::uint32_t tag) {
  if (is_solid(tag) && ((tag & tag_fixed) != 0u || core::is_driven(w, tag))) return {};
  const Vec3<T> shift = w.f.shift != nullptr ? w.f.shift[i] : Vec3<T>{};
  Vec3<T> x = xyz(w.f.position[i]);
  Vec3<T> v = core::kicked(w, i, tag, xyz(w.f.velocity[i]), core::acceleration_of(w, i));
  const Vec3<T> before = v;
  core::drift_inside(w, tag, shift, x, v);
  return (v - before) * (w.f.mass[i] / w.f.clock->dt);
}

/// The force on solid particle i of the bodies and walls that it touches: lsm.loads without gravity, and lsm.contact. Of one
/// that is held, the negatives of what those that touch it get.
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> contact_force_on(const Frame<T>& w, std::uint64_t i, std::uint32_t tag) {
  const Vec3<T> x = xyz(w.f.position[i]);
  const bool held = (tag & tag_fixed) != 0u;
  Vec3<T> force{};
  if (!held) {
    const Vec3<T> v = xyz(w.f.velocity[i]), slip = core::slip_of(w, i);
    for (int face = 0; face < 6; ++face)
      force += core::wall_contact(w, i, tag, x, v, slip, face).response.force;
    force += hold_force(w, i, tag);
  }
  if (w.f.piece == nullptr || (tag & tag_surface) == 0u) return force;
  const core::Toucher<T> own = core::toucher(w, i);
  spatial::sweep_part<Periodic>(
      w, i, 0u, 1u, [&](std::uint32_t j, const Vec4<T>&, const Vec3<T>& x_ij, T r2) {
        const std::uint32_t tag_j = w.f.tag[j];
        if (!is_solid(tag_j) || body_of(tag_j) == body_of(tag)) return;
        if (!held) {
          force += core::pair_contact(w, own, j, x_ij, r2).response.force;
        } else if ((tag_j & (tag_fixed | tag_surface)) == tag_surface) {
          force += -core::pair_contact(w, core::toucher(w, j), static_cast<std::uint32_t>(i), -x_ij, r2)
                        .response.force;
        }
      });
  return force;
}

template <class T, bool Periodic>
struct ContactOnBodyBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD LoadSums operator()(std::uint64_t i) const {
    LoadSums s;
    const LoadRow& r = w.probes.loads[row];
    const std::uint32_t tag = w.f.tag[i];
    if (!counts(w, r, tag) || !belongs(r, tag)) return s;
    s.add(static_cast<double>(w.f.mass[i]), place_of(w, r, xyz(w.f.position[i])),
          cast<double>(contact_force_on<Periodic>(w, i, tag)));
    return s;
  }
};

/// The liquid's force on a wall: the negatives of what the wall's images, its push at a floor, its traction and its hold give
/// liquid and bodies beside it, and what hydrostatic fields take out over its area.
template <class T, bool Periodic>
struct LiquidOnWallBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD LoadSums operator()(std::uint64_t i) const {
    LoadSums s;
    const LoadRow& r = w.probes.loads[row];
    const std::uint32_t tag = w.f.tag[i];
    const Vec3<T> x = xyz(w.f.position[i]);
    const T distance = -physics::wall_overlap(w.c.walls, T(0), x, r.face);
    if (!counts(w, r, tag) || !(distance < w.c.walls.support)) return s;
    const Vec3<T> n = physics::wall_normal<T>(r.face);
    const bool liquid = is_fluid(tag);
    const auto walls = physics::wall_view(w.c.walls, x);
    Vec3<T> force{};
    // If two opposite walls are within reach, the nearer one has the images.
    if (((walls.axes >> (r.face / 2)) & 1u) != 0u && dot(walls.from, n) > T(0)) {
      force += n * dot(n, images(i, tag, walls) + core::seepage_on(w, i, tag, x));
      if (liquid && w.f.surface_along != nullptr)
        force +=
            n *
            dot(n, spatial::sum_part<Periodic>(w, core::TensionOnLiquid<T, false, true>{w}, i, 0u, 1u).force);
      if (w.f.isotropic_diagonal != nullptr)
        force +=
            n * dot(n, spatial::sum_part<Periodic>(w, core::IsotropicForce<T, true>{w}, i, 0u, 1u).force);
      if (liquid)
        force +=
            n * dot(n, physics::floor_push(w.c.walls, w.c.kernel, walls, core::pull_at(w, i))) * w.f.mass[i];
    }
    force += n * (core::at_rest(w, on_face(w, x, r.face)).pressure * w.f.position[i].w *
                  physics::wall_area(w.c.wall_exchange, distance));
    if (liquid) force += n * maximum(dot(n, hold_force(w, i, tag)), T(0));
    if (liquid && w.c.no_slip != 0u)
      force += physics::wall_viscous_force(
          w.c.wall_exchange, core::viscosity_of(w, i, w.f.materials[material_of(tag)]), w.f.position[i].w,
          distance, w.c.wall_velocity[r.face] - xyz(w.f.velocity[i]));
    s.add(static_cast<double>(w.f.mass[i]), place_of(w, r, on_face(w, x, r.face)), cast<double>(-force));
    return s;
  }
  /// Force of the images in walls on a particle, along the walls' normals.
  MELTSIM_HD Vec3<T> images(std::uint64_t i, std::uint32_t tag, const physics::WallView<T>& walls) const {
    Vec3<T> force{};
    const Vec4<T> vi = w.f.velocity[i];
    const T volume = w.f.position[i].w, stiffness = w.f.materials[material_of(tag)].tait_stiffness;
    const bool liquid = is_fluid(tag);
    spatial::sweep_part<Periodic>(
        w, i, 0u, 1u, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
          const std::uint32_t tag_j = w.f.tag[j];
          const bool other_liquid = is_fluid(tag_j);
          if (!liquid && !other_liquid) return;
          // A solid answers with the stiffness of the liquid, and its own term is the negative of its share.
          const T term_j = w.f.velocity[j].w;
          T terms = vi.w + term_j;
          if (!other_liquid) terms = vi.w - stiffness * term_j;
          if (!liquid) terms = term_j - w.f.materials[material_of(tag_j)].tait_stiffness * vi.w;
          force += physics::image_pressure_force(w.c.kernel, walls, x_ij, r2, volume, xj.w, terms).normal;
        });
    return force;
  }
};

/// The force of the bodies that touch a wall, or are held inside it.
template <class T>
struct ContactOnWallBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD LoadSums operator()(std::uint64_t i) const {
    LoadSums s;
    const LoadRow& r = w.probes.loads[row];
    const std::uint32_t tag = w.f.tag[i];
    if (!counts(w, r, tag) || !is_solid(tag) || (tag & tag_fixed) != 0u) return s;
    const Vec3<T> x = xyz(w.f.position[i]);
    const auto c = core::wall_contact(w, i, tag, x, xyz(w.f.velocity[i]), core::slip_of(w, i), r.face);
    const Vec3<T> n = physics::wall_normal<T>(r.face);
    // The wall across holds the other way.
    Vec3<T> force = n * maximum(dot(n, hold_force(w, i, tag)), T(0));
    if (c.touches) force += c.response.force;
    s.add(static_cast<double>(w.f.mass[i]), place_of(w, r, on_face(w, x, r.face)), cast<double>(-force));
    return s;
  }
};

/// Heat that a body has gained in this sub-step [J]: its enthalpy now less that at the beginning, where
/// particles had another order.
template <class T>
struct HeatOfBodyBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD LoadSums operator()(std::uint64_t i) const {
    LoadSums s;
    const LoadRow& r = w.probes.loads[row];
    if (!is_due(w, r.probe) || w.f.enthalpy == nullptr) return s;
    if (belongs(r, w.f.tag[i])) s.amount[0] += w.f.enthalpy[i];
    if (belongs(r, w.before.tag[i])) s.amount[0] -= w.before.enthalpy[i];
    return s;
  }
};

/// Heat through a wall [W] at the temperatures of the end of the sub-step. A particle whose temperature a region
/// holds takes none from a wall.
template <class T>
struct HeatOfWallBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD LoadSums operator()(std::uint64_t i) const {
    LoadSums s;
    const LoadRow& r = w.probes.loads[row];
    const std::uint32_t tag = w.f.tag[i];
    if (!counts(w, r, tag) || ((w.f.clock->heated_walls >> r.face) & 1u) == 0u) return s;
    if (w.f.heat_boundary == nullptr || w.f.heat_boundary[i].held != 0u) return s;
    const Vec4<T> x = w.f.position[i];
    const T distance = -physics::wall_overlap(w.c.walls, T(0), xyz(x), r.face);
    if (!(distance < w.c.wall_exchange.support)) return s;
    const core::MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const auto own = core::operand_at(m, w.f.enthalpy[i], w.f.mass[i], T(1), core::exposed(tag));
    s.amount[0] = static_cast<double>(
        core::heat_through(
            w.f.clock->wall_heat[r.face], x.w * physics::wall_area(w.c.wall_exchange, distance),
            physics::wall_depth(w.c.wall_exchange, distance), m, own, T(1) / core::unmarked(own.resistivity))
            .rate);
    return s;
  }
};

/// Liquid through an opening: mass [kg/s] and volume [m^3/s].
template <class T>
struct FluxBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD LoadSums operator()(std::uint64_t i) const {
    LoadSums s;
    const LoadRow& r = w.probes.loads[row];
    const std::uint32_t tag = w.f.tag[i];
    if (!is_due(w, r.probe) || !is_fluid(tag)) return s;
    const Vec4<T> x = w.f.position[i];
    const physics::Opening<T> o{cast<T>(r.opening.normal),
                                cast<T>(r.opening.along),
                                cast<T>(r.opening.across),
                                static_cast<T>(r.opening.radius),
                                static_cast<T>(r.opening.half_along),
                                static_cast<T>(r.opening.half_across)};
    const T share =
        physics::opening_share(w.c.kernel, o, spatial::separation(w.grid, xyz(x), cast<T>(r.about)));
    const double rate = static_cast<double>(share * dot(xyz(w.f.velocity[i]), o.normal));
    s.amount[0] = rate * static_cast<double>(w.f.mass[i]);
    s.amount[1] = rate * static_cast<double>(x.w);
    return s;
  }
};

/// Writes a sum to the place of its probe's values.
template <class T>
struct LoadValuesBody {
  Frame<T> w;
  std::uint32_t row;
  MELTSIM_HD void operator()(const LoadSums& s) const {
    const LoadRow& r = w.probes.loads[row];
    if (!is_due(w, r.probe)) return;
    double* const to = values_of(w, r.probe);
    const auto put = [to](std::uint32_t at, Vec3<double> v) {
      if (at == core::none) return;
      to[at] = v.x;
      to[at + 1u] = v.y;
      to[at + 2u] = v.z;
    };
    switch (r.kind) {
      case core::LoadKind::heat_of_body:
        to[0] = s.amount[0] / static_cast<double>(w.f.clock->dt);
        return;
      case core::LoadKind::heat_of_wall:
        to[0] = s.amount[0] * r.heat_scale;
        return;
      case core::LoadKind::flux:
        if (r.force != core::none) to[r.force] = s.amount[0];
        if (r.moment != core::none) to[r.moment] = s.amount[1];
        return;
      default:
        put(r.force, s.force);
        put(r.moment, r.about_center ? s.moment_about_center() : s.moment);
    }
  }
};

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
