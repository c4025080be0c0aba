// SPDX-License-Identifier: Apache-2.0
// Limits of a shape. World reports them before it samples; lattice_points itself returns no points beyond them.
#pragma once

#include <cmath>
#include <string>

#include "meltsim/result.hpp"
#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"

namespace meltsim {
inline namespace v0 {

/// Deeper trees are refused: every walk over them recurses.
inline constexpr int max_shape_depth = 256;
/// Squares and cubes of anything smaller stay finite.
inline constexpr double max_coordinate = 1e30;
/// Site indices stay well inside 32 bits.
inline constexpr double max_site_index = 1e9;
/// One byte each while sampling.
inline constexpr double max_sites = 2147483648.0;

/// Whether the bounds of a shape can be sampled at this spacing.
inline Status check_lattice(const Box& bounds, Vec3d origin, double spacing) {
  const auto refuse = [](std::string message) {
    return Status(Error{ErrorCode::invalid_argument, std::move(message)});
  };
  if (!(spacing > 0) || !std::isfinite(spacing))
    return refuse("spacing is " + number_text(spacing) + " but must be finite and greater than 0");
  if (!finite(origin)) return refuse("the lattice origin must be finite");
  if (inverted(bounds)) return {};
  const Vec3d from = (bounds.min - origin) * (1 / spacing), to = (bounds.max - origin) * (1 / spacing);
  const auto fits = [](double a, double b) { return a > -max_site_index && b < max_site_index; };
  if (!fits(from.x, to.x) || !fits(from.y, to.y) || !fits(from.z, to.z))
    return refuse("the shape lies more than 1e9 spacings from the lattice origin; move it or coarsen it");
  // Two sites beyond the bounds on each axis cover the rounding of the range.
  const Vec3d n = to - from + Vec3d{2, 2, 2};
  if (n.x * n.y * n.z > max_sites)
    return refuse("the bounds of the shape hold about " + number_text(n.x * n.y * n.z) +
                  " lattice sites but at most 2147483648 can be sampled; use a larger spacing");
  return {};
}

}  // namespace v0
}  // namespace meltsim
