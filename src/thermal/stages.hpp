// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "spatial/strategies.hpp"
#include "thermal/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace thermal {

/// Computes dry area, heat source and held temperature of every particle. The enthalpy jump of held particles is heat input.
template <class E, class T>
void boundary(E& ex, const core::Frame<T>& w) {
  static_assert(sizeof(HeatSum) == sizeof(double));
  ex.for_each(w.particles, BoundaryBody<T>{w});
  ex.reduce(w.particles, BoundarySumBody<T>{w}, reinterpret_cast<HeatSum*>(&w.f.heat_account->rate));
  ex.for_each(1, AccountBody<T>{w, 0, 0, 1, 0, true, true});
}

/// heat_supersteps super-steps of heat_stages Runge-Kutta-Legendre stages each.
template <bool Boundary, bool Periodic, class E, class T>
void super_steps(E& ex, core::Frame<T>& w) {
  const int stages = static_cast<int>(w.heat_stages);
  for (std::uint32_t super = 0; super < w.heat_supersteps; ++super) {
    for (int j = 1; j <= stages; ++j) {
      if (ex.asked_to_stop()) return;  // the sub-step will not count
      physics::HeatStage c = physics::heat_stage(j, stages);
      if (j == 2) c.nu = 0;  // d_0 = 0 and is not stored
      const double tau = static_cast<double>(w.heat_dt);
      const StageOf which{j == 1, j == stages, j == stages && super + 1u == w.heat_supersteps};
      const StageBody<T, Boundary, Periodic> stage{w, c.mu, c.nu, c.mu_rate * tau, c.gamma_rate * tau, which};
      spatial::sweep_adding<Periodic>(ex, w.particles, stage);
      if (Boundary) {
        ex.reduce(w.particles, BoundarySumBody<T>{w}, reinterpret_cast<HeatSum*>(&w.f.heat_account->rate));
        ex.for_each(1,
                    AccountBody<T>{w, c.mu, c.nu, c.mu_rate * tau, c.gamma_rate * tau, j == 1, j == stages});
      }
      std::swap(w.f.heat_increment, w.f.heat_increment_old);
      std::swap(w.f.heat_operand, w.f.heat_operand_next);
    }
  }
}

template <class E, class T>
void operands(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, OperandsBody<T>{w});
}

template <class E, class T>
void exchange(E& ex, const core::Frame<T>& frame) {
  core::Frame<T> w = frame;
  spatial::with_periods(w, [&](auto periodic) {
    if (w.f.heat_boundary != nullptr) super_steps<true, periodic()>(ex, w);
    else super_steps<false, periodic()>(ex, w);
  });
}

/// Stops heat where temperatures are level.
template <class E, class T>
void level(E& ex, const core::Frame<T>& w) {
  ex.reduce(w.particles, SpreadBody<T>{w}, w.f.heat_spread, LevelBody<T>{w});
}

/// Eq. (4) in two sweeps of half the step each, the second with the neighbours in reverse order.
template <class E, class T>
void paper(E& ex, const core::Frame<T>& frame) {
  core::Frame<T> w = frame;
  ex.for_each(w.particles, PlainOperandsBody<T>{w});
  spatial::with_periods(w, [&](auto periodic) {
    ex.for_each(w.particles, PaperBody<T, true, periodic()>{w});
    std::swap(w.f.heat_operand, w.f.heat_operand_next);
    ex.for_each(w.particles, PaperBody<T, false, periodic()>{w});
  });
}

/// Explicit exchange of temperatures.
template <class E, class T>
void iwasaki(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, PlainOperandsBody<T>{w});
  ex.accumulate(w.particles, IwasakiBody<T>{w});
}

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
