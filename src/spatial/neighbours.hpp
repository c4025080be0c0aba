// SPDX-License-Identifier: Apache-2.0
// The neighbour loop. Particles are sorted into groups; every group carries rows, half-open slot ranges that
// together hold each candidate once. Any structure that can fill `group_of` and `group_ranges` (a grid, a
// tree) serves every body unchanged. Order is fixed: rows ascending, slots ascending.
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

/// What find_neighbours does where a kept grid says which candidates lay within H and skin: the others are
/// not looked at.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void find_among_kept(const core::Frame<T>& w, std::uint64_t i, std::uint32_t first,
                                std::uint32_t last, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  const auto look = [&](std::uint32_t j) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    const T r2 = dot(d, d);
    const bool near = r2 < w.c.kernel.support2;
    if (on_device() || near) visit(j, xj, d, r2, near);
    return near;
  };
  for (std::uint32_t r = first; r < last; ++r) {
    const core::Range row = rows[r];
    const std::uint64_t far = w.f.far_bits[static_cast<std::uint64_t>(r) * w.bits_stride + i];
    std::uint64_t near = far;
    for (std::uint64_t bits = far; bits != 0u; bits &= bits - 1u)
      if (!look(row.begin + static_cast<std::uint32_t>(lowest_bit(bits)))) near &= ~(bits & (~bits + 1u));
    bits_of(w, i, r) = near;
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) look(j);
  }
}

/// visit(j, x_j, x_ij, r2, near) for every candidate in rows [first, last), and stores which are near: the
/// first sweep of a sub-step. Where branches are dear, candidates that are not near are visited, too; what
/// vanishes beyond H needs no branch.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void find_neighbours(const core::Frame<T>& w, std::uint64_t i, std::uint32_t first,
                                std::uint32_t last, const Visit& visit) {
  if (w.f.far_bits != nullptr) return find_among_kept<Periodic>(w, i, first, last, visit);
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  const auto look = [&](std::uint32_t j, const Vec4<T>& xj) {
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    const T r2 = dot(d, d);
    const bool near = r2 < w.c.kernel.support2;
    if (on_device() || near) visit(j, xj, d, r2, near);
    return near;
  };
  const auto mark = [&](std::uint32_t begin, std::uint32_t end) {
    const Vec4<T>* x = w.f.position + begin;
    std::uint32_t bits = 0, k = 0, j = begin;
    // Four at a time: their loads are under way together.
    for (; j + 4u <= end; j += 4u, k += 4u, x += 4) {
      const Vec4<T> x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
      std::uint32_t four = 0;
      if (look(j, x0)) four |= 1u;
      if (look(j + 1u, x1)) four |= 2u;
      if (look(j + 2u, x2)) four |= 4u;
      if (look(j + 3u, x3)) four |= 8u;
      bits |= four << k;
    }
    for (; j < end; ++j, ++k, ++x)
      if (look(j, *x)) bits |= 1u << k;
    return bits;
  };
  for (std::uint32_t r = first; r < last; ++r) {
    const core::Range row = rows[r];
    std::uint64_t bits = mark(row.begin, minimum(row.begin + 32u, row.end));
    if (row.end - row.begin > 32u)
      bits |= static_cast<std::uint64_t>(mark(row.begin + 32u, minimum(row.begin + bits_per_row, row.end)))
              << 32;
    bits_of(w, i, r) = bits;
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) look(j, w.f.position[j]);
  }
}

/// The rows of one of `parts` parts (exec_cpu.hpp: gather): all, or one layer of cells in z; those that wrap
/// in x go with the others. Calls rows(first, last).
template <class T, class Rows>
MELTSIM_HD void rows_of_part(const core::Frame<T>& w, std::uint32_t part, std::uint32_t parts,
                             const Rows& rows) {
  if (parts == 1u) return rows(0u, w.grid.rows);
  for (std::uint32_t half = 3u * part; half < w.grid.rows; half += 9u) rows(half, half + 3u);
}

/// find_neighbours over one part of the rows.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void find_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, std::uint32_t parts,
                          const Visit& visit) {
  rows_of_part(w, part, parts, [&](std::uint32_t first, std::uint32_t last) {
    find_neighbours<Periodic>(w, i, first, last, visit);
  });
}

/// visit(j, x_j, x_ij, r2) for the neighbours of i in rows [first, last). All their bits are one sequence:
/// threads that run side by side wait for the longest sum, not for the longest of every row (72 turns instead
/// of 149 at 61 neighbours).
template <bool Periodic, class T, class Visit>
MELTSIM_HD void sweep(const core::Frame<T>& w, std::uint64_t i, std::uint32_t first, std::uint32_t last,
                      const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  const auto see = [&](std::uint32_t j) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    visit(j, xj, d, dot(d, d));
  };
  const std::uint64_t* row_bits = &bits_of(w, i, first);
  const core::Range* row = rows + first;
  const core::Range* const past = rows + last;
  std::uint64_t bits = 0, next_bits = *row_bits;  // the next row is loaded ahead
  std::uint32_t begin = 0, next_begin = row->begin;
  for (;;) {
    while (bits == 0u) {
      if (row == past) goto crowded;
      bits = next_bits;
      begin = next_begin;
      if (++row == past) continue;
      row_bits += w.bits_stride;
      next_bits = *row_bits;
      next_begin = row->begin;
    }
    const std::uint32_t j = begin + static_cast<std::uint32_t>(lowest_bit(bits));
    bits &= bits - 1u;
    see(j);
  }
crowded:
  for (std::uint32_t r = first; r < last; ++r)
    for (std::uint32_t j = rows[r].begin + bits_per_row; j < rows[r].end; ++j) {
      const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(w.f.position[j]));
      if (dot(d, d) < w.c.kernel.support2) see(j);
    }
}

/// sweep over the rows of one part.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void sweep_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, std::uint32_t parts,
                           const Visit& visit) {
  rows_of_part(w, part, parts,
               [&](std::uint32_t first, std::uint32_t last) { sweep<Periodic>(w, i, first, last, visit); });
}

/// visit(j, x_j, x_ij, r2) for every particle j with |x_ij| < H, i itself included (x_ij = 0). Needs the
/// neighbours that the first sweep stored.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void for_each_neighbour(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  sweep<Periodic>(w, i, 0, w.grid.rows, visit);
}

/// The same where it is not worth two kernels; row by row.
template <class T, class Visit>
MELTSIM_HD void for_each_neighbour(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  const auto see = [&](std::uint32_t j, bool near) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation(w.grid, xi, xyz(xj));
    const T r2 = dot(d, d);
    if (near || r2 < w.c.kernel.support2) visit(j, xj, d, r2);
  };
  for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
    const core::Range row = rows[r];
    for (std::uint64_t bits = bits_of(w, i, r); bits != 0u; bits &= bits - 1u)
      see(row.begin + static_cast<std::uint32_t>(lowest_bit(bits)), true);
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) see(j, false);
  }
}

/// stage(std::true_type) where axes are periodic, else stage(std::false_type): picks what is compiled.
template <class T, class Stage>
void with_periods(const core::Frame<T>& w, const Stage& stage) {
  if (w.grid.periodic != 0u) stage(std::true_type{});
  else stage(std::false_type{});
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
