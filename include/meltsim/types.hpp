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
