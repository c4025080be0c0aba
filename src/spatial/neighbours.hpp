// SPDX-License-Identifier: Apache-2.0
// The neighbour loop. Particles are sorted into groups; every group carries rows, half-open slot ranges that
// together hold each candidate once. Any structure that can fill `group_of` and `group_ranges` (grid today,
// tree tomorrow) serves every body unchanged. Order is fixed: rows ascending, slots ascending.
#pragma once

#include <type_traits>

#include "core/frame.hpp"

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

/// Candidates of a row that neighbour_bits covers.
inline constexpr std::uint32_t bits_per_row = 64;

/// A sweep may be shared out in parts, each over its own rows (exec_cpu.hpp: gather). Part k of 3 takes one
/// layer of cells in z.
inline constexpr std::uint32_t rows_per_part = 3;

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

/// visit(j, x_j, x_ij, r2, near) for every candidate in one part of the rows, and stores which are near: the
/// first sweep of a sub-step. Where branches are dear, candidates that are not near are visited, too; what
/// vanishes beyond H needs no branch.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void find_neighbours(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part,
                                const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  const auto look = [&](std::uint32_t j) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    const T r2 = dot(d, d);
    const bool near = r2 < w.c.kernel.support2;
    if (on_device() || near) visit(j, xj, d, r2, near);
    return near ? 1u : 0u;
  };
  const auto mark = [&](std::uint32_t begin, std::uint32_t end) {
    std::uint32_t bits = 0;
    for (std::uint32_t j = begin; j < end; ++j) bits |= look(j) << (j - begin);
    return bits;
  };
  for (std::uint32_t half = 0; half < w.grid.rows; half += 9)
    for (std::uint32_t k = 0; k < rows_per_part; ++k) {
      const std::uint32_t r = half + rows_per_part * part + k;
      const core::Range row = rows[r];
      std::uint64_t bits = mark(row.begin, minimum(row.begin + 32u, row.end));
      if (row.end - row.begin > 32u)
        bits |= static_cast<std::uint64_t>(
                    mark(row.begin + 32u, minimum(row.begin + bits_per_row, row.end)))
                << 32;
      bits_of(w, i, r) = bits;
      for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) look(j);
    }
}

/// for_each_neighbour over one part of the rows. The bits of three rows are one queue: threads that run side
/// by side wait for the longest sum, not for the longest of every row.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void sweep(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, const Visit& visit) {
  static_assert(rows_per_part == 3);
  const Vec3<T> xi = xyz(w.f.position[i]);
  const auto see = [&](std::uint32_t j) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    visit(j, xj, d, dot(d, d));
  };
  for (std::uint32_t half = 0; half < w.grid.rows; half += 9) {
    const std::uint32_t r = half + rows_per_part * part;
    const core::Range* rows = rows_of(w, i) + r;
    std::uint32_t begin = rows[0].begin, begin1 = rows[1].begin, begin2 = rows[2].begin;
    std::uint64_t bits = bits_of(w, i, r), bits1 = bits_of(w, i, r + 1), bits2 = bits_of(w, i, r + 2);
    const auto next_row = [&] {
      begin = begin1;
      bits = bits1;
      begin1 = begin2;
      bits1 = bits2;
      bits2 = 0;
    };
    for (std::uint32_t left = popcount(bits) + popcount(bits1) + popcount(bits2); left != 0u; --left) {
      if (bits == 0u) next_row();
      if (bits == 0u) next_row();
      const std::uint32_t j = begin + static_cast<std::uint32_t>(lowest_bit(bits));
      bits &= bits - 1u;
      see(j);
    }
    for (std::uint32_t k = 0; k < rows_per_part; ++k)
      for (std::uint32_t j = rows[k].begin + bits_per_row; j < rows[k].end; ++j) {
        const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(w.f.position[j]));
        if (dot(d, d) < w.c.kernel.support2) see(j);
      }
  }
}

/// stage(std::true_type) where axes are periodic, else stage(std::false_type): picks what is compiled.
template <class T, class Stage>
void with_periods(const core::Frame<T>& w, const Stage& stage) {
  if (w.grid.periodic != 0u) stage(std::true_type{});
  else stage(std::false_type{});
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
