// SPDX-License-Identifier: Apache-2.0
// Rows of candidates. Particles are sorted into groups; every group has rows, half-open slot ranges that
// together hold each candidate once. Any structure that can fill `group_of` and `group_ranges` (sorted cells, a
// tree) serves every body unchanged; where cells are counted, a group is a cell and its rows follow from where cells
// begin. Order is fixed: rows ascending, slots ascending.
#pragma once

#include "exec/gather.hpp"
#include "spatial/cells.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Shortest a - b; periodic axes wrap. inv_period is 0 on the others, so the subtraction vanishes.
/// Periodic: whether there are such axes; sweeps are compiled for both.
template <bool Periodic, class T>
MELTSIM_HD Vec3<T> separation(const core::Grid<T>& g, Vec3<T> a, Vec3<T> b) {
  Vec3<T> d = a - b;
  if (Periodic) {
    d.x -= g.period.x * std::rint(d.x * g.inv_period.x);
    d.y -= g.period.y * std::rint(d.y * g.inv_period.y);
    d.z -= g.period.z * std::rint(d.z * g.inv_period.z);
  }
  return d;
}
template <class T>
MELTSIM_HD Vec3<T> separation(const core::Grid<T>& g, Vec3<T> a, Vec3<T> b) {
  return g.periodic != 0u ? separation<true>(g, a, b) : separation<false>(g, a, b);
}

/// The rows of a particle that is not removed.
template <bool Periodic, class T>
class Rows {
 public:
  MELTSIM_HD std::uint32_t within() const { return ~0u; }
  MELTSIM_HD Rows(const core::Frame<T>& w, std::uint64_t i) : w_(w), group_(w.f.group_of[i]) {
    if (!counted()) return;
    place_ = place_of(w.grid, group_);
    if (!Periodic) straight_ = straight_rows(w.grid, place_, group_);
  }
  MELTSIM_HD core::Range operator[](std::uint32_t r) const {
    if (!counted()) return w_.f.group_ranges[std::uint64_t{group_} * w_.grid.rows + r];
    const CellRow<std::uint32_t> row =
        Periodic ? cell_row<std::uint32_t>(w_.grid, place_, r) : straight_row(w_.grid, straight_, r);
    if (row.cells == 0u) return {};
    const std::uint32_t* begin = w_.f.cell_begin + row.first;
    return {begin[0], begin[row.cells]};
  }

 private:
  MELTSIM_HD bool counted() const { return w_.f.group_ranges == nullptr; }
  const core::Frame<T>& w_;
  std::uint32_t group_;
  CellPlace place_{};
  StraightRows straight_{};
};

/// The same where cells are counted and nothing wraps, asked for rows that are within the domain only. Of the particles
/// in cells first and last, where these are in one line and no farther apart than candidates are; else of those in the
/// first.
template <class T>
class CountedRows {
 public:
  MELTSIM_HD CountedRows(const core::Frame<T>& w, std::uint32_t first, std::uint32_t last) : w_(w) {
    const CellPlace at = place_of(w.grid, first);
    own_ = straight_rows(w.grid, at, first);
    const auto reach = static_cast<std::uint32_t>(w.grid.reach);
    const std::uint32_t after = static_cast<std::uint32_t>(w.grid.nx - 1 - at.x), apart = last - first;
    one_line_ = apart <= after;
    both_ = apart <= minimum(after, reach);
    if (both_) own_.cells = last + minimum(after - apart, reach) + 1u - own_.first;
  }
  MELTSIM_HD bool one_line() const { return one_line_; }
  MELTSIM_HD bool of_both() const { return both_; }
  MELTSIM_HD std::uint32_t within() const { return own_.lines; }
  MELTSIM_HD core::Range operator[](std::uint32_t r) const {
    const std::uint32_t* begin =
        w_.f.cell_begin + (own_.first + static_cast<std::uint32_t>(w_.grid.line_cells[r]));
    return {begin[0], begin[own_.cells]};
  }

 private:
  const core::Frame<T>& w_;
  StraightRows own_;
  bool one_line_, both_;
};

/// Rows whose bits are set, ascending.
struct SomeRows {
  std::uint32_t bits;
  MELTSIM_HD bool empty() const { return bits == 0u; }
  MELTSIM_HD std::uint32_t take() {
    const auto r = static_cast<std::uint32_t>(lowest_bit(bits));
    bits &= bits - 1u;
    return r;
  }
};

/// Part k of the rows (exec/gather.hpp). A third has a row of every layer in y and in z, so that beside
/// walls, where layers are missing, all parts still have as much to do.
template <class T>
MELTSIM_HD SomeRows rows_of_part(const core::Frame<T>& w, std::uint32_t k, std::uint32_t parts) {
  const std::uint32_t rows = parts == 1u ? 0x1ffu : parts == 3u ? third_of_lines(k) : 1u << k;
  return {(rows | rows << 9) & ((1u << w.grid.rows) - 1u)};
}

/// visit(j, x_j, x_ij, r2) for candidate j if it is within H of x_i.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void visit_if_near(const core::Frame<T>& w, Vec3<T> xi, std::uint32_t j, const Visit& visit) {
  const Vec4<T> xj = w.f.position[j];
  const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
  const T r2 = dot(d, d);
  if (r2 < w.c.kernel.support2) visit(j, xj, d, r2);
}

/// visit(j, x_j, x_ij, r2) for the candidates within H of i in these rows, by distance.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void search_rows(const core::Frame<T>& w, std::uint64_t i, SomeRows set, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const Rows<Periodic, T> rows(w, i);
  while (!set.empty()) {
    const core::Range row = rows[set.take()];
    for (std::uint32_t j = row.begin; j < row.end; ++j) visit_if_near<Periodic>(w, xi, j, visit);
  }
}

/// Row k in the order of cells in z, then y; those that wrap come last. The rows of a tree ascend as they are.
template <class T>
MELTSIM_HD std::uint32_t row_upwards(const core::Frame<T>& w, std::uint32_t k) {
  if (w.tree.levels != 0) return k;
  return k < 9u ? line_upwards(k) : 9u + line_upwards(k - 9u);
}

/// All neighbours by rows, upwards or exactly reversed. For sums that depend on the order (the paper's
/// running temperatures: where opposite rows follow each other, 0.3 of the heat crosses that its formula says at Fo 1).
/// Words are sorted into as many sets as a backend has parts of a sum, rows are the same everywhere.
template <bool Periodic, bool Upwards, class T, class Visit>
MELTSIM_HD void for_each_in_row_order(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const Rows<Periodic, T> rows(w, i);
  for (std::uint32_t k = 0; k < w.grid.rows; ++k) {
    const core::Range row = rows[row_upwards(w, Upwards ? k : w.grid.rows - 1u - k)];
    for (std::uint32_t n = 0; n < row.end - row.begin; ++n)
      visit_if_near<Periodic>(w, xi, Upwards ? row.begin + n : row.end - 1u - n, visit);
  }
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
