// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "topology/freeze_bodies.hpp"
#include "topology/piece_bodies.hpp"
#include "topology/region_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

/// Before topology.melt, so that particles frozen in a step are part of the lattice when the masks are updated.
template <class E, class T>
void freeze(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, PickBody<T>{w});
  ex.fill(w.particles, core::none, w.f.claim);
  ex.accumulate(w.vertices, ClaimBody<T>{w});
  ex.for_each(w.vertices, YieldBody<T>{w});
  static_assert(sizeof(Count) == sizeof(std::uint32_t));
  ex.reduce(w.vertices, BornBody<T>{w}, reinterpret_cast<Count*>(&w.f.status->born));
  ex.for_each(w.vertices, JoinBody<T>{w});
  ex.accumulate(w.vertices, BirthBody<T>{w});
  ex.for_each(1, FrozenBody<T>{w});
}

template <class E, class T>
void melt(E& ex, const core::Frame<T>& w) {
  ex.accumulate(w.vertices, MeltBody<T>{w});
}

template <class E, class T>
void neighbours(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, NeighbourMasksBody<T>{w});
}

/// A body's items from `first` on.
template <class Body>
struct From : private Body {
  using Body::w;
  std::uint32_t first;
  MELTSIM_HD From(const Body& body, std::uint32_t from) : Body(body), first(from) {}
  MELTSIM_HD void operator()(std::uint64_t k) const { Body::operator()(first + k); }
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t k, const Add& add) const {
    Body::operator()(first + k, add);
  }
};

/// enqueue(body) with the one of three sizes that is wide enough, because the working set of a thread for a wide region takes local
/// memory.
template <class T, class Enqueue>
void with_fill(const core::Frame<T>& w, bool all, const Enqueue& enqueue) {
  if (w.region_words <= core::words_for(2)) enqueue(FillRegionsBody<T, 2>{w, all});
  else if (w.region_words <= core::words_for(4)) enqueue(FillRegionsBody<T, 4>{w, all});
  else enqueue(FillRegionsBody<T, physics::most_half_width>{w, all});
}

template <class E, class T>
void fill_regions(E& ex, const core::Frame<T>& w, bool all) {
  with_fill(w, all, [&](const auto& body) { ex.for_each(w.vertices, body); });
}

template <class E, class T>
void regions(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, PlaneChangedBody<T>{w});
  fill_regions(ex, w, false);
}

template <class E, class T>
void pieces(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, LabelsBody<T>{w});
  ex.accumulate(w.vertices, ClimbBody<T>{w});
  ex.accumulate(w.vertices, HookBody<T>{w});
  ex.accumulate(w.vertices, AdoptBody<T>{w});
  ex.for_each(1, SettledBody<T>{w});
}

/// arrayN, arrayR and labels of a lattice as uploaded, whose site_live is 0 (not a stage: called when the scene changes).
template <class E, class T>
void build(E& ex, const core::Frame<T>& w) {
  if (w.f.site_live) ex.accumulate(w.vertices, SiteLiveBody<T>{w});
  if (w.f.neighbour_mask) ex.for_each(w.vertices, BuildNeighbourMasksBody<T>{w});
  if (!w.f.neighbour_mask || !w.f.region_mask) return;
  ex.for_each(w.vertices, RowLiveBody<T>{w});
  fill_regions(ex, w, true);
}

/// The same for the vertices of a body that is added, whose part of site_live is 0.
template <class E, class T>
void build_body(E& ex, const core::Frame<T>& w, std::uint32_t first, std::uint32_t count) {
  if (w.f.site_live) ex.accumulate(count, From<SiteLiveBody<T>>({w}, first));
  if (w.f.neighbour_mask) ex.for_each(count, From<BuildNeighbourMasksBody<T>>({w}, first));
  if (!w.f.neighbour_mask || !w.f.region_mask) return;
  ex.for_each(count, From<RowLiveBody<T>>({w}, first));
  with_fill(w, true,
            [&](const auto& body) { ex.for_each(count, From<std::decay_t<decltype(body)>>(body, first)); });
}

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
