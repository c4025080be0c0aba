// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "shared/super_steps.hpp"
#include "spatial/strategies.hpp"
#include "species/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace species {

/// One species after the other, each in solute_supersteps explicit steps.
template <class E, class T>
void exchange(E& ex, const core::Frame<T>& w) {
  const core::SuperSteps plan{1u, w.solute_supersteps, w.solute_dt};
  spatial::with_periods(w, [&](auto periodic) {
    for (std::uint32_t k = 0; k < w.species; ++k) {
      ex.for_each(w.particles, SoluteOperandsBody<T>{w, k});
      core::super_steps(ex, plan, [&](const physics::StageFactors<double>& stage) {
        if (w.solute_rooms)
          spatial::sweep_adding<periodic()>(
              ex, w.particles, ExchangeBody<T, periodic(), true>{w, k, stage.rate, stage.begins});
        else
          spatial::sweep_adding<periodic()>(
              ex, w.particles, ExchangeBody<T, periodic(), false>{w, k, stage.rate, stage.begins});
        if (!stage.ends) ex.for_each(w.particles, PotentialBody<T>{w, k});
      });
    }
  });
}

}  // namespace species
}  // namespace v0
}  // namespace meltsim
