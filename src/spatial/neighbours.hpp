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

/// Rows [next, last), ascending.
struct AllRows {
  std::uint32_t next, last;
  MELTSIM_HD bool empty() const { return next == last; }
  MELTSIM_HD std::uint32_t take() { return next++; }
};

/// Rows whose bits are set, ascending. Of a grid, row r is the one in layer r % 3 of cells in y and r / 3 % 3
/// in z, the particle's own being 1; those from 9 on wrap in x.
struct SomeRows {
  std::uint32_t bits;
  MELTSIM_HD bool empty() const { return bits == 0u; }
  MELTSIM_HD std::uint32_t take() {
    const auto r = static_cast<std::uint32_t>(lowest_bit(bits));
    bits &= bits - 1u;
    return r;
  }
};

/// Part k of the rows (core/gather.hpp). A third has a row of every layer in y and in z, so that beside
/// walls, where layers are missing, all parts still have as much to do.
template <class T>
MELTSIM_HD SomeRows rows_of_part(const core::Frame<T>& w, std::uint32_t k, std::uint32_t parts) {
  const std::uint32_t third = k == 0u ? 0x0a1u : k == 1u ? 0x10au : 0x054u;
  const std::uint32_t rows = parts == 1u ? 0x1ffu : parts == 3u ? third : 1u << k;
  return {(rows | rows << 9) & ((1u << w.grid.rows) - 1u)};
}

/// Rows that may hold what has images within H in walls of these axes. Cells are no shorter than H in y and z
/// and begin at the walls, so where d_i + d_j < H both are in the layer beside the wall.
template <class T>
MELTSIM_HD std::uint32_t rows_beside_walls(const core::Frame<T>& w, std::uint32_t axes) {
  if ((axes & 1u) != 0u || w.tree.levels != 0) return ~0u;  // leaves know nothing of walls
  const std::uint32_t y = 0x092u, z = 0x038u;
  const std::uint32_t rows = ((axes & 2u) != 0u ? y : 0u) | ((axes & 4u) != 0u ? z : 0u);
  return rows | rows << 9;
}

/// What find_neighbours does where a kept grid says which candidates lay within H and skin: the others are
/// not looked at.
template <bool Periodic, class T, class Rows, class Visit>
MELTSIM_HD void find_among_kept(const core::Frame<T>& w, std::uint64_t i, Rows set, const Visit& visit) {
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
  while (!set.empty()) {
    const std::uint32_t r = set.take();
    const core::Range row = rows[r];
    const std::uint64_t far = w.f.far_bits[static_cast<std::uint64_t>(r) * w.bits_stride + i];
    std::uint64_t near = far;
    for (std::uint64_t bits = far; bits != 0u; bits &= bits - 1u)
      if (!look(row.begin + static_cast<std::uint32_t>(lowest_bit(bits)))) near &= ~(bits & (~bits + 1u));
    bits_of(w, i, r) = near;
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) look(j);
  }
}

/// visit(j, x_j, x_ij, r2, near) for every candidate in these rows, and stores which are near: the first
/// sweep of a sub-step. Where branches are dear, candidates that are not near are visited, too; what
/// vanishes beyond H needs no branch.
template <bool Periodic, class T, class Rows, class Visit>
MELTSIM_HD void find_neighbours(const core::Frame<T>& w, std::uint64_t i, Rows set, const Visit& visit) {
  if (w.f.far_bits != nullptr) return find_among_kept<Periodic>(w, i, set, visit);
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
  while (!set.empty()) {
    const std::uint32_t r = set.take();
    const core::Range row = rows[r];
    std::uint64_t bits = mark(row.begin, minimum(row.begin + 32u, row.end));
    if (row.end - row.begin > 32u)
      bits |= static_cast<std::uint64_t>(mark(row.begin + 32u, minimum(row.begin + bits_per_row, row.end)))
              << 32;
    bits_of(w, i, r) = bits;
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) look(j, w.f.position[j]);
  }
}

/// find_neighbours over one part of the rows.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void find_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, std::uint32_t parts,
                          const Visit& visit) {
  if (parts == 1u) find_neighbours<Periodic>(w, i, AllRows{0u, w.grid.rows}, visit);
  else find_neighbours<Periodic>(w, i, rows_of_part(w, part, parts), visit);
}

/// visit(j, x_j, x_ij, r2) for the neighbours of i in these rows. All their bits are one sequence: threads
/// that run side by side wait for the longest sum, not for the longest of every row (72 turns instead of 149
/// at 61 neighbours).
template <bool Periodic, class T, class Rows, class Visit>
MELTSIM_HD void sweep(const core::Frame<T>& w, std::uint64_t i, Rows set, const Visit& visit) {
  if (set.empty()) return;
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = rows_of(w, i);
  const auto see = [&](std::uint32_t j) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    visit(j, xj, d, dot(d, d));
  };
  Rows left = set;
  std::uint32_t r = left.take();
  std::uint64_t bits = 0, next_bits = bits_of(w, i, r);  // the next row is loaded ahead
  std::uint32_t begin = 0, next_begin = rows[r].begin;
  bool more = true;
  for (;;) {
    while (bits == 0u) {
      if (!more) goto crowded;
      bits = next_bits;
      begin = next_begin;
      more = !left.empty();
      if (!more) continue;
      r = left.take();
      next_bits = bits_of(w, i, r);
      next_begin = rows[r].begin;
    }
    const std::uint32_t j = begin + static_cast<std::uint32_t>(lowest_bit(bits));
    bits &= bits - 1u;
    see(j);
  }
crowded:
  while (!set.empty()) {
    const core::Range row = rows[set.take()];
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) {
      const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(w.f.position[j]));
      if (dot(d, d) < w.c.kernel.support2) see(j);
    }
  }
}

/// Whether ask(j) holds for any neighbour of i in these rows.
template <bool Periodic, class T, class Ask>
MELTSIM_HD bool any_neighbour(const core::Frame<T>& w, std::uint64_t i, SomeRows set, const Ask& ask) {
  const core::Range* rows = rows_of(w, i);
  const Vec3<T> xi = xyz(w.f.position[i]);
  while (!set.empty()) {
    const std::uint32_t r = set.take();
    const core::Range row = rows[r];
    for (std::uint64_t bits = bits_of(w, i, r); bits != 0u; bits &= bits - 1u)
      if (ask(row.begin + static_cast<std::uint32_t>(lowest_bit(bits)))) return true;
    for (std::uint32_t j = row.begin + bits_per_row; j < row.end; ++j) {
      const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(w.f.position[j]));
      if (dot(d, d) < w.c.kernel.support2 && ask(j)) return true;
    }
  }
  return false;
}

/// sweep over the rows of one part.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void sweep_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, std::uint32_t parts,
                           const Visit& visit) {
  if (parts == 1u) sweep<Periodic>(w, i, AllRows{0u, w.grid.rows}, visit);
  else sweep<Periodic>(w, i, rows_of_part(w, part, parts), visit);
}

/// visit(j, x_j, x_ij, r2) for every particle j with |x_ij| < H, i itself included (x_ij = 0). Needs the
/// neighbours that the first sweep stored.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void for_each_neighbour(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  sweep<Periodic>(w, i, AllRows{0u, w.grid.rows}, visit);
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
