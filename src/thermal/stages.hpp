// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "thermal/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace thermal {

/// heat_supersteps super-steps of heat_stages Runge-Kutta-Legendre stages each.
template <class E, class T>
void exchange(E& ex, const core::Frame<T>& frame) {
  core::Frame<T> w = frame;
  ex.for_each(w.particles, OperandsBody<T>{w});
  const int stages = static_cast<int>(w.heat_stages);
  for (std::uint32_t super = 0; super < w.heat_supersteps; ++super) {
    for (int j = 1; j <= stages; ++j) {
      const physics::HeatStage c = physics::heat_stage(j, stages);
      // Stage 2 finds d_0 = 0 where stage 1 never wrote: the first stage overwrote d_{-1} only.
      if (j == 2) ex.fill(w.particles, T(0), w.f.heat_increment_old);
      const double tau = static_cast<double>(w.heat_dt);
      ex.accumulate(w.particles, StageBody<T>{w, static_cast<T>(c.mu), static_cast<T>(c.nu),
                                              static_cast<T>(c.mu_rate * tau),
                                              static_cast<T>(c.gamma_rate * tau), j == 1});
      std::swap(w.f.heat_increment, w.f.heat_increment_old);
      std::swap(w.f.heat_operand, w.f.heat_operand_next);
    }
    ex.for_each(w.particles, CommitBody<T>{w});
  }
}

/// Eq. (4) twice over half the step each, the second time with the neighbours reversed.
template <class E, class T>
void paper(E& ex, const core::Frame<T>& frame) {
  core::Frame<T> w = frame;
  ex.for_each(w.particles, OperandsBody<T>{w});
  ex.for_each(w.particles, PaperBody<T, false>{w});
  std::swap(w.f.heat_operand, w.f.heat_operand_next);
  ex.for_each(w.particles, PaperBody<T, true>{w});
}

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
