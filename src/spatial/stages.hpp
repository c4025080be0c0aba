// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "spatial/bodies.hpp"
#include "spatial/strategies.hpp"
#include "spatial/tree_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

template <class E, class T>
void cells(E& ex, const core::Frame<T>& w) {
  if (w.counted) {
    if (!w.cells_begun) ex.begin_buckets(w.cells + 1, w.f.cell_count, w.f.cell_begin, core::Nothing{});
    ex.fill_buckets(w.particles, w.f.cell_of, w.f.cell_begin, w.f.cell_order, w.f.cell_count);
    return;
  }
  ex.bucket(w.particles, w.cells + 1, CellBody<T>{w}, w.f.cell_of, w.f.cell_begin, w.f.cell_order,
            w.f.cell_count);
}

template <class E, class T>
void settle(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, SettleBody<T>{w});
}

template <class E, class T>
void keys(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, KeysBody<T>{w});
}

template <class E, class T>
void sort(E& ex, const core::Frame<T>& w) {
  ex.sort(w.particles, w.key_bits, w.f.sort_key, w.f.sort_slot, w.f.sort_key_alt, w.f.sort_slot_alt);
}

template <class E, class T>
void reorder(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ReorderBody<T>{w});
}

template <class E, class T>
void groups(E& ex, const core::Frame<T>& w) {
  ex.scan(w.particles, HeadBody<T>{w}, w.f.group_of);
  ex.for_each(w.particles, GroupsBody<T>{w});
}

template <class E, class T>
void ranges(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.max_groups, RangesBody<T>{w});
}

template <class E, class T>
void codes(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, CodesBody<T>{w});
}

template <class E, class T>
void leaves(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, LeafHeadBody<T>{w});
  ex.scan(w.particles, LeafHeadsBody<T>{w}, w.f.sort_slot);
  ex.for_each(w.particles, LeavesBody<T>{w});
}

template <class E, class T>
void boxes(E& ex, const core::Frame<T>& w) {
  for (int level = 0; level < w.tree.levels; ++level)
    ex.for_each(nodes_of(w.max_groups, level), BoxBody<T>{w, level});
}

template <class E, class T>
void walk(E& ex, const core::Frame<T>& w) {
  with_periods(w, [&](auto periodic) { ex.for_each(w.max_groups, WalkBody<T, periodic()>{w}); });
}

template <class E, class T>
void neighbours(E& ex, const core::Frame<T>& w) {
  with_search_of<E>(w, [&](auto kind) { find<kind(), false>(ex, w, NeighboursBody<T, kind()>{w}); });
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
