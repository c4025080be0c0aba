// SPDX-License-Identifier: Apache-2.0
// Stages of a reading. They neither wait nor allocate.
#pragma once

#include <algorithm>

#include "reading/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace reading {

/// Copies the status and how many events there are, and resets the extremes. The caller lifts the guard.
template <class E, class T>
void status(E& ex, const core::ReadingFrame<T>& w) {
  ex.for_each(1, StatusBody<T>{w});
}

/// Sums over all particles.
template <class E, class T>
void sums(E& ex, const core::ReadingFrame<T>& w) {
  ex.reduce(w.s.particles, LedgerBody<T>{w}, &w.head->sums);
  ex.reduce(w.s.particles, ExtentsBody<T>{w}, &w.head->extents);
  if (w.s.species != 0u) ex.reduce(w.s.particles, ContentsBody<T>{w}, &w.head->contents);
}

/// How many pieces there are, and the row of each, in order of their labels. Needs the results of sums(),
/// from which the units of sums over pieces follow.
template <class E, class T>
void count_pieces(E& ex, const core::ReadingFrame<T>& w) {
  ex.fill(w.s.vertices / 32u + 1u, 0u, w.is_label);
  ex.accumulate(w.s.vertices, PresentBody<T>{w});
  ex.scan(w.s.vertices, LabelCountBody{w.is_label}, w.piece_of);
  ex.for_each(1, PieceCountBody<T>{w});
}

/// Levels of the liquid over all columns.
template <class E, class T>
void levels(E& ex, const core::ReadingFrame<T>& w) {
  const auto columns = static_cast<std::uint64_t>(w.grid.na) * static_cast<std::uint64_t>(w.grid.nb);
  ex.for_each(columns, ClearColumnBody<T>{w});
  ex.accumulate(w.s.particles, ColumnTopBody<T>{w});
  ex.accumulate(w.s.particles, ColumnVolumeBody<T>{w});
  ex.for_each(columns, ColumnLevelBody<T>{w});
  core::LevelSums* from = w.levels;
  for (std::int32_t level = 0; level + 1 < w.grid.levels; ++level) {
    const std::int32_t na = squares(w.grid.na, level), nb = squares(w.grid.nb, level);
    core::LevelSums* const to = from + static_cast<std::int64_t>(na) * nb;
    const auto coarser =
        static_cast<std::uint64_t>(squares(na, 1)) * static_cast<std::uint64_t>(squares(nb, 1));
    ex.for_each(coarser, CoarserBody<T>{w, from, to, na, nb});
    from = to;
  }
}

/// Sums over pieces; after count_pieces.
template <class E, class T>
void pieces(E& ex, const core::ReadingFrame<T>& w) {
  levels<E, T>(ex, w);
  ex.for_each(w.piece_room, ClearRowBody<T>{w});
  ex.accumulate(w.s.vertices, FirstVertexBody<T>{w});
  ex.for_each(w.piece_room, DescribeRowBody<T>{w});
  ex.accumulate(w.s.vertices, BoundsBody<T>{w});
  ex.sum_by_row(w.s.vertices, PieceTotalsBody<T>{w}, w.totals);
}

/// Copies impulses on bodies and events, and resets them; after status().
template <class E, class T>
void records(E& ex, const core::ReadingFrame<T>& w) {
  ex.for_each(std::max(w.bodies_taken, w.events_taken), TakeRecordsBody<T>{w});
}

/// Particles in single precision, by id.
template <class E, class T>
void pack(E& ex, const core::ReadingFrame<T>& w) {
  // The density of a restored state is stored at other slots.
  if (w.has_density != 0u && w.rolled_back != 0u) ex.for_each(w.s.particles, PackBeforeBody<T>{w});
  ex.for_each(w.s.particles, PackBody<T>{w});
}

}  // namespace reading
}  // namespace v0
}  // namespace meltsim
