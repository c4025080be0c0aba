// SPDX-License-Identifier: Apache-2.0
// The neighbour loop. Particles are sorted into groups; every group carries rows, half-open slot ranges that
// together hold each candidate once. Any structure that can fill `group_of` and `group_ranges` (grid today,
// tree tomorrow) serves every body unchanged. Order is fixed: rows ascending, slots ascending.
#pragma once

#include "core/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Shortest a - b; periodic axes wrap. inv_period is 0 on the others, so the subtraction vanishes.
template <class T>
MELTSIM_HD Vec3<T> separation(const core::Grid<T>& g, Vec3<T> a, Vec3<T> b) {
  Vec3<T> d = a - b;
  if (g.periodic != 0u) {
    d.x -= g.period.x * std::rint(d.x * g.inv_period.x);
    d.y -= g.period.y * std::rint(d.y * g.inv_period.y);
    d.z -= g.period.z * std::rint(d.z * g.inv_period.z);
  }
  return d;
}

/// Candidates of a row that neighbour_bits covers.
inline constexpr std::uint32_t bits_per_row = 64;

/// A sweep may be shared out in parts, each over its own rows (exec_cpu.hpp: gather). Part k of 3 takes one
/// layer of cells in z.
inline constexpr std::uint32_t row_parts = 3;

/// Where the bits of row r of particle i stand: row by row, so that neighbouring threads meet neighbouring
/// words.
template <class T>
MELTSIM_HD std::uint64_t& bits_of(const core::Frame<T>& w, std::uint64_t i, std::uint32_t r) {
  return w.f.neighbour_bits[static_cast<std::uint64_t>(r) * w.bits_stride + i];
}

template <class T>
MELTSIM_HD const core::Range* rows_of(const core::Frame<T>& w, std::uint64_t i) {
  return w.f.group_ranges + static_cast<std::uint64_t>(w.f.group_of[i]) * w.grid.rows;
}

/// Calls row(r) for the rows of one part.
template <class T, class Row>
MELTSIM_HD void for_each_row(const core::Frame<T>& w, std::uint32_t part, const Row& row) {
  constexpr std::uint32_t each = 9 / row_parts;
  for (std::uint32_t half = 0; half < w.grid.rows; half += 9)
    for (std::uint32_t k = 0; k < each; ++k) row(half + each * part + k);
}

/// visit(j, x_j, x_ij, r2) for the neighbours in one row.
template <class T, class Visit>
MELTSIM_HD void visit_row(const core::Frame<T>& w, const Vec3<T>& xi, const core::Range& row,
                          std::uint64_t bits, const Visit& visit) {
  for (; bits != 0u; bits &= bits - 1u) {
    const std::uint32_t j = row.begin + static_cast<std::uint32_t>(lowest_bit(bits));
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation(w.grid, xi, xyz(xj));
    visit(j, xj, d, dot(d, d));
  }
  for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation(w.grid, xi, xyz(xj));
    const T r2 = dot(d, d);
    if (r2 < w.c.kernel.support2) visit(j, xj, d, r2);
  }
}

/// Candidates begin..begin+count (at most 32) within H of xi.
template <class T>
MELTSIM_HD std::uint32_t mark_neighbours(const core::Frame<T>& w, const Vec3<T>& xi, std::uint32_t begin,
                                         std::uint32_t count) {
  std::uint32_t bits = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    const Vec3<T> d = separation(w.grid, xi, xyz(w.f.position[begin + k]));
    bits |= (dot(d, d) < w.c.kernel.support2 ? 1u : 0u) << k;
  }
  return bits;
}

/// Finds and stores which candidates of row r lie within H of i.
template <class T>
MELTSIM_HD std::uint64_t find_neighbours(const core::Frame<T>& w, std::uint64_t i, const Vec3<T>& xi,
                                         std::uint32_t r, const core::Range& row) {
  const std::uint32_t count = row.end - row.begin;
  std::uint64_t bits = mark_neighbours(w, xi, row.begin, minimum(count, 32u));
  if (count > 32u)
    bits |= static_cast<std::uint64_t>(
                mark_neighbours(w, xi, row.begin + 32u, minimum(count, bits_per_row) - 32u))
            << 32;
  bits_of(w, i, r) = bits;
  return bits;
}

/// for_each_neighbour over one part of the rows that also finds and stores the neighbours: what the first
/// sweep of a sub-step does.
template <class T, class Visit>
MELTSIM_HD void find_each_neighbour(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part,
                                    const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  for_each_row(w, part, [&](std::uint32_t r) {
    const core::Range row = rows[r];
    visit_row(w, xi, row, find_neighbours(w, i, xi, r, row), visit);
  });
}

/// for_each_neighbour over one part of the rows.
template <class T, class Visit>
MELTSIM_HD void for_each_neighbour(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part,
                                   const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  for_each_row(w, part, [&](std::uint32_t r) { visit_row(w, xi, rows[r], bits_of(w, i, r), visit); });
}

/// visit(j, x_j, x_ij, r2) for every particle j with |x_ij| < H, i itself included (x_ij = 0). Needs the
/// neighbours that the first sweep stored.
template <class T, class Visit>
MELTSIM_HD void for_each_neighbour(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  for (std::uint32_t r = 0; r < w.grid.rows; ++r) visit_row(w, xi, rows[r], bits_of(w, i, r), visit);
}

/// The same in exactly the reverse order (the paper's second heat sweep).
template <class T, class Visit>
MELTSIM_HD void for_each_neighbour_reversed(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  for (std::uint32_t r = w.grid.rows; r-- > 0;) {
    const core::Range row = rows[r];
    for (std::uint32_t j = row.end; j > row.begin + bits_per_row;) {
      const Vec4<T> xj = w.f.position[--j];
      const Vec3<T> d = separation(w.grid, xi, xyz(xj));
      const T r2 = dot(d, d);
      if (r2 < w.c.kernel.support2) visit(j, xj, d, r2);
    }
    for (std::uint64_t bits = bits_of(w, i, r); bits != 0u;) {
      const int k = highest_bit(bits);
      bits &= ~(std::uint64_t{1} << k);
      const std::uint32_t j = row.begin + static_cast<std::uint32_t>(k);
      const Vec4<T> xj = w.f.position[j];
      const Vec3<T> d = separation(w.grid, xi, xyz(xj));
      visit(j, xj, d, dot(d, d));
    }
  }
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
