// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sph/bodies.hpp"
#include "sph/shift_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

template <class E, class T>
void density(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) {
    if (w.mixed) ex.gather(w.particles, DensityBody<T, true, periodic()>{w});
    else ex.gather(w.particles, DensityBody<T, false, periodic()>{w});
  });
}

template <class E, class T>
void viscosity(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ViscosityBody<T>{w});
}

template <class E, class T>
void forces(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) {
    if (w.mixed) ex.gather(w.particles, ForcesBody<T, true, periodic()>{w});
    else ex.gather(w.particles, ForcesBody<T, false, periodic()>{w});
  });
}

template <class E, class T>
void reaction(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) { ex.gather(w.particles, ReactionBody<T, periodic()>{w}); });
}

template <class E, class T>
void shift(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ShiftBody<T>{w});
}

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
