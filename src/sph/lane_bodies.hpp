// SPDX-License-Identifier: Apache-2.0
// The sweeps of the liquid for a CPU: what they add up is what DensityBody and ForcesBody add up, many
// neighbours at a time. Images in walls vanish beyond H like everything else, so none has to be asked for.
#pragma once

#include "spatial/lanes.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

template <class T, bool Periodic>
struct DensityLanes : DensityBody<T, spatial::search_kind<Periodic>> {
  using Base = DensityBody<T, spatial::search_kind<Periodic>>;
  using Base::w;
  spatial::LanePositions<T> p;
  DensityLanes(const Frame<T>& frame, const spatial::LanePositions<T>& positions)
      : Base{frame}, p(positions) {}

  void operator()(std::uint64_t i) const {
    Surroundings<T> s;
    if (w.f.group_of[i] != core::none) s = sum(i);
    Base::finish(i, s);
  }
  Surroundings<T> sum(std::uint64_t i) const {
    const auto kernel = w.c.kernel;
    spatial::LaneSum<T> phi;
    spatial::find_in_lanes<Periodic>(w, p, i, [&](std::size_t l, T volume, const Vec3<T>&, T r2) {
      phi.lane[l] += volume * physics::kernel_shape(kernel, std::sqrt(r2));
    });
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[i]));
    if (walls.axes != 0u) add_images(i, walls, phi);
    return {phi.total()};
  }
  void add_images(std::uint64_t i, const physics::WallView<T>& walls, spatial::LaneSum<T>& phi) const {
    const auto kernel = w.c.kernel;
    const auto grid = w.grid;
    const Vec3<T> xi = xyz(w.f.position[i]);
    spatial::Batches<Periodic, T> neighbours(w, i);
    while (const std::uint32_t n = neighbours.next()) {
      spatial::LaneVectors<T> x;
      x.load(w.f.position, neighbours.slots, n);
      spatial::cut(x.w, n);
      for (std::uint32_t mask = walls.axes; mask != 0u; mask = (mask - 1u) & walls.axes) {
        spatial::in_lanes(n, [&](std::size_t l, std::size_t k) {
          const Vec3<T> x_ij = spatial::separation<Periodic>(grid, xi, Vec3<T>{x.x[k], x.y[k], x.z[k]});
          phi.lane[l] +=
              x.w[k] * physics::kernel_shape(
                           kernel, std::sqrt(physics::image_square(walls, x_ij, dot(x_ij, x_ij), mask)));
        });
      }
    }
  }
};

/// Where a neighbour is another liquid, or a solid so near that liquid could slip through, ForcesBody does the work.
template <class T, Company company, bool Periodic>
struct ForcesLanes : ForcesBody<T, company, Periodic> {
  using Base = ForcesBody<T, company, Periodic>;
  using Base::w;
  explicit ForcesLanes(const Frame<T>& frame) : Base{frame} {}

  void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_fluid(tag)) return;
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    Vec3<T> force{};
    if (!add(i, tag, m, viscosity_of(w, i, m), force)) return Base::operator()(i);
    Base::finish(i, {force});
  }
  /// False where ForcesBody has to.
  bool add(std::uint64_t i, std::uint32_t tag, const MaterialRow<T>& m, T mu, Vec3<T>& sum) const {
    const auto kernel = w.c.kernel;
    const auto grid = w.grid;
    const T alpha = w.c.artificial_viscosity, sound_speed = w.c.sound_speed, density = m.density;
    const Vec4<T> xi = w.f.position[i], vi = w.f.velocity[i];
    const auto walls = physics::wall_view(w.c.walls, xyz(xi));
    spatial::LaneSum<T> fx, fy, fz;
    spatial::Batches<Periodic, T> neighbours(w, i);
    while (const std::uint32_t n = neighbours.next()) {
      if (company == Company::any && !alike(neighbours.slots, n, tag)) return false;
      spatial::LaneVectors<T> x, v;
      x.load(w.f.position, neighbours.slots, n);
      v.load(w.f.velocity, neighbours.slots, n);
      spatial::cut(x.w, n);
      if (company == Company::solids && !take_solids(xyz(xi), m.tait_stiffness, n, x, v.w)) return false;
      alignas(64) T mu_ij[spatial::batch + spatial::lanes];
      for (std::size_t k = 0; k < n + spatial::lanes; ++k) mu_ij[k] = mu;
      if (w.f.viscosity != nullptr)
        for (std::uint32_t k = 0; k < n; ++k)
          mu_ij[k] = physics::pair_viscosity(mu, w.f.viscosity[neighbours.slots[k]]);
      spatial::in_lanes(n, [&](std::size_t l, std::size_t k) {
        const Vec3<T> x_ij = spatial::separation<Periodic>(grid, xyz(xi), Vec3<T>{x.x[k], x.y[k], x.z[k]});
        const Vec3<T> v_ij = xyz(vi) - Vec3<T>{v.x[k], v.y[k], v.z[k]};
        const physics::LiquidPair<T> pair{xi.w, x.w[k], vi.w, v.w[k], mu_ij[k], density, x_ij, v_ij};
        const Vec3<T> f = physics::liquid_force(kernel, alpha, sound_speed, pair, dot(x_ij, x_ij));
        fx.lane[l] += f.x;
        fy.lane[l] += f.y;
        fz.lane[l] += f.z;
      });
      for (std::uint32_t mask = walls.axes; mask != 0u; mask = (mask - 1u) & walls.axes) {
        spatial::in_lanes(n, [&](std::size_t l, std::size_t k) {
          const Vec3<T> x_ij = spatial::separation<Periodic>(grid, xyz(xi), Vec3<T>{x.x[k], x.y[k], x.z[k]});
          const Vec3<T> x_m = physics::image_of(walls, x_ij, mask);
          const T factor = physics::kernel_gradient_factor(
              kernel, std::sqrt(physics::image_square(walls, x_ij, dot(x_ij, x_ij), mask)));
          const Vec3<T> f = physics::pressure_force(xi.w, x.w[k], vi.w, v.w[k], factor, x_m);
          fx.lane[l] += f.x;
          fy.lane[l] += f.y;
          fz.lane[l] += f.z;
        });
      }
    }
    sum = {fx.total(), fy.total(), fz.total()};
    return true;
  }
  /// Pressure terms of solids become those of the liquid that they act as. False where one may leak.
  bool take_solids(Vec3<T> xi, T stiffness, std::uint32_t n, const spatial::LaneVectors<T>& x,
                   T* term) const {
    bool some = false;
    for (std::uint32_t k = 0; k < n; ++k) some |= is_solid_term(term[k]);
    if (!some) return true;
    for (std::uint32_t k = 0; k < n; ++k) {
      if (!is_solid_term(term[k])) continue;
      const Vec3<T> d = spatial::separation<Periodic>(w.grid, xi, Vec3<T>{x.x[k], x.y[k], x.z[k]});
      if (dot(d, d) < w.c.leak_distance2) return false;
      term[k] *= -stiffness;
    }
    return true;
  }
  bool alike(const std::uint32_t* slots, std::uint32_t n, std::uint32_t tag) const {
    std::uint32_t other = 0;
    for (std::uint32_t k = 0; k < n; ++k) other |= w.f.tag[slots[k]] ^ tag;
    return (other & (tag_material_mask | tag_solid)) == 0u;
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
