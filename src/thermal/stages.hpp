// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "shared/super_steps.hpp"
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
  ex.for_each(1, AccountBody<T>{w, physics::stage_factors(1, 1, 1.0, true, true)});
}

/// heat_supersteps super-steps of heat_stages Runge-Kutta-Legendre stages each.
template <bool Boundary, bool Periodic, class E, class T>
void super_steps_of_heat(E& ex, core::Frame<T>& w) {
  const core::SuperSteps plan{w.heat_stages, w.heat_supersteps, static_cast<double>(w.heat_dt)};
  core::super_steps(ex, plan, [&](const physics::StageFactors<double>& stage) {
    spatial::sweep_adding<Periodic>(ex, w.particles, StageBody<T, Boundary, Periodic>{w, stage});
    if (Boundary) {
      ex.reduce(w.particles, BoundarySumBody<T>{w}, reinterpret_cast<HeatSum*>(&w.f.heat_account->rate));
      ex.for_each(1, AccountBody<T>{w, stage});
    }
    std::swap(w.f.heat_increment, w.f.heat_increment_old);
    std::swap(w.f.heat_operand, w.f.heat_operand_next);
  });
}

template <class E, class T>
void operands(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, HeatOperandsBody<T>{w});
}

template <class E, class T>
void exchange(E& ex, const core::Frame<T>& frame) {
  core::Frame<T> w = frame;
  spatial::with_periods(w, [&](auto periodic) {
    if (w.f.heat_boundary != nullptr) super_steps_of_heat<true, periodic()>(ex, w);
    else super_steps_of_heat<false, periodic()>(ex, w);
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
  spatial::with_periods(w, [&](auto periodic) {
    spatial::sweep_adding<periodic()>(ex, w.particles, IwasakiBody<T, periodic()>{w});
  });
}

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
