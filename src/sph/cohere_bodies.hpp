// SPDX-License-Identifier: Apache-2.0
// Kernels of surface tension: one gather for the stress of a surface, one for its forces on liquid, one for those on bodies;
// formulas in meltsim/physics/surface_tension.hpp.
#pragma once

#include "shared/tension_forces.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

template <class T>
struct SurfaceSum {
  physics::SurfaceSums<T> of;
  MELTSIM_HD void add(const SurfaceSum& o) {
    of.all += o.of.all;
    of.wall += o.of.wall;
    of.normal += o.of.normal;
    of.cover += o.of.cover;
    of.wetting += o.of.wetting;
  }
  struct Lanes {
    spatial::LaneVectorSum<T> all, wall, normal;
    spatial::LaneSum<T> cover, wetting;
    SurfaceSum at(std::size_t l) const {
      return {{all.at(l), wall.at(l), normal.at(l), cover.at(l), wetting.at(l)}};
    }
    void put(std::size_t l, const SurfaceSum& s) {
      all.put(l, s.of.all);
      wall.put(l, s.of.wall);
      normal.put(l, s.of.normal);
      cover.put(l, s.of.cover);
      wetting.put(l, s.of.wetting);
    }
    SurfaceSum total() const {
      return {{all.total(), wall.total(), normal.total(), cover.total(), wetting.total()}};
    }
  };
};

/// Surface stress of every particle of liquid with tension, 0 of all others.
template <class T, bool alone, bool Periodic>
struct SurfaceStressBody {
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  using Sum = SurfaceSum<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp).
  struct Own {
    std::uint32_t material;
    T tension;
    physics::WallView<T> walls;
  };
  struct Stored {
    T share;   ///< of another liquid
    T cosine;  ///< of a solid; of a liquid's images in walls
    bool solid;
  };
  MELTSIM_HD T tension_of(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    return is_fluid(tag) ? w.f.materials[material_of(tag)].tension : T(0);
  }
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return tension_of(i) > T(0); }
  MELTSIM_HD Own own(std::uint64_t i) const {
    return {material_of(w.f.tag[i]), tension_of(i), physics::wall_view(w.c.walls, xyz(w.f.position[i]))};
  }
  MELTSIM_HD Stored stored(const Own&, std::uint32_t) const { return {T(1), w.c.wall_wetting, false}; }
  /// Where neighbours differ.
  MELTSIM_HD void settle(const Own& own, Stored& s, std::uint64_t, std::uint32_t j) const {
    if (alone) return;
    const std::uint32_t tag = w.f.tag[j];
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    s.solid = is_solid(tag);
    if (s.solid) s.cosine = m.wetting;
    else if (material_of(tag) != own.material) s.share = physics::liquid_share(own.tension, m.tension);
  }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own&, const Stored& j, const spatial::Pair<T>& pair, Along) const {
    sum.of.add(pair.volume, j.share, physics::kernel_gradient_shape(w.c.kernel, std::sqrt(pair.r2)),
               pair.x_ij);
  }
  MELTSIM_HD bool may_be_rare(const Stored& j) const { return j.solid; }
  MELTSIM_HD bool rare(const Own&, const Stored& j, const spatial::Pair<T>&) const { return j.solid; }
  MELTSIM_HD void add_rare(Sum& sum, const Own&, const Stored& j, std::uint64_t, std::uint32_t,
                           const spatial::Pair<T>& pair) const {
    sum.of.add_wall(pair.volume, j.cosine, physics::kernel_gradient_shape(w.c.kernel, std::sqrt(pair.r2)),
                    pair.x_ij, pair.x_ij);
  }
  static constexpr bool each_image = true;
  MELTSIM_HD void add_image(Sum& sum, const Own&, const Stored& j, const spatial::Pair<T>& image,
                            std::uint32_t mask) const {
    const T shape = physics::kernel_gradient_shape(w.c.kernel, std::sqrt(image.r2));
    sum.of.add(image.volume, T(1), shape, image.x_ij);
    sum.of.add_wall(image.volume, j.cosine, shape, image.x_ij, spatial::across(image.x_ij, mask));
  }
  struct Lanes {
    T cosine;
    std::conditional_t<alone, spatial::NoImages, spatial::LaneVectors<T>> asked;
    Stored at(std::size_t k) const {
      if constexpr (alone) return {T(1), cosine, false};
      else return {asked.x[k], asked.y[k], asked.z[k] != T(0)};
    }
    void load(const SurfaceStressBody& body, const Own& own, std::uint64_t i, const std::uint32_t* slots,
              std::uint32_t n, const T*) {
      cosine = body.w.c.wall_wetting;
      if constexpr (!alone)
        for (std::uint32_t k = 0; k < spatial::whole_lanes(n); ++k) {
          Stored s{T(1), cosine, false};
          body.settle(own, s, i, slots[k]);
          asked.put(k, {s.share, s.cosine, s.solid ? T(1) : T(0), T(0)});
        }
    }
  };
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    physics::SurfaceStress<T> stress;
    Vec3<T> wall{};
    T free{}, skin{};
    const T tension = tension_of(i);
    if (tension > T(0)) {
      stress = physics::surface_stress(w.c.kernel, tension, w.f.density[i], s.of);
      wall = physics::wall_direction(w.c.kernel, s.of);
      free = physics::free_share(w.c.kernel, s.of);
      skin = physics::skin_share(w.c.kernel, s.of);
    }
    w.f.surface_along[i] = with_w(stress.along, free);
    w.f.surface_shear[i] = with_w(stress.shear, skin);
    w.f.surface_wall[i] = wall;
  }
};

/// Forces of the surface stress, of cohesion and of the skin on liquid.
template <class T, bool alone, bool Periodic>
struct CohereBody : core::TensionOnLiquid<T, alone> {
  using Base = core::TensionOnLiquid<T, alone>;
  using Base::w;
  using Sum = typename Base::Sum;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    if (Base::takes_part(i)) w.f.acceleration[i] += s.force * (T(1) / w.f.mass[i]);
  }
};

/// The opposite forces on bodies that can move.
template <class T, bool Periodic>
struct AdhereBody : core::TensionOnSolid<T> {
  using Base = core::TensionOnSolid<T>;
  using Base::w;
  using Sum = typename Base::Sum;
  MELTSIM_HD bool wanted(std::uint64_t k) const { return WettedBody<T>{w}.wanted(k); }
  MELTSIM_HD Sum part(std::uint64_t k, std::uint32_t share, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, static_cast<const Base&>(*this), k, share, parts);
  }
  MELTSIM_HD void finish(std::uint64_t k, const Sum& s) const {
    w.f.acceleration[k] += s.force * (T(1) / w.f.mass[k]);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
