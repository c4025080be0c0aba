// SPDX-License-Identifier: Apache-2.0
// Diffusive exchange of a particle with its neighbours: heat, contents of a species, momentum.
#pragma once

#include <type_traits>

#include "spatial/sweep.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Value: double, or Vec3<T>.
template <class Value, class T>
struct ExchangeSum {
  Value rate{};     ///< exchange per second
  T conductance{};  ///< sum of the conductances of pairs, for the bound of a stage
  MELTSIM_HD void add(const ExchangeSum& o) {
    rate += o.rate;
    conductance += o.conductance;
  }
  struct Lanes {
    std::conditional_t<std::is_same<Value, Vec3<T>>::value, LaneVectorSum<T>, LaneSum<double>> rate;
    LaneSum<T> conductance;
    ExchangeSum at(std::size_t l) const { return {rate.at(l), conductance.at(l)}; }
    void put(std::size_t l, const ExchangeSum& s) {
      rate.put(l, s.rate);
      conductance.put(l, s.conductance);
    }
    ExchangeSum total() const { return {rate.total(), conductance.total()}; }
  };
};

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
