// SPDX-License-Identifier: Apache-2.0
// References for drops that rest on a plane.
#pragma once

#include <cmath>

#include "constants.hpp"

namespace validation {

/// Angle of a cap of this volume from the height of its centre of mass [degrees].
inline double cap_angle(double volume, double centre) {
  double best = 0, error = 1e300;
  for (double angle = 5; angle < 178; angle += 0.1) {
    const double c = std::cos(angle * pi / 180);
    const double radius = std::cbrt(3 * volume / (pi * (2 + c) * (1 - c) * (1 - c)));
    const double height = radius * (1 - c), top = 2 * radius - height;
    const double at = 3 * top * top / (4 * (3 * radius - height)) - radius * c;
    if (std::abs(at - centre) < error) error = std::abs(at - centre), best = angle;
  }
  return best;
}

/// Centre of mass of a sessile drop of this volume: Bashforth and Adams' equation, in steps of 0.005 spacings.
inline double sessile(double spacing, double volume, double capillary, double angle) {
  double low = 0.5 * spacing, high = 5000 * spacing, centre = 0;
  for (int turn = 0; turn < 40; ++turn) {
    const double top = std::sqrt(low * high), step = 0.005 * spacing;
    double x = 0, z = 0, slope = 0, sum = 0, moment = 0;
    while (slope < angle * pi / 180 && z < 60 * spacing) {
      const double bend = 2 / top + z / (capillary * capillary) - (x > 0 ? std::sin(slope) / x : 1 / top);
      const double next = x + std::cos(slope) * step, below = z + std::sin(slope) * step;
      const double disc = pi * 0.25 * (x + next) * (x + next) * (below - z);
      sum += disc;
      moment += disc * 0.5 * (z + below);
      x = next;
      z = below;
      slope += bend * step;
    }
    centre = z - moment / sum;
    (sum < volume ? low : high) = top;
  }
  return centre;
}

/// Angle at which a drop of this volume has its centre of mass so high [degrees].
inline double sessile_angle(double spacing, double volume, double capillary, double centre) {
  double low = 5, high = 175;
  for (int turn = 0; turn < 14; ++turn) {
    const double angle = 0.5 * (low + high);
    (sessile(spacing, volume, capillary, angle) < centre ? low : high) = angle;
  }
  return 0.5 * (low + high);
}

}  // namespace validation
