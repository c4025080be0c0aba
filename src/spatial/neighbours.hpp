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

/// visit(j, x_j, x_ij, r2) for every particle j with |x_ij| < H, i itself included (x_ij = 0). Needs the
/// stage spatial.neighbours.
template <class T, class Visit>
MELTSIM_HD void for_each_neighbour(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = w.f.group_ranges + static_cast<std::uint64_t>(w.f.group_of[i]) * w.grid.rows;
  const std::uint64_t* row_bits = w.f.neighbour_bits + i * w.grid.rows;
  for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
    const core::Range row = rows[r];
    for (std::uint64_t bits = row_bits[r]; bits != 0u; bits &= bits - 1u) {
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
}

/// The same in exactly the reverse order (the paper's second heat sweep).
template <class T, class Visit>
MELTSIM_HD void for_each_neighbour_reversed(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Range* rows = w.f.group_ranges + static_cast<std::uint64_t>(w.f.group_of[i]) * w.grid.rows;
  const std::uint64_t* row_bits = w.f.neighbour_bits + i * w.grid.rows;
  for (std::uint32_t r = w.grid.rows; r-- > 0;) {
    const core::Range row = rows[r];
    for (std::uint32_t j = row.end; j > row.begin + bits_per_row;) {
      const Vec4<T> xj = w.f.position[--j];
      const Vec3<T> d = separation(w.grid, xi, xyz(xj));
      const T r2 = dot(d, d);
      if (r2 < w.c.kernel.support2) visit(j, xj, d, r2);
    }
    for (std::uint64_t bits = row_bits[r]; bits != 0u;) {
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
