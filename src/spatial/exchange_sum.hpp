// SPDX-License-Identifier: Apache-2.0
// Diffusive exchange of a particle with its neighbours: heat, contents of a species, momentum.
#pragma once

#include <type_traits>

#include "spatial/sweep.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Value: double, or Vec3<T>. What neighbours give alone: of a stage whose bound an earlier one looked at.
template <class Value, class T>
struct RateSum {
  Value rate{};  ///< exchange per second
  MELTSIM_HD void add(const RateSum& o) { rate += o.rate; }
  struct Lanes {
    std::conditional_t<std::is_same<Value, Vec3<T>>::value, LaneVectorSum<T>, LaneSum<double>> rate;
    RateSum at(std::size_t l) const { return {rate.at(l)}; }
    void put(std::size_t l, const RateSum& s) { rate.put(l, s.rate); }
    RateSum total() const { return {rate.total()}; }
  };
};

template <class Value, class T>
struct ExchangeSum : RateSum<Value, T> {
  T conductance{};  ///< sum of the conductances of pairs, for the bound of a stage
  MELTSIM_HD void add(const ExchangeSum& o) {
    this->rate += o.rate;
    conductance += o.conductance;
  }
  struct Lanes {
    typename RateSum<Value, T>::Lanes rates;
    LaneSum<T> conductance;
    ExchangeSum at(std::size_t l) const { return {rates.at(l), conductance.at(l)}; }
    void put(std::size_t l, const ExchangeSum& s) {
      rates.put(l, s);
      conductance.put(l, s.conductance);
    }
    ExchangeSum total() const { return {rates.total(), conductance.total()}; }
  };
};

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
