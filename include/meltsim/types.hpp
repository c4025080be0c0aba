// SPDX-License-Identifier: Apache-2.0
// Value types of the public interface. Everything is SI except temperatures, which are degrees Celsius.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {

using Vec3d = Vec3<double>;
using Vec3f = Vec3<float>;

/// Integer lattice coordinates.
struct Vec3i {
  std::int32_t x = 0, y = 0, z = 0;
};

enum class Backend { automatic, cpu, cuda };
enum class Precision { single_precision, double_precision };

/// How neighbours are found. Every choice finds the same ones; sums are taken in another order, so results
/// differ by rounding. docs/performance.md has their costs.
enum class NeighbourSearch {
  automatic,  ///< grid, whose order of particles has no history
  grid,       ///< cells of size H: counted where the domain is well filled, else occupied ones are sorted
  /// A grid that is kept while no particle moves by half of its skin of 0.1 H: 20 to 40 % of a sub-step less
  /// on a CPU. World::snapshot() makes the next sub-step build it anew, so that the World and a restored one
  /// go on with the same bits; they are other ones than without the snapshot. Where most of the domain is
  /// empty, or nothing bounds it, `grid` it is.
  verlet,
  /// Boxes around leaves of up to 8 particles: the paper's KD-tree, built along a space-filling curve. Knows
  /// no cells, so what is far apart or crowded changes nothing, but slower than the grid wherever measured.
  tree
};

inline constexpr double infinity = std::numeric_limits<double>::infinity();
/// "Not given": the library derives the value and echoes it (World::resolved()).
inline constexpr double automatic = 0.0;
/// The coldest temperature there is [degrees Celsius].
inline constexpr double absolute_zero = -273.15;

/// Axis-aligned box [m].
struct Box {
  Vec3d min, max;
};

}  // namespace v0
}  // namespace meltsim
