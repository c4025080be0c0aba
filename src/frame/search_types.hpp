// SPDX-License-Identifier: Apache-2.0
// Data structures of the neighbour search: the grid, the tree.
#pragma once

#include <cstdint>

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Cells of the search grid, in stored coordinates.
template <class T>
struct Grid {
  Vec3<T> min{};
  Vec3<T> inv_cell{};  ///< 1/m
  std::int32_t nx = 1, ny = 1, nz = 1;
  std::uint32_t periodic = 0;  ///< bit per axis
  Vec3<T> period{};            ///< 0 where not periodic
  Vec3<T> inv_period{};
  std::int32_t reach = 1;  ///< cells in x that H spans: narrow ones leave fewer candidates out of reach
  std::uint32_t rows = 9;  ///< candidate rows per group: 9, or 18 when x is periodic
  std::int32_t line_cells[9] =
      {};  ///< how many cells away another line of cells along x lies (spatial/cells.hpp)
};

/// Bounding box of a node of the search tree. Empty if low > high.
template <class T>
struct TreeBox {
  Vec3<T> low, high;
};

/// The search tree: leaves in order of a space-filling curve, eight nodes to one of the next level. It is
/// sized for a leaf per particle; how many there are is known on the device only.
template <class T>
struct Tree {
  static constexpr int most_levels = 12;  // 8^11 leaves and more
  Vec3<T> min{};
  T inv_cell{};                           ///< of the curve [1/m]
  std::uint32_t bits = 0;                 ///< of the curve, per axis
  int levels = 0;                         ///< allocated
  std::uint64_t first[most_levels] = {};  ///< node of a level
  T reach{};  ///< boxes farther apart hold no neighbours: H and what is rounded [m]
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
