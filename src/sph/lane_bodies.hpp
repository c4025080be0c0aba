// SPDX-License-Identifier: Apache-2.0
// The sweeps of the liquid for a CPU: what they add up is what ForcesBody and ReactionBody add up, many
// neighbours at a time. Images in walls vanish beyond H like everything else, so none has to be asked for.
#pragma once

#include <type_traits>

#include "spatial/lanes.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

/// A force per lane.
template <class T>
struct LaneForce {
  spatial::LaneSum<T> x, y, z;
  void add(std::size_t l, const Vec3<T>& f) {
    x.lane[l] += f.x;
    y.lane[l] += f.y;
    z.lane[l] += f.z;
  }
  Vec3<T> total() const { return {x.total(), y.total(), z.total()}; }
};

/// Pressure of the images of n neighbours on a particle: xi, x positions and volumes, term_i, term pressure terms.
template <bool Periodic, class T>
inline void add_image_forces(const Frame<T>& w, const physics::WallView<T>& walls, const Vec4<T>& xi,
                             T term_i, std::uint32_t n, const spatial::LaneVectors<T>& x, const T* term,
                             LaneForce<T>& force) {
  const auto kernel = w.c.kernel;
  const auto grid = w.grid;
  spatial::for_each_mask(walls.axes, [&](auto mask) {
    spatial::in_lanes(n, [&](std::size_t l, std::size_t k) {
      const Vec3<T> x_ij = spatial::separation<Periodic>(grid, xyz(xi), Vec3<T>{x.x[k], x.y[k], x.z[k]});
      const T factor = physics::kernel_gradient_factor(
          kernel, std::sqrt(physics::image_square(walls, x_ij, dot(x_ij, x_ij), mask())));
      force.add(l, physics::pressure_force(xi.w, x.w[k], term_i, term[k], factor,
                                           physics::image_of(walls, x_ij, mask())));
    });
  });
}

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
    LaneForce<T> force;
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
        force.add(l, f);
      });
      add_image_forces<Periodic>(w, walls, xi, vi.w, n, x, v.w, force);
    }
    sum = force.total();
    return true;
  }
  /// Pressure terms of solids become those of the liquid that they act as. False where one may leak.
  bool take_solids(Vec3<T> xi, T stiffness, std::uint32_t n, const spatial::LaneVectors<T>& x,
                   T* term) const {
    if (!spatial::any_in_lanes(n, [&](std::size_t k) { return is_solid_term(term[k]); })) return true;
    const auto grid = w.grid;
    const T leak2 = w.c.leak_distance2;
    const bool leak = spatial::any_in_lanes(n, [&](std::size_t k) {
      const Vec3<T> d = spatial::separation<Periodic>(grid, xi, Vec3<T>{x.x[k], x.y[k], x.z[k]});
      return is_solid_term(term[k]) & (dot(d, d) < leak2);
    });
    if (leak) return false;
    spatial::in_lanes(n, [&](std::size_t, std::size_t k) {
      const T of_solid = term[k] * -stiffness;
      term[k] = is_solid_term(term[k]) ? of_solid : term[k];
    });
    return true;
  }
  bool alike(const std::uint32_t* slots, std::uint32_t n, std::uint32_t tag) const {
    std::uint32_t other = 0;
    for (std::uint32_t k = 0; k < n; ++k) other |= w.f.tag[slots[k]] ^ tag;
    return (other & (tag_material_mask | tag_solid)) == 0u;
  }
};

/// ReactionBody beside one liquid. Where that is so near that it could slip through, ReactionBody does the work.
template <class T, bool Periodic>
struct ReactionLanes : ReactionBody<T, Periodic> {
  using Base = ReactionBody<T, Periodic>;
  using Base::w;
  explicit ReactionLanes(const Frame<T>& frame) : Base{frame} {}

  void operator()(std::uint64_t k) const {
    if (!Base::wanted(k)) return;
    Vec3<T> force{};
    Base::finish(k, add(k, force) ? ForceSum<T>{force} : Base::part(k, 0, 1));
  }
  /// False where ReactionBody has to.
  bool add(std::uint64_t k, Vec3<T>& sum) const {
    const auto kernel = w.c.kernel;
    const auto grid = w.grid;
    const T alpha = w.c.artificial_viscosity, sound_speed = w.c.sound_speed, leak2 = w.c.leak_distance2;
    const Vec4<T> xk = w.f.position[k], vk = w.f.velocity[k];
    const T tau = -vk.w;
    const auto walls = physics::wall_view(w.c.walls, xyz(xk));
    LaneForce<T> force;
    spatial::Batches<Periodic, T> neighbours(w, k);
    while (const std::uint32_t n = neighbours.next()) {
      const MaterialRow<T>* m = liquid_of(neighbours.slots, n);
      if (m == nullptr) continue;
      const T stiffness = m->tait_stiffness, mu = m->viscosity, density = m->density;
      spatial::LaneVectors<T> x, v;
      x.load(w.f.position, neighbours.slots, n);
      v.load(w.f.velocity, neighbours.slots, n);
      spatial::in_lanes(n,
                        [&](std::size_t, std::size_t j) { x.w[j] = is_solid_term(v.w[j]) ? T(0) : x.w[j]; });
      spatial::cut(x.w, n);
      const auto from = [&](std::size_t j) {
        return spatial::separation<Periodic>(grid, xyz(xk), Vec3<T>{x.x[j], x.y[j], x.z[j]});
      };
      const bool leak = spatial::any_in_lanes(n, [&](std::size_t j) {
        const Vec3<T> d = from(j);
        return (x.w[j] > T(0)) & (dot(d, d) < leak2);
      });
      if (leak) return false;
      spatial::in_lanes(n, [&](std::size_t l, std::size_t j) {
        const Vec3<T> x_ki = from(j), v_ik = Vec3<T>{v.x[j], v.y[j], v.z[j]} - xyz(vk);
        const physics::CouplingPair<T> p{x.w[j], xk.w, v.w[j] + stiffness * tau, mu, density, -x_ki, v_ik};
        const Vec3<T> f = physics::coupling_force(kernel, alpha, sound_speed, p, dot(x_ki, x_ki));
        force.add(l, -f);
      });
      add_image_forces<Periodic>(w, walls, xk, stiffness * tau, n, x, v.w, force);
    }
    sum = force.total();
    return true;
  }
  /// The one liquid; null where there is none among n neighbours.
  const MaterialRow<T>* liquid_of(const std::uint32_t* slots, std::uint32_t n) const {
    for (std::uint32_t j = 0; j < n; ++j)
      if (is_fluid(w.f.tag[slots[j]])) return w.f.materials + material_of(w.f.tag[slots[j]]);
    return nullptr;
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
