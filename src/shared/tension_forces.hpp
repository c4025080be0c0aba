// SPDX-License-Identifier: Apache-2.0
// Forces of surface tension on one particle, for the step, for watched bodies and for probes of kind `force`; formulas in
// meltsim/physics/surface_tension.hpp.
#pragma once

#include "meltsim/physics/surface_tension.hpp"
#include "shared/pair_forces.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Force of a solid particle or of an image on liquid i at x_i - x = x_ik [N]: of surface stress and adhesion.
template <class T>
MELTSIM_HD Vec3<T> tension_of_solid(const physics::SphKernel<T>& kernel,
                                    const physics::SurfaceStress<T>& stress, Vec3<T> wall, T strength,
                                    T volumes, Vec3<T> x_ik, T r2) {
  const T r = std::sqrt(r2);
  return physics::mirrored_sum(stress, wall, x_ik) * (-volumes * physics::kernel_gradient_factor(kernel, r)) +
         x_ik * (volumes * strength * physics::cohesion_shape(kernel, r));
}

/// The force on a liquid particle. alone: it meets no solid and no other liquid. of_walls: the part that images in walls exert.
template <class T, bool alone, bool of_walls = false>
struct TensionOnLiquid {
  Frame<T> w;
  using Sum = ForceSum<T>;
  struct Own {
    physics::SurfaceStress<T> stress;
    Vec3<T> wall, v;
    T volume, free, skin, cohesion, viscosity;
    std::uint32_t material;
    physics::WallView<T> walls;
  };
  struct Stored {
    Vec4<T> along, shear, v;
    T cohesion, viscosity;  ///< of liquid; 0 of solids
    T adhesion;             ///< of the pair, if it is a solid; of its images in walls
    bool solid;
  };
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return is_fluid(w.f.tag[i]); }
  MELTSIM_HD Own own(std::uint64_t i) const {
    const std::uint32_t material = material_of(w.f.tag[i]);
    const MaterialRow<T>& m = w.f.materials[material];
    const Vec4<T> along = w.f.surface_along[i], shear = w.f.surface_shear[i], x = w.f.position[i];
    return {{xyz(along), xyz(shear)},
            w.f.surface_wall[i],
            xyz(w.f.velocity[i]),
            x.w,
            along.w,
            shear.w,
            m.cohesion,
            m.skin_viscosity,
            material,
            physics::wall_view(w.c.walls, xyz(x))};
  }
  MELTSIM_HD Stored stored(const Own& own, std::uint32_t j) const {
    return {w.f.surface_along[j],
            w.f.surface_shear[j],
            w.f.velocity[j],
            own.cohesion,
            own.viscosity,
            T(2) * physics::adhesion_of(own.cohesion, w.c.wall_wetting),
            false};
  }
  /// Where neighbours differ.
  MELTSIM_HD void settle(const Own& own, Stored& s, std::uint64_t, std::uint32_t j) const {
    if (alone) return;
    const std::uint32_t tag = w.f.tag[j];
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    s.solid = is_solid(tag);
    if (s.solid) s.adhesion = physics::adhesion_of(own.cohesion, m.wetting);
    s.cohesion = s.solid ? T(0) : m.cohesion;
    s.viscosity = s.solid ? T(0) : m.skin_viscosity;
  }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& j, const spatial::Pair<T>& pair, Along) const {
    if (of_walls) return;
    const T r = std::sqrt(pair.r2), volumes = own.volume * pair.volume, stressed = j.solid ? T(0) : volumes;
    const physics::SurfaceStress<T> both = own.stress + physics::SurfaceStress<T>{xyz(j.along), xyz(j.shear)};
    sum.force += both * pair.x_ij * (-stressed * physics::kernel_gradient_factor(w.c.kernel, r));
    const T cohesion = physics::cohesion_of(own.cohesion, j.cohesion, own.free, j.along.w);
    sum.force += pair.x_ij * (physics::cohesion_factor(own.volume, pair.volume, cohesion) *
                              physics::cohesion_shape(w.c.kernel, r));
    const T viscosity = physics::skin_viscosity_of(own.viscosity, j.viscosity, own.skin, j.shear.w);
    sum.force += physics::skin_force(w.c.kernel, volumes, viscosity, pair.x_ij, own.v - xyz(j.v), pair.r2);
  }
  MELTSIM_HD bool may_be_rare(const Stored& j) const { return j.solid; }
  MELTSIM_HD bool rare(const Own&, const Stored& j, const spatial::Pair<T>&) const {
    return !of_walls && j.solid;
  }
  MELTSIM_HD void add_rare(Sum& sum, const Own& own, const Stored& j, std::uint64_t, std::uint32_t,
                           const spatial::Pair<T>& pair) const {
    sum.force += tension_of_solid(w.c.kernel, own.stress, own.wall, j.adhesion, own.volume * pair.volume,
                                  pair.x_ij, pair.r2);
  }
  static constexpr bool each_image = true;
  MELTSIM_HD void add_image(Sum& sum, const Own& own, const Stored& j, const spatial::Pair<T>& image,
                            std::uint32_t) const {
    add_rare(sum, own, j, 0u, 0u, image);
  }
  struct Lanes {
    spatial::LaneVectors<T> along, shear, v;
    T cohesion, viscosity, adhesion;
    std::conditional_t<alone, spatial::NoImages, spatial::LaneVectors<T>> asked;
    Stored at(std::size_t k) const {
      if constexpr (alone) return {along.at(k), shear.at(k), v.at(k), cohesion, viscosity, adhesion, false};
      else return {along.at(k), shear.at(k), v.at(k), asked.x[k], asked.y[k], asked.z[k], asked.w[k] != T(0)};
    }
    template <class Body>
    void load(const Body& body, const Own& own, std::uint64_t i, const std::uint32_t* slots, std::uint32_t n,
              const T*) {
      along.load(body.w.f.surface_along, slots, n);
      shear.load(body.w.f.surface_shear, slots, n);
      v.load(body.w.f.velocity, slots, n);
      cohesion = own.cohesion;
      viscosity = own.viscosity;
      adhesion = T(2) * physics::adhesion_of(own.cohesion, body.w.c.wall_wetting);
      if constexpr (!alone)
        for (std::uint32_t k = 0; k < spatial::whole_lanes(n); ++k) {
          Stored s{{}, {}, {}, cohesion, viscosity, adhesion, false};
          body.settle(own, s, i, slots[k]);
          asked.put(k, {s.cohesion, s.viscosity, s.adhesion, s.solid ? T(1) : T(0)});
        }
    }
  };
};

/// The force on a particle of a body: the negatives of what it gives liquid.
template <class T>
struct TensionOnSolid {
  Frame<T> w;
  using Sum = ForceSum<T>;
  struct Own {
    T volume, cosine;
  };
  /// Of liquid; 0 of what has no tension.
  struct Stored {
    Vec4<T> along, shear;
    Vec3<T> wall;
    T adhesion;
  };
  MELTSIM_HD bool takes_part(std::uint64_t) const { return true; }
  MELTSIM_HD Own own(std::uint64_t k) const {
    return {w.f.position[k].w, w.f.materials[material_of(w.f.tag[k])].wetting};
  }
  MELTSIM_HD bool skips(std::uint32_t i) const { return !is_fluid(w.f.tag[i]); }
  MELTSIM_HD T adhesion(const Own& own, std::uint32_t i) const {
    return physics::adhesion_of(w.f.materials[material_of(w.f.tag[i])].cohesion, own.cosine);
  }
  MELTSIM_HD Stored stored(const Own& own, std::uint32_t i) const {
    return {w.f.surface_along[i], w.f.surface_shear[i], w.f.surface_wall[i], adhesion(own, i)};
  }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& i, const spatial::Pair<T>& pair, Along) const {
    sum.force += -tension_of_solid(w.c.kernel, {xyz(i.along), xyz(i.shear)}, i.wall, i.adhesion,
                                   pair.volume * own.volume, -pair.x_ij, pair.r2);
  }
  struct Lanes {
    spatial::LaneVectors<T> along, shear, wall;  ///< beside the wall: adhesion
    Stored at(std::size_t k) const {
      return {along.at(k), shear.at(k), {wall.x[k], wall.y[k], wall.z[k]}, wall.w[k]};
    }
    void load(const TensionOnSolid& body, const Own& own, std::uint64_t, const std::uint32_t* slots,
              std::uint32_t n, const T*) {
      along.load(body.w.f.surface_along, slots, n);
      shear.load(body.w.f.surface_shear, slots, n);
      for (std::uint32_t k = 0; k < spatial::whole_lanes(n); ++k)
        wall.put(k, with_w(body.w.f.surface_wall[slots[k]],
                           body.skips(slots[k]) ? T(0) : body.adhesion(own, slots[k])));
    }
  };
};

/// Force of surface tension on a particle of a body [N].
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> tension_on_solid(const Frame<T>& w, std::uint64_t k) {
  return spatial::sum_part<Periodic>(w, TensionOnSolid<T>{w}, k, 0u, 1u).force;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
