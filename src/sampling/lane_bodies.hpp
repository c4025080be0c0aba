// SPDX-License-Identifier: Apache-2.0
// Averages of fields at points, for a CPU.
#pragma once

#include "exec/wide.hpp"
#include "sampling/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

/// Averages at one point where candidates lie in rows of cells: their distances and weights are vector loops, and no branch
/// asks who is near, as a processor cannot guess it. Particles are added up in the order of PointBody, to the same bits.
template <class T>
struct PointInLanesBody {
  static constexpr bool wide = true;
  Frame<T> w;
  using Sum = physics::SampleSums;
  void operator()(std::uint64_t i) const {
    const core::ProbePoint<T> point = w.probes.points[i];
    if (!is_due(w, point.probe)) return;
    Sum sum;
    const spatial::CellPlace at = spatial::place_at(w.grid, point.x);
    for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
      const core::Range row = spatial::row_around(w, at, r);
      for (std::uint32_t first = row.begin; first < row.end; first += most)
        add(point, first, minimum(row.end - first, most), sum);
    }
    finish_point(w, i, sum);
  }

 private:
  static constexpr std::uint32_t most = 64;  // candidates at a time
  void add(const core::ProbePoint<T>& point, std::uint32_t first, std::uint32_t n, Sum& sum) const {
    T squares[most], weights[most];
    std::uint32_t slots[most], found = 0;
    if (w.grid.periodic != 0u) measure<true>(point.x, first, n, squares);
    else measure<false>(point.x, first, n, squares);
    for (std::uint32_t k = 0; k < n; ++k) {
      slots[found] = first + k;
      weights[found] = squares[k];
      found += squares[k] < w.c.kernel.support2 ? 1u : 0u;
    }
    const physics::SphKernel<T> kernel = w.c.kernel;
    MELTSIM_SIDE_BY_SIDE
    for (std::uint32_t k = 0; k < found; ++k)
      weights[k] = physics::kernel_shape(kernel, std::sqrt(weights[k]));
    const std::uint32_t fields = w.probes.rows[point.probe].fields;
    for (std::uint32_t k = 0; k < found; ++k) {
      const std::uint32_t tag = w.f.tag[slots[k]];
      if (is_removed(tag)) continue;
      sum.add(static_cast<double>(weights[k]),
              particle_at(w, slots[k], tag, w.f.position[slots[k]].w, fields));
    }
  }
  template <bool Periodic>
  void measure(Vec3<T> x, std::uint32_t first, std::uint32_t n, T* squares) const {
    const core::Grid<T> grid = w.grid;
    const Vec4<T>* const from = w.f.position + first;
    MELTSIM_SIDE_BY_SIDE
    for (std::uint32_t k = 0; k < n; ++k) {
      const Vec3<T> d = spatial::separation<Periodic>(grid, x, xyz(from[k]));
      squares[k] = dot(d, d);
    }
  }
};

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
