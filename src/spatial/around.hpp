// SPDX-License-Identifier: Apache-2.0
// Particles around any point: the candidates that the search in use holds there, whichever it is. Order is fixed: rows
// ascending, slots ascending.
#pragma once

#include "spatial/tree_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Cell of a point; points outside the domain count to a border cell.
template <class T>
MELTSIM_HD CellPlace place_at(const core::Grid<T>& g, Vec3<T> x) {
  return {cell_coordinate(x.x, g.min.x, g.inv_cell.x, g.nx, (g.periodic & 1u) != 0u),
          cell_coordinate(x.y, g.min.y, g.inv_cell.y, g.ny, (g.periodic & 2u) != 0u),
          cell_coordinate(x.z, g.min.z, g.inv_cell.z, g.nz, (g.periodic & 4u) != 0u)};
}

/// Row r of candidates around a cell.
template <class T>
MELTSIM_HD Range row_around(const Frame<T>& w, const CellPlace& at, std::uint32_t r) {
  if (w.cells != 0u) {
    const auto row = cell_row<std::uint32_t>(w.grid, at, r);
    if (row.cells == 0u) return {};
    return {w.f.cell_begin[row.first], w.f.cell_begin[row.first + row.cells]};
  }
  const auto row = cell_row<std::uint64_t>(w.grid, at, r);
  if (row.cells == 0u) return {};
  if (w.probes.keys != nullptr)  // every particle has a key: World::sample
    return {first_not_below(w.probes.keys, w.probes.sorted, row.first),
            first_not_below(w.probes.keys, w.probes.sorted, row.first + row.cells)};
  const std::uint32_t groups = w.f.status->groups;
  return {w.f.group_begin[first_not_below(w.f.group_key, groups, row.first)],
          w.f.group_begin[first_not_below(w.f.group_key, groups, row.first + row.cells)]};
}

/// Every parts-th candidate of all ranges put one behind the other, from the k-th on.
struct EveryNth {
  std::uint32_t skip, parts;
};

/// visit(slot, x_j, x - x_j, r2) for those of the particles in this range of slots that are within H of x.
template <class T, class Visit>
MELTSIM_HD void visit_range(const Frame<T>& w, Vec3<T> x, Range range, EveryNth& nth, const Visit& visit) {
  const auto slot_of = [&w](std::uint32_t k) { return w.probes.slots != nullptr ? w.probes.slots[k] : k; };
  std::uint32_t k = range.begin + nth.skip;
  // Four at a time: their loads are under way together.
  for (; k < range.end; k += 4u * nth.parts) {
    std::uint32_t slot[4];
    Vec4<T> xj[4];
    for (std::uint32_t u = 0; u < 4u; ++u) slot[u] = slot_of(minimum(k + u * nth.parts, range.end - 1u));
    for (std::uint32_t u = 0; u < 4u; ++u) xj[u] = w.f.position[slot[u]];
    for (std::uint32_t u = 0; u < 4u && k + u * nth.parts < range.end; ++u) {
      const Vec3<T> d = separation(w.grid, x, xyz(xj[u]));
      const T r2 = dot(d, d);
      if (r2 < w.c.kernel.support2) visit(slot[u], xj[u], d, r2);
    }
  }
  const std::uint32_t passed =
      range.end - range.begin;  // now as many candidates less to skip, or the next one of mine
  nth.skip = (nth.skip + nth.parts - passed % nth.parts) % nth.parts;
}

/// The same for the leaves within H of x.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void visit_leaves(const Frame<T>& w, Vec3<T> x, EveryNth nth, const Visit& visit) {
  const std::uint64_t groups = w.f.status->groups;
  if (groups == 0u) return;
  const core::TreeBox<T> here{x, x};
  std::uint32_t first[core::Tree<T>::most_levels], left[core::Tree<T>::most_levels];
  int top = 0;
  while (nodes_of(groups, top) > 1u) ++top;
  int level = top;
  first[top] = 0u;
  left[top] = 1u;
  for (;;) {
    if (left[level] == 0u) {
      if (level == top) return;
      ++level;
      continue;
    }
    const std::uint32_t node = first[level] + static_cast<std::uint32_t>(lowest_bit(left[level]));
    left[level] &= left[level] - 1u;
    if (level == 0) {
      visit_range(w, x, {w.f.group_begin[node], w.f.group_begin[node + 1u]}, nth, visit);
    } else {
      --level;
      first[level] = 8u * node;
      left[level] = brothers_within_reach<Periodic>(w, here, groups, level, first[level]);
    }
  }
}

/// visit(slot, x_j, x - x_j, r2) for part k of the particles within H of a point x. Tree: the search is a tree.
template <bool Tree, class T, class Visit>
MELTSIM_HD void for_each_around(const Frame<T>& w, Vec3<T> x, std::uint32_t k, std::uint32_t parts,
                                const Visit& visit) {
  EveryNth nth{k, parts};
  if constexpr (Tree) {
    if (w.grid.periodic != 0u) visit_leaves<true>(w, x, nth, visit);
    else visit_leaves<false>(w, x, nth, visit);
  } else {
    const CellPlace at = place_at(w.grid, x);
    for (std::uint32_t r = 0; r < w.grid.rows; ++r) visit_range(w, x, row_around(w, at, r), nth, visit);
  }
}

/// stage(std::true_type) where the search is a tree, else stage(std::false_type): picks what is compiled.
template <class T, class Stage>
void with_tree(const Frame<T>& w, const Stage& stage) {
  if (w.tree.levels != 0) stage(std::true_type{});
  else stage(std::false_type{});
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
