// SPDX-License-Identifier: Apache-2.0
// Kernel of particle shifting: one gather; formulas in meltsim/physics/shifting.hpp.
#pragma once

#include "meltsim/physics/shifting.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

/// G of a particle.
template <class T>
struct ShiftSum {
  Vec3<T> gradient{};
  MELTSIM_HD void add(const ShiftSum& o) { gradient += o.gradient; }
  struct Lanes {
    spatial::LaneVectorSum<T> gradient;
    ShiftSum at(std::size_t l) const { return {gradient.at(l)}; }
    void put(std::size_t l, const ShiftSum& s) { gradient.put(l, s.gradient); }
    ShiftSum total() const { return {gradient.total()}; }
  };
};

/// Displacement of every liquid particle beside the flow; step.integrate applies it.
template <class T, bool Periodic>
struct ShiftBody {
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  using Sum = ShiftSum<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp).
  struct Own {
    T inv_w_dx;
    physics::WallView<T> walls;
  };
  struct Stored {};
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return is_fluid(w.f.tag[i]); }
  MELTSIM_HD Own own(std::uint64_t i) const {
    return {T(1) / physics::kernel_value(w.c.kernel, w.c.spacing),
            physics::wall_view(w.c.walls, xyz(w.f.position[i]))};
  }
  MELTSIM_HD Stored stored(const Own&, std::uint32_t) const { return {}; }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& j, const spatial::Pair<T>& pair, Along) const {
    add_image(sum, own, j, pair, 0u);
  }
  static constexpr bool each_image = true;
  MELTSIM_HD void add_image(Sum& sum, const Own& own, const Stored&, const spatial::Pair<T>& image,
                            std::uint32_t) const {
    sum.gradient +=
        physics::shift_term(w.c.kernel, own.inv_w_dx, image.volume, std::sqrt(image.r2), image.x_ij);
  }
  struct Lanes {
    Stored at(std::size_t) const { return {}; }
    void load(const ShiftBody&, const Own&, std::uint64_t, const std::uint32_t*, std::uint32_t, const T*) {}
  };
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    w.f.shift[i] = takes_part(i) ? physics::shift_displacement(w.c.kernel, w.c.spacing, w.c.sound_speed,
                                                               w.f.clock->dt, w.f.density[i], s.gradient)
                                 : Vec3<T>{};
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
