// SPDX-License-Identifier: Apache-2.0
// Cells of one spacing that particles lie in, as keys that sort.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "scene.hpp"

namespace runner {

using Cell = std::array<std::int64_t, 3>;

/// The cell around a lattice site of a scene: sites lie in the middle of cells.
inline Cell cell_of(const Scene& scene, const meltsim::Vec3d& x) {
  const meltsim::Vec3d origin = scene.world.domain.bounded ? scene.world.domain.min : meltsim::Vec3d{};
  const double dx = scene.world.spacing;
  const auto index = [dx](double from) { return static_cast<std::int64_t>(std::floor(from / dx)); };
  return {index(x.x - origin.x), index(x.y - origin.y), index(x.z - origin.z)};
}

/// 21 bits for each axis, as many as the library has cells.
inline std::uint64_t key_of(const Cell& cell) {
  std::uint64_t key = 0;
  for (const std::int64_t index : cell)
    key = key << 21 | (static_cast<std::uint64_t>(index + (1 << 20)) & 0x1fffff);
  return key;
}

inline bool holds(const std::vector<std::uint64_t>& sorted, const Cell& cell) {
  return std::binary_search(sorted.begin(), sorted.end(), key_of(cell));
}

}  // namespace runner
