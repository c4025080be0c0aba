// SPDX-License-Identifier: Apache-2.0
// Kernels of isotropic pressure: one sum for how the surroundings of liquid are arranged, one for its forces; formulas in
// meltsim/physics/isotropic_pressure.hpp.
#pragma once

#include "shared/isotropic_forces.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

/// A of a particle, divided by the scale of the kernel's gradient.
template <class T>
struct ArrangementSum {
  Sym3<T> moment;
  MELTSIM_HD void add(const ArrangementSum& o) { moment = physics::sum_of(moment, o.moment); }
  struct Lanes {
    spatial::LaneVectorSum<T> diagonal, mixed;
    ArrangementSum at(std::size_t l) const { return {{diagonal.at(l), mixed.at(l)}}; }
    void put(std::size_t l, const ArrangementSum& s) {
      diagonal.put(l, s.moment.diagonal);
      mixed.put(l, s.moment.mixed);
    }
    ArrangementSum total() const { return {{diagonal.total(), mixed.total()}}; }
  };
};

/// S of every liquid particle, 0 of all others.
template <class T, bool Periodic>
struct ArrangementBody {
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  using Sum = ArrangementSum<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp).
  struct Own {
    physics::WallView<T> walls;
  };
  struct Stored {};
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return is_fluid(w.f.tag[i]); }
  MELTSIM_HD Own own(std::uint64_t i) const { return {physics::wall_view(w.c.walls, xyz(w.f.position[i]))}; }
  MELTSIM_HD Stored stored(const Own&, std::uint32_t) const { return {}; }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own&, const Stored&, const spatial::Pair<T>& pair, Along) const {
    add_square(sum.moment, pair.volume * physics::kernel_gradient_shape(w.c.kernel, std::sqrt(pair.r2)),
               pair.x_ij);
  }
  MELTSIM_HD bool may_be_rare(const Stored&) const { return true; }
  /// With images in walls.
  MELTSIM_HD bool rare(const Own& own, const Stored&, const spatial::Pair<T>&) const {
    return own.walls.axes != 0u;
  }
  MELTSIM_HD void add_rare(Sum& sum, const Own& own, const Stored&, std::uint64_t, std::uint32_t,
                           const spatial::Pair<T>& pair) const {
    core::for_each_masked_image(
        own.walls, w.c.kernel.support2, pair, [&](std::uint32_t, Vec3<T> x_m, T square) {
          add_square(sum.moment, pair.volume * physics::kernel_gradient_shape(w.c.kernel, std::sqrt(square)),
                     x_m);
        });
  }
  struct Lanes {
    Stored at(std::size_t) const { return {}; }
    void load(const ArrangementBody&, const Own&, std::uint64_t, const std::uint32_t*, std::uint32_t,
              const T*) {}
  };
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    Sym3<T> stress;
    if (is_fluid(w.f.tag[i])) stress = physics::isotropic_stress(s.moment, w.f.velocity[i].w);
    w.f.isotropic_diagonal[i] = with_w(stress.diagonal, T(0));
    w.f.isotropic_mixed[i] = with_w(stress.mixed, T(0));
  }
};

/// Its forces on liquid and on bodies that can move.
template <class T, bool Periodic>
struct IsotropyBody : core::IsotropicForce<T> {
  using Base = core::IsotropicForce<T>;
  using Base::w;
  using Sum = typename Base::Sum;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }
  MELTSIM_HD bool takes_part(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    return is_fluid(tag) || (is_solid(tag) && (tag & tag_fixed) == 0u);
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    if (takes_part(i)) w.f.acceleration[i] += s.force * (T(1) / w.f.mass[i]);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
