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

/// The search for neighbours is shared out in parts (exec_cpu.hpp: gather): part k of 3 takes one layer of
/// cells in z.
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
  const auto look = [&](std::uint32_t j, const Vec4<T>& xj, bool exists) {
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    const T r2 = dot(d, d);
    const bool near = exists && r2 < w.c.kernel.support2;
    if (on_device() ? exists : near) visit(j, xj, d, r2, near);
    return near;
  };
  // Four at a time: their loads are under way together.
  const auto look_at_four = [&](std::uint32_t j, std::uint32_t end) {
    const Vec4<T>* x = w.f.position;
    const std::uint32_t most = end - 1u;
    const Vec4<T> x0 = x[j], x1 = x[minimum(j + 1u, most)], x2 = x[minimum(j + 2u, most)],
                  x3 = x[minimum(j + 3u, most)];
    std::uint32_t bits = 0;
    if (look(j, x0, true)) bits |= 1u;
    if (look(j + 1u, x1, j + 1u < end)) bits |= 2u;
    if (look(j + 2u, x2, j + 2u < end)) bits |= 4u;
    if (look(j + 3u, x3, j + 3u < end)) bits |= 8u;
    return bits;
  };
  const auto mark = [&](std::uint32_t begin, std::uint32_t end) {
    std::uint32_t bits = 0, k = 0;
    for (std::uint32_t j = begin; j < end; j += 4u, k += 4u) bits |= look_at_four(j, end) << k;
    return bits;
  };
  for (std::uint32_t r = first; r < last; ++r) {
    const core::Range row = rows[r];
    std::uint64_t bits = mark(row.begin, minimum(row.begin + 32u, row.end));
    if (row.end - row.begin > 32u)
      bits |= static_cast<std::uint64_t>(mark(row.begin + 32u, minimum(row.begin + bits_per_row, row.end)))
              << 32;
    bits_of(w, i, r) = bits;
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) look(j, w.f.position[j], true);
  }
}

/// find_neighbours over one part of the rows.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void find_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, const Visit& visit) {
  for (std::uint32_t half = rows_per_part * part; half < w.grid.rows; half += 9)
    find_neighbours<Periodic>(w, i, half, half + rows_per_part, visit);
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
  // bits: 32 candidates from begin on; upper: the 32 after those; the next row is loaded ahead.
  std::uint32_t bits = 0, upper = 0, begin = 0, r = first;
  std::uint32_t next_begin = rows[r].begin;
  std::uint64_t next_bits = bits_of(w, i, r);
  for (;;) {
    while (bits == 0u) {
      bits = upper;
      begin += 32u;
      upper = 0u;
      if (bits != 0u) break;
      if (r == last) goto crowded;
      bits = static_cast<std::uint32_t>(next_bits);
      upper = static_cast<std::uint32_t>(next_bits >> 32);
      begin = next_begin;
      if (++r == last) continue;
      next_begin = rows[r].begin;
      next_bits = bits_of(w, i, r);
    }
    const std::uint32_t j = begin + static_cast<std::uint32_t>(lowest_bit(bits));
    bits &= bits - 1u;
    see(j);
  }
crowded:
  for (r = first; r < last; ++r)
    for (std::uint32_t j = rows[r].begin + bits_per_row; j < rows[r].end; ++j) {
      const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(w.f.position[j]));
      if (dot(d, d) < w.c.kernel.support2) see(j);
    }
}

/// sweep over the rows of one part.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void sweep_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, const Visit& visit) {
  for (std::uint32_t half = rows_per_part * part; half < w.grid.rows; half += 9)
    sweep<Periodic>(w, i, half, half + rows_per_part, visit);
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
