// SPDX-License-Identifier: Apache-2.0
// Strategies of sums over neighbours: a CPU's vectors take several neighbours at a time, elsewhere neighbours are
// taken one by one, by as many threads as exec/gather.hpp says.
#pragma once

#include <utility>

#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// body.finish(i, sum)
template <bool Periodic, class E, class Body>
void sweep(E& ex, std::uint64_t n, const Body& body) {
  if constexpr (core::runs_lanes<E>) ex.for_each(n, InLanes<Periodic, Body>(body));
  else ex.gather(n, body);
}

/// body.finish(i, sum, add)
template <bool Periodic, class E, class Body>
void sweep_adding(E& ex, std::uint64_t n, const Body& body) {
  if constexpr (core::runs_lanes<E>) ex.accumulate(n, InLanes<Periodic, Body>(body));
  else ex.gather_adding(n, body);
}

/// body.finish(i, sum) for those that were selected.
template <bool Periodic, class E, class Body>
void sweep_listed(E& ex, std::uint64_t n, const std::uint32_t* list, const Body& body) {
  if constexpr (core::runs_lanes<E>) ex.for_each(n, InLanes<Periodic, Body>(body));
  else ex.gather_listed(n, list, body);
}

/// stage(SearchKindConstant<...>{}) of the kinds that an executor tells apart.
template <class E, class T, class Stage>
void with_search_of(const core::Frame<T>& w, const Stage& stage) {
  if constexpr (core::runs_lanes<E>)
    with_periods(w, [&](auto periodic) { stage(SearchKindConstant<search_kind<periodic()>>{}); });
  else with_search(w, stage);
}

/// The first sweep of a sub-step, which finds neighbours; by_twos: where two particles to a thread may pay.
template <SearchKind kind, bool by_twos, class E, class T, class Body>
void find(E& ex, const core::Frame<T>& w, const Body& body) {
  if constexpr (core::runs_lanes<E>) {
    ex.for_each(w.particles, FoundInLanes<kind == SearchKind::periodic, T, Body>(
                                 body, ex.split(w.particles, w.f.position)));
  } else {
    if constexpr (by_twos && core::can_gather_two<E> && kind == SearchKind::counted &&
                  sizeof(T) == sizeof(float))
      if (ex.gathers_two(w.particles) && pays_by_twos(w))
        return ex.gather_two(w.particles, lines(w.grid), body);
    ex.gather(w.particles, body);
  }
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
