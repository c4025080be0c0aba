// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "spatial/strategies.hpp"
#include "sph/advance_bodies.hpp"
#include "sph/bodies.hpp"
#include "sph/shift_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

template <class E, class T>
void density(E& ex, const core::Frame<T>& w) {
  spatial::with_search_of<E>(
      w, [&](auto kind) { spatial::find<kind(), true>(ex, w, DensityBody<T, kind()>{w}); });
}

template <class E, class T>
void viscosity(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ViscosityBody<T>{w});
}

template <Company company, bool Periodic, class E, class T>
void forces_of(E& ex, const core::Frame<T>& w) {
  spatial::sweep<Periodic>(ex, w.particles, ForcesBody<T, company, Periodic>{w});
}

template <class E, class T>
void forces(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) {
    switch (company_of(w)) {
      case Company::liquid:
        return forces_of<Company::liquid, periodic()>(ex, w);
      case Company::solids:
        return forces_of<Company::solids, periodic()>(ex, w);
      case Company::any:
        return forces_of<Company::any, periodic()>(ex, w);
    }
  });
}

/// forces and step.integrate in one launch, where a liquid is alone and no stage stands between the two; not a stage.
template <class E, class T>
void advance(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) {
    ex.gather_reduce(w.particles, AdvanceBody<T, periodic()>{{w}}, w.f.check, core::JudgeBody<T>{w});
  });
}

template <class E, class T>
void wetted(E& ex, const core::Frame<T>& w) {
  ex.for_each((std::uint64_t{w.particles} + 31u) / 32u, LiquidBitsBody<T>{w});
  ex.select(w.particles, WettedBody<T>{w}, w.f.wetted);
}

template <class E, class T>
void reaction(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) {
    spatial::sweep_listed<periodic()>(ex, w.particles, w.f.wetted, ReactionBody<T, periodic()>{{w}});
  });
}

template <class E, class T>
void shift(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ShiftBody<T>{w});
}

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
