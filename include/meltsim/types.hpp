// SPDX-License-Identifier: Apache-2.0
// Value types of the public interface. Everything is SI except temperatures, which are degrees Celsius.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {

using Vec3d = Vec3<double>;  ///< in double, as everything of the interface but bulk data
using Vec3f = Vec3<float>;   ///< in float, for bulk data: frames of particles, meshes

/// Integer lattice coordinates.
struct Vec3i {
  std::int32_t x = 0, y = 0, z = 0;  ///< in spacings, along the axes of the lattice
};

enum class Backend { automatic, cpu, cuda };                  ///< where the steps run
enum class Precision { single_precision, double_precision };  ///< of the state

/// The neighbour search. Every choice finds the same neighbours; the order of sums differs, so results differ
/// by rounding. docs/performance.md has the costs.
enum class NeighbourSearch {
  automatic,  ///< grid, in which the order of particles depends on the state alone
  grid,       ///< cells of size H: counted where the domain is well filled, else occupied cells are sorted
  /// Means `grid`. A grid kept for several sub-steps; it was slower than `grid` in every scene of the record.
  verlet [[deprecated("retired: means `grid`")]],
  /// Boxes around leaves of up to 8 particles: the paper's KD-tree, built along a space-filling curve. Its
  /// cost does not depend on the extent of the scene, but it is slower than the grid wherever measured.
  tree
};

/// A point of a path.
struct PathPoint {
  double time = 0;     ///< [s]
  Vec3d displacement;  ///< [m] from where what moves was built
};

/// What something is at a time.
struct TimedValue {
  double time = 0;   ///< [s]
  double value = 0;  ///< [unit of the quantity]
};

/// A point of the path of a body.
struct PosePoint {
  double time = 0;     ///< [s]
  Vec3d displacement;  ///< [m] of its pivot from where the body was built
  double angle = 0;    ///< [rad] by which it has turned about its SolidDesc::path_axis; may be many turns
};

/// How the viscosity of liquids enters a sub-step.
enum class Viscosity {
  automatic,  ///< implicit where it would limit the sub-step more than anything else does, else explicit
  explicit_,  ///< one force per sub-step: the sub-step is at most viscous_dt of physics/integrate.hpp
  /// Velocity diffuses in Runge-Kutta-Legendre stages: viscosity does not limit the sub-step, whose cost grows as the square
  /// root of the viscosity instead (physics/viscous_diffusion.hpp).
  implicit
};

inline constexpr double infinity = std::numeric_limits<double>::infinity();  ///< "no limit"
/// "Not given": the library derives the value and reports it (World::resolved()).
inline constexpr double automatic = 0.0;
/// Absolute zero [degrees Celsius].
inline constexpr double absolute_zero = -273.15;

/// Axis-aligned box [m].
struct Box {
  Vec3d min, max;  ///< lower and upper corner [m]
};

}  // namespace v0
}  // namespace meltsim
