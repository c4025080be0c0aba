// SPDX-License-Identifier: Apache-2.0
// Kernel of the strain rate: the viscosity of liquids that yield, thin or thicken as they are sheared. One sum over
// neighbours; formulas in meltsim/physics/strain_rate.hpp and flow_curve.hpp.
#pragma once

#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "meltsim/physics/strain_rate.hpp"
#include "shared/pair_forces.hpp"
#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

using core::Frame;

/// GradientSum of a particle's neighbours.
template <class T>
struct StrainSum {
  physics::GradientSum<T> fit;
  MELTSIM_HD void add(const StrainSum& o) {
    fit.x += o.fit.x;
    fit.y += o.fit.y;
    fit.z += o.fit.z;
    fit.moment.diagonal += o.fit.moment.diagonal;
    fit.moment.mixed += o.fit.moment.mixed;
    fit.skew += o.fit.skew;
  }
  struct Lanes {
    spatial::LaneVectorSum<T> x, y, z, diagonal, mixed, skew;
    StrainSum at(std::size_t l) const {
      return {{x.at(l), y.at(l), z.at(l), {diagonal.at(l), mixed.at(l)}, skew.at(l)}};
    }
    void put(std::size_t l, const StrainSum& s) {
      x.put(l, s.fit.x);
      y.put(l, s.fit.y);
      z.put(l, s.fit.z);
      diagonal.put(l, s.fit.moment.diagonal);
      mixed.put(l, s.fit.moment.mixed);
      skew.put(l, s.fit.skew);
    }
    StrainSum total() const {
      return {{x.total(), y.total(), z.total(), {diagonal.total(), mixed.total()}, skew.total()}};
    }
  };
};

/// Turns the consistency of every liquid particle that has a flow curve into its viscosity at the shear rate there.
template <class T, bool Periodic>
struct StrainBody {
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  using Sum = StrainSum<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp).
  using Own = Vec4<T>;
  using Stored = Vec4<T>;  ///< velocity, and the factor on its difference
  MELTSIM_HD bool takes_part(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_fluid(tag)) return false;
    const auto* tables = w.f.materials[material_of(tag)].tables;
    return tables != nullptr && tables->flow.index != T(0);
  }
  MELTSIM_HD Own own(std::uint64_t i) const { return w.f.velocity[i]; }
  MELTSIM_HD T factor(std::uint32_t j) const {
    return is_solid(w.f.tag[j]) ? T(physics::no_slip_factor) : T(1);
  }
  MELTSIM_HD Stored stored(const Own&, std::uint32_t j) const {
    return with_w(xyz(w.f.velocity[j]), factor(j));
  }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& pair,
                      Along) const {
    physics::add_neighbour(sum.fit,
                           pair.volume * physics::kernel_laplacian(w.c.kernel, std::sqrt(pair.r2), pair.r2),
                           pair.x_ij, (xyz(own) - xyz(other)) * other.w);
  }
  struct Lanes {
    spatial::LaneVectors<T> v;
    Stored at(std::size_t k) const { return v.at(k); }
    void load(const StrainBody& body, const Own&, std::uint64_t, const std::uint32_t* slots, std::uint32_t n,
              const T*) {
      v.load(body.w.f.velocity, slots, n);
      for (std::uint32_t k = 0; k < spatial::whole_lanes(n); ++k) v.w[k] = body.factor(slots[k]);
    }
  };
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    if (!takes_part(i)) return;
    Sum sum = s;
    const Vec3<T> x = xyz(w.f.position[i]), v = xyz(w.f.velocity[i]);
    if (w.c.no_slip != 0u)
      core::for_each_near_wall(w, x, [&](int face, T distance) {
        const Vec3<T> normal = physics::wall_normal<T>(face);
        const T depth = physics::wall_depth(w.c.wall_exchange, distance);
        const T weight = physics::wall_weight(s.fit.skew, normal, depth,
                                              physics::wall_area(w.c.wall_exchange, distance) / depth);
        physics::add_neighbour(sum.fit, weight, normal * depth, v - w.c.wall_velocity[face]);
      });
    const T rate = physics::shear_rate(physics::velocity_gradient(sum.fit));
    const core::MaterialRow<T>& m = w.f.materials[material_of(w.f.tag[i])];
    const physics::FlowCurve<T> flow =
        m.tables->yield_stress.points == 0u
            ? m.tables->flow
            : physics::flow_curve_at(m, w.f.enthalpy[i] / static_cast<double>(w.f.mass[i]));
    w.f.viscosity[i] = physics::flow_viscosity(flow, w.f.viscosity[i], rate);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
