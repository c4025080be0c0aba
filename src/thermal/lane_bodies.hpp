// SPDX-License-Identifier: Apache-2.0
// The sweep of a heat stage for a CPU: what StageBody adds up, many neighbours at a time.
#pragma once

#include "spatial/lanes.hpp"
#include "thermal/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace thermal {

template <class T, bool Boundary, bool Periodic>
struct StageLanes : StageBody<T, Boundary, Periodic> {
  using Base = StageBody<T, Boundary, Periodic>;
  using Base::w;
  explicit StageLanes(const Base& body) : Base(body) {}

  template <class Add>
  void operator()(std::uint64_t i, const Add& add) const {
    Base::finish(i, is_removed(w.f.tag[i]) ? ExchangeSum<T>{} : exchanged(i), add);
  }
  ExchangeSum<T> exchanged(std::uint64_t i) const {
    const HeatOperand<T> own = w.f.heat_operand[i];
    if (own.resistivity < T(0)) {
      // What changes its phase conducts by who is at the other end.
      const T share = w.f.heat_share[i];
      const auto toward_other =
          physics::toward_neighbour(w.f.materials[material_of(w.f.tag[i])], own.temperature);
      return exchanged(i, own, [&](T other) { return share * physics::resistivity_of(toward_other(other)); });
    }
    return exchanged(i, own, [&](T) { return own.resistivity; });
  }
  /// resistivity(temperature): of particle i toward one of that temperature.
  template <class Resistivity>
  ExchangeSum<T> exchanged(std::uint64_t i, const HeatOperand<T>& own, const Resistivity& resistivity) const {
    const auto kernel = w.c.kernel;
    const auto grid = w.grid;
    const Vec4<T> xi = w.f.position[i];
    spatial::LaneSum<double> rate;
    spatial::LaneSum<T> conductance;
    spatial::Batches<Periodic, T> neighbours(w, i);
    while (const std::uint32_t n = neighbours.next()) {
      spatial::LaneVectors<T> x;
      spatial::LanePairs<T> other;
      x.load(w.f.position, neighbours.slots, n);
      other.load(w.f.heat_operand, neighbours.slots, n);
      spatial::cut(x.w, n);
      const T *temperature = other.first, *r_other = other.second;
      if (spatial::any_in_lanes(n, [&](std::size_t k) { return r_other[k] < T(0); }))
        settle(neighbours.slots, n, own.temperature, other);
      spatial::in_lanes(n, [&](std::size_t l, std::size_t k) {
        const Vec3<T> d = spatial::separation<Periodic>(grid, xyz(xi), Vec3<T>{x.x[k], x.y[k], x.z[k]});
        const T r2 = dot(d, d);
        const T g =
            physics::pair_conductance(xi.w, x.w[k], physics::laplacian_quotient(kernel, std::sqrt(r2), r2),
                                      resistivity(temperature[k]) + r_other[k]);
        rate.lane[l] += static_cast<double>(g * (temperature[k] - own.temperature));
        conductance.lane[l] += g;
      });
    }
    return {rate.total(), conductance.total()};
  }
  /// Resistivities of neighbours that change their phase, toward one of temperature `own`.
  void settle(const std::uint32_t* slots, std::uint32_t n, T own, spatial::LanePairs<T>& other) const {
    for (std::uint32_t k = 0; k < n; ++k)
      other.second[k] = toward(w, slots[k], HeatOperand<T>{other.first[k], other.second[k]}, own);
  }
};

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
