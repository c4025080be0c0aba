// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sph/bodies.hpp"
#include "sph/shift_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

template <class E, class T>
void seen_volume(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, SeenVolumeBody<T>{w});
}

template <class E, class T>
void solid_term(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, SolidTermBody<T>{w});
}

template <class E, class T>
void density(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, DensityBody<T>{w});
}

template <class E, class T>
void viscosity(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ViscosityBody<T>{w});
}

template <class E, class T>
void forces(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ForcesBody<T>{w});
}

template <class E, class T>
void reaction(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ReactionBody<T>{w});
}

template <class E, class T>
void shift(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ShiftBody<T>{w});
}

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
