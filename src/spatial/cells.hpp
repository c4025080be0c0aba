// SPDX-License-Identifier: Apache-2.0
// Cells of the grid: the cell of a coordinate, and the rows of cells around a cell.
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/integrate.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Cell of a coordinate; outside positions count to the border cell, periodic ones wrap. NaN lies in some
/// cell, too: the check at the end of the sub-step names it.
template <class T>
MELTSIM_HD std::int32_t cell_coordinate(T x, T min, T inv_cell, std::int32_t n, bool periodic) {
  const T c = std::floor((x - min) * inv_cell);
  if (periodic) {
    constexpr auto most = static_cast<T>(1 << 30);  // an integer holds it
    auto k = static_cast<std::int32_t>(clamp(c, -most, most)) % n;
    return k < 0 ? k + n : k;
  }
  return static_cast<std::int32_t>(clamp(c, T(0), T(n - 1)));
}

/// Number of a cell: x fastest. Key: wide enough for all cells; narrow arithmetic is several times faster.
template <class Key, class T>
MELTSIM_HD Key cell_key(const core::Grid<T>& g, std::int32_t x, std::int32_t y, std::int32_t z) {
  return (static_cast<Key>(z) * static_cast<Key>(g.ny) + static_cast<Key>(y)) * static_cast<Key>(g.nx) +
         static_cast<Key>(x);
}

/// Cell of a particle at x with velocity v once it has drifted half a step; removed_key where it was removed.
template <class T>
MELTSIM_HD std::uint64_t cell_of(const core::Frame<T>& w, std::uint32_t tag, Vec3<T> x, Vec3<T> v) {
  if (is_removed(tag)) return core::removed_key;
  x = physics::drift(x, v, w.f.clock->half_dt);
  return cell_key<std::uint64_t>(
      w.grid, cell_coordinate(x.x, w.grid.min.x, w.grid.inv_cell.x, w.grid.nx, w.grid.periodic & 1u),
      cell_coordinate(x.y, w.grid.min.y, w.grid.inv_cell.y, w.grid.ny, w.grid.periodic & 2u),
      cell_coordinate(x.z, w.grid.min.z, w.grid.inv_cell.z, w.grid.nz, w.grid.periodic & 4u));
}

/// The same if cells are counted one by one: removed particles count to a cell behind the last.
template <class T>
MELTSIM_HD std::uint32_t counted_cell(const core::Frame<T>& w, std::uint32_t tag, Vec3<T> x, Vec3<T> v) {
  const std::uint64_t cell = cell_of(w, tag, x, v);
  return cell == core::removed_key ? w.cells : static_cast<std::uint32_t>(cell);
}

struct CellPlace {
  std::int32_t x = 0, y = 0, z = 0;
};

template <class Key, class T>
MELTSIM_HD CellPlace place_of(const core::Grid<T>& g, Key key) {
  const auto nx = static_cast<Key>(g.nx), ny = static_cast<Key>(g.ny);
  const Key line = key / nx, layer = line / ny;
  return {static_cast<std::int32_t>(key - line * nx), static_cast<std::int32_t>(line - layer * ny),
          static_cast<std::int32_t>(layer)};
}

/// Cells whose particles are candidates, one after another.
template <class Key>
struct CellRow {
  Key first = 0, cells = 0;
};

/// The nine lines of cells along x around a particle's own, where they lie in y and z: two bits each, + 1. The own one
/// comes last, which is where walks through neighbours begin, then those across corners; opposite ones follow each
/// other. A particle high up in its cell has more neighbours above and fewer below, of both together as many as
/// others: so the walks of threads side by side stay side by side. (Of all orders that were tried on a lattice at 2 and
/// 2.5 spacings, loads of positions touch 15 lines of memory per turn of a warp; ascending y and z takes 22.)
inline constexpr std::uint32_t lines_y = 0x12885u, lines_z = 0x18858u;
MELTSIM_HD std::int32_t line_offset(std::uint32_t offsets, std::uint32_t line) {
  return static_cast<std::int32_t>(offsets >> 2u * line & 3u) - 1;
}
/// Line k of them in order of z, then y, which is that of slots where nothing wraps.
MELTSIM_HD std::uint32_t line_upwards(std::uint32_t k) {
  return static_cast<std::uint32_t>(std::uint64_t{0x517382604u} >> 4u * k & 15u);
}
/// Bit per line: below and above the own one in y, in z.
inline constexpr std::uint32_t lines_below_y = 0x94u, lines_above_y = 0x68u, lines_below_z = 0x51u,
                               lines_above_z = 0xa2u;

/// A third of the lines, as bits: line (y, z) belongs to third (y + z) mod 3, so that each has one of every layer.
MELTSIM_HD std::uint32_t third_of_lines(std::uint32_t k) {
  return k == 0u ? 0x1c0u : k == 1u ? 0x1au : 0x25u;
}

/// Row r of a cell: cells within H in x of each line are adjacent in key order. A row that wraps in x splits in two;
/// that is why periodic x has 18 rows.
template <class Key, class T>
MELTSIM_HD CellRow<Key> cell_row(const core::Grid<T>& grid, const CellPlace& cell, std::uint32_t r) {
  const bool wraps = r >= 9u;
  const std::uint32_t line = wraps ? r - 9u : r;
  std::int32_t y = cell.y + line_offset(lines_y, line), z = cell.z + line_offset(lines_z, line);
  if (grid.periodic & 2u) y = y < 0 ? y + grid.ny : (y >= grid.ny ? y - grid.ny : y);
  if (grid.periodic & 4u) z = z < 0 ? z + grid.nz : (z >= grid.nz ? z - grid.nz : z);
  if (y < 0 || y >= grid.ny || z < 0 || z >= grid.nz) return {};
  std::int32_t first = cell.x - grid.reach, last = cell.x + grid.reach;
  if (wraps) {
    if (first < 0) {
      first += grid.nx;
      last = grid.nx - 1;
    } else {
      first = 0;
      last -= grid.nx;
    }
    if (first > last) return {};
  }
  first = maximum(first, 0);
  return {cell_key<Key>(grid, first, y, z), static_cast<Key>(minimum(last, grid.nx - 1) - first + 1)};
}

/// The same where nothing wraps: the row of the own line, as many cells on as another line is away.
struct StraightRows {
  std::uint32_t first, cells;  ///< of the own line
  std::uint32_t lines;         ///< bit per line: within the domain
};

template <class T>
MELTSIM_HD StraightRows straight_rows(const core::Grid<T>& g, const CellPlace& at, std::uint32_t key) {
  const std::int32_t before = minimum(at.x, g.reach), after = minimum(g.nx - 1 - at.x, g.reach);
  std::uint32_t beyond = 0;
  if (at.y == 0) beyond |= lines_below_y;
  if (at.y == g.ny - 1) beyond |= lines_above_y;
  if (at.z == 0) beyond |= lines_below_z;
  if (at.z == g.nz - 1) beyond |= lines_above_z;
  return {key - static_cast<std::uint32_t>(before), static_cast<std::uint32_t>(before + after + 1), ~beyond};
}

template <class T>
MELTSIM_HD CellRow<std::uint32_t> straight_row(const core::Grid<T>& g, const StraightRows& own,
                                               std::uint32_t r) {
  if ((own.lines >> r & 1u) == 0u) return {};
  return {own.first + static_cast<std::uint32_t>(g.line_cells[r]), own.cells};
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
