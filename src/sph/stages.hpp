// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

template <class E, class T>
void seen_volume(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, SeenVolumeBody<T>{w});
}

template <class E, class T>
void density(E& ex, const core::Frame<T>& w) {
  if (w.mixed) ex.gather(w.particles, DensityBody<T, true>{w});
  else ex.gather(w.particles, DensityBody<T, false>{w});
}

template <class E, class T>
void viscosity(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ViscosityBody<T>{w});
}

template <class E, class T>
void forces(E& ex, const core::Frame<T>& w) {
  if (w.mixed) ex.gather(w.particles, ForcesBody<T, true>{w});
  else ex.gather(w.particles, ForcesBody<T, false>{w});
}

template <class E, class T>
void reaction(E& ex, const core::Frame<T>& w) {
  ex.gather(w.particles, ReactionBody<T>{w});
}

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
