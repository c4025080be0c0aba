// SPDX-License-Identifier: Apache-2.0
// Forces of isotropic pressure on one particle, for the step, for watched bodies and for probes of kind `force`; formulas in
// meltsim/physics/isotropic_pressure.hpp.
#pragma once

#include "meltsim/physics/isotropic_pressure.hpp"
#include "shared/pair_forces.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class T>
MELTSIM_HD Sym3<T> pressure_stress_of(const Frame<T>& w, std::uint64_t i) {
  return {xyz(w.f.isotropic_diagonal[i]), xyz(w.f.isotropic_mixed[i])};
}

/// The force on a particle of liquid or of a body. of_walls: the part of it that walls take, which is what their images give across the
/// planes that mirror them. Pairs of particles exchange the rest.
template <class T, bool of_walls = false>
struct IsotropicForce {
  Frame<T> w;
  using Sum = ForceSum<T>;
  struct Own {
    Sym3<T> stress;
    T volume;
    physics::WallView<T> walls;
  };
  using Stored = Sym3<T>;
  MELTSIM_HD bool takes_part(std::uint64_t) const { return true; }
  MELTSIM_HD Own own(std::uint64_t i) const {
    const Vec4<T> x = w.f.position[i];
    return {pressure_stress_of(w, i), x.w, physics::wall_view(w.c.walls, xyz(x))};
  }
  MELTSIM_HD Stored stored(const Own&, std::uint32_t j) const { return pressure_stress_of(w, j); }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& pair,
                      Along) const {
    if (of_walls) return;
    sum.force +=
        physics::isotropic_force(physics::sum_of(own.stress, other), own.volume * pair.volume,
                                 physics::kernel_gradient_factor(w.c.kernel, std::sqrt(pair.r2)), pair.x_ij);
  }
  static constexpr bool each_image = true;
  MELTSIM_HD void add_image(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& image,
                            std::uint32_t mask) const {
    const Sym3<T> stress = physics::sum_of(own.stress, physics::mirrored_in(other, mask));
    const Vec3<T> force = physics::isotropic_force(
        stress, own.volume * image.volume, physics::kernel_gradient_factor(w.c.kernel, std::sqrt(image.r2)),
        image.x_ij);
    sum.force += of_walls ? spatial::across(force, mask) : force;
  }
  struct Lanes {
    spatial::LaneVectors<T> diagonal, mixed;
    Stored at(std::size_t k) const {
      return {{diagonal.x[k], diagonal.y[k], diagonal.z[k]}, {mixed.x[k], mixed.y[k], mixed.z[k]}};
    }
    template <class Body>
    void load(const Body& body, const Own&, std::uint64_t, const std::uint32_t* slots, std::uint32_t n,
              const T*) {
      diagonal.load(body.w.f.isotropic_diagonal, slots, n);
      mixed.load(body.w.f.isotropic_mixed, slots, n);
    }
  };
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
