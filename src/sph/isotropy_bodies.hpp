// SPDX-License-Identifier: Apache-2.0
// Isotropic pressure: the sum for how the surroundings of liquid are arranged; its forces are added in the sweeps of sph.forces and
// sph.reaction. Formulas in meltsim/physics/isotropic_pressure.hpp.
#pragma once

#include "shared/isotropic_forces.hpp"
#include "spatial/together.hpp"
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
  static constexpr bool each_image = true;
  MELTSIM_HD void add_image(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& image,
                            std::uint32_t) const {
    add(sum, own, other, image, spatial::NoImages{});
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

/// Body, whose sum is a force, with the force of isotropic pressure in the same sweep.
template <class T, class Body, bool Periodic>
using WithIsotropy = spatial::Together<Body, core::IsotropicForce<T>, Periodic>;

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
