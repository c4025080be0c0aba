// SPDX-License-Identifier: Apache-2.0
// Kernels of implicit viscosity: velocity diffuses in super-steps, from the beginning of the sub-step to its end.
#pragma once

#include <limits>
#include <type_traits>

#include "meltsim/physics/liquid_properties.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"
#include "shared/pair_forces.hpp"
#include "spatial/exchange_sum.hpp"
#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

using core::Frame;

/// Root of a particle of a body that no liquid touches: nothing comes of its sum, which is not made.
inline constexpr double root_of_dry = std::numeric_limits<double>::infinity();

/// Acceleration that shape matching gives a particle of a movable body.
template <class T>
MELTSIM_HD Vec3<T> shape_acceleration(const Frame<T>& w, std::uint64_t i, std::uint32_t tag) {
  if (!is_solid(tag) || w.f.shape_velocity == nullptr) return {};
  return w.f.shape_velocity[w.f.vertex_of_id[w.f.id[i]]] * (T(1) / w.f.clock->dt);
}

/// Velocity and root of the resistivity of every particle; the acceleration of wetted bodies takes shape matching in until the end.
template <class T>
struct ViscousOperandsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    T root = static_cast<T>(root_of_dry);
    if (is_fluid(tag)) {
      const core::MaterialRow<T>& m = w.f.materials[material_of(tag)];
      root = physics::resistivity_root(core::viscosity_of(w, i, m), physics::yields(m));
    } else if (is_solid(tag)) {
      const bool moves = (tag & tag_fixed) == 0u && w.f.liquid_bits != nullptr;
      if (!moves || spatial::any_marked(w, i, w.f.liquid_bits)) root = static_cast<T>(physics::root_of_solid);
      if (moves && root == static_cast<T>(physics::root_of_solid))
        w.f.acceleration[i] += shape_acceleration(w, i, tag);
    }
    // Both buffers: what keeps its velocity is not written again.
    w.f.viscous_operand[i] = w.f.viscous_operand_next[i] = with_w(xyz(w.f.velocity[i]), root);
  }
};

/// Force of neighbours on a particle [N], and in the first stage the part of its conductance that counts towards the bound of the
/// stages [kg/s].
template <class T, bool First>
using ViscousSum = std::conditional_t<First, spatial::ExchangeSum<Vec3<T>, T>, spatial::RateSum<Vec3<T>, T>>;

/// Stage j of a super-step, First: j = 1: the increment of the velocity. The last stage of the last super-step turns the whole increment
/// into the acceleration that step.integrate takes.
template <class T, bool Periodic, bool First>
struct ViscousStageBody {
  Frame<T> w;
  physics::StageFactors<T> stage;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) {
    return sizeof(T) != sizeof(float) ? 0u : 36u;
  }
  using Sum = ViscousSum<T, First>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp): velocity, and the root of the resistivity in w.
  using Stored = Vec4<T>;
  struct Own {
    Vec4<T> operand;
    T volume;
  };
  MELTSIM_HD bool takes_part(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (is_fluid(tag)) return !is_held(tag);
    return is_solid(tag) && (tag & tag_fixed) == 0u && w.f.liquid_bits != nullptr &&
           w.f.viscous_operand[i].w == static_cast<T>(physics::root_of_solid);
  }
  MELTSIM_HD Own own(std::uint64_t i) const { return {w.f.viscous_operand[i], w.f.position[i].w}; }
  MELTSIM_HD Stored stored(const Own&, std::uint32_t j) const { return w.f.viscous_operand[j]; }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& pair,
                      Along) const {
    const T r = std::sqrt(pair.r2);
    const bool body = physics::with_body(own.operand.w, other.w);
    const bool whole = body | !(w.c.central_viscosity.scale > T(0));
    const auto l = physics::laplacian_quotient(w.c.kernel, r, pair.r2);
    const auto c = physics::central_quotient(w.c.central_viscosity, w.c.kernel, r);
    const T g = physics::viscous_conductance(own.volume, pair.volume,
                                             {whole ? l.above : c.above, whole ? l.below : c.below},
                                             own.operand.w, other.w);
    const Vec3<T> v_ji = xyz(other) - xyz(own.operand), u = pair.x_ij * w.c.central_viscosity.inverse_spacing;
    const T across = whole ? g : T(0), along = whole ? T(0) : g * dot(u, v_ji);
    sum.rate += v_ji * across + u * along;
    if constexpr (First)
      sum.conductance +=
          g * (whole ? physics::bound_share(own.operand.w, other.w) : physics::central_share(u));
  }
  struct Lanes {
    spatial::LaneVectors<T> operand;
    Stored at(std::size_t k) const { return operand.at(k); }
    void load(const ViscousStageBody& body, const Own&, std::uint64_t, const std::uint32_t* slots,
              std::uint32_t n, const T*) {
      operand.load(body.w.f.viscous_operand, slots, n);
    }
  };
  template <class Add>
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s, const Add& add) const {
    if (!takes_part(i)) return;
    const std::uint32_t tag = w.f.tag[i];
    const Vec4<T> operand = w.f.viscous_operand[i];
    const Vec4<T> x = w.f.position[i];
    const T mass = w.f.mass[i];
    Vec3<T> force = s.rate;
    T walls = 0;
    if (is_fluid(tag) && w.c.no_slip != 0u)
      core::for_each_sticky_wall(w, xyz(x), physics::viscosity_of_root(operand.w), x.w,
                                 [&](T factor, Vec3<T> velocity) {
                                   force += (velocity - xyz(operand)) * factor;
                                   walls += factor;
                                 });
    if constexpr (First)
      if (static_cast<double>(T(2) * s.conductance + walls) > w.viscous_bound * static_cast<double>(mass))
        add(&w.f.status->viscous_bound_exceeded, 1);
    const Vec3<T> rate = force * (T(1) / mass) + w.f.acceleration[i];
    const Vec3<T> d = physics::next_increment(
        stage, rate, [&] { return w.f.velocity_increment[i]; }, [&] { return w.f.velocity_increment_old[i]; },
        [] { return Vec3<T>{}; });
    // Beyond the first super-step the increments are those since the one before.
    const Vec3<T> whole = stage.begins ? d : w.f.velocity_gained[i] + d;
    if (stage.ends) {
      w.f.acceleration[i] = whole * (T(1) / w.f.clock->dt) - shape_acceleration(w, i, tag);
      return;
    }
    if (stage.last) w.f.velocity_gained[i] = whole;
    w.f.velocity_increment_old[i] = d;
    w.f.viscous_operand_next[i] = with_w(xyz(w.f.velocity[i]) + whole, operand.w);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
