// SPDX-License-Identifier: Apache-2.0
// How much of a particle lies below the level of a liquid, and where that level is in a column of it.
//
// A particle is treated as a slab, one spacing high, around its height. The level of a column follows from the volume
// of liquid above a height within the liquid, so it does not depend on single particles.
//
//   symbol  meaning                                                      unit
//   h       height of a particle's centre, against gravity               m
//   dx      spacing                                                      m
//   b       base of the column: two spacings below its topmost           m
//           particle, and not below the floor
//   V, A    volume of liquid above b in the column; area of the column   m^3, m^2
//   l       level: b + V / A                                             m
//
// Deviation: within two spacings of the surface the liquid counts at its rest density; there it is compressed by the
// weight of two spacings of liquid.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Share of a particle above a height [-].
MELTSIM_HD double share_above(double h, double height, double dx) {
  return clamp((h - height) / dx + 0.5, 0.0, 1.0);
}

/// Share of a particle below a height [-].
MELTSIM_HD double share_below(double h, double height, double dx) { return share_above(height, h, dx); }

/// b [m].
MELTSIM_HD double column_base(double top, double floor, double dx) { return maximum(top - 2 * dx, floor); }

/// l [m].
MELTSIM_HD double column_level(double base, double volume, double area) { return base + volume / area; }

/// Share of a column that is liquid between its base and the top of its topmost particle [-]: 1 in standing liquid, much
/// less in spray.
MELTSIM_HD double column_fill(double top, double base, double volume, double area, double dx) {
  return volume / (area * (top + 0.5 * dx - base));
}

/// Columns filled less than this have no level.
inline constexpr double least_fill = 0.5;

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
