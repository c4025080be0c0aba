// SPDX-License-Identifier: Apache-2.0
// How a sphere moves that a steady force, such as its weight, sets in motion from rest in liquid: what the cases of sinking and
// pushed spheres are compared with.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "constants.hpp"

namespace validation {

// Sources: Schiller & Naumann (1933) for the drag; Mei & Adrian (1992), J. Fluid Mech. 237:323, for the history force, which
// is Basset's at first and ends sooner; Oseen (1910; Lamb, Hydrodynamics, 343) for neighbours.
//
//   (s + 1/2) dv/dt = f - 3/4 C_D u^2/D - 18 nu/D^2 int_0^t K(t - t') dv/dt' dt'
//   K(t) = ((4 pi nu t/D^2)^(1/4) + (pi v^3 t^2/(D nu f_H^3))^(1/2))^-2,  f_H = 0.75 + 0.105 Re
//   u = v U/(U - w),  w = F (1/(2 rho U L^2) - sum exp(-U r/(2 nu))/(8 pi mu r))
//
// s: ratio of densities; f: the force per mass of liquid displaced; U: the speed at which drag balances f. Of a sheet of spheres L apart, across the motion,
// each meets liquid that moves against it at w: none flows through the sheet as a whole, and neighbours at r carry some along.

/// A sphere in liquid, and what drives it.
struct SphereMotion {
  double ratio;       ///< s [-]
  double diameter;    ///< D [m]
  double viscosity;   ///< nu [m^2/s]
  double drive;       ///< f [m/s^2]
  double neighbours;  ///< L [m]

  static double drag_coefficient(double reynolds) {
    return 24 / reynolds * (1 + 0.15 * std::pow(reynolds, 0.687));
  }
  /// 3/4 C_D u^2/D [m/s^2].
  double drag(double u) const {
    return u > 0 ? 0.75 * drag_coefficient(u * diameter / viscosity) * u * u / diameter : 0;
  }
  /// U [m/s].
  double balance() const {
    double low = 0, high = drive * diameter * diameter / (18 * viscosity);  // Stokes's
    for (int k = 0; k < 60; ++k) (drag(0.5 * (low + high)) < drive ? low : high) = 0.5 * (low + high);
    return low;
  }
  /// w [m/s].
  double counterflow() const {
    const double force = drive * pi / 6 * diameter * diameter * diameter, speed = balance();  // per density
    double carried = 0;
    for (int i = -3; i <= 3; ++i)
      for (int j = -3; j <= 3; ++j) {
        const double r = std::hypot(i, j) * neighbours;
        if (r > 0) carried += std::exp(-speed * r / (2 * viscosity)) / (8 * pi * viscosity * r);
      }
    return force * (1 / (2 * speed * neighbours * neighbours) - carried);
  }
};

/// Times [s], distances [m] and speeds [m/s] from rest.
struct SpherePath {
  std::vector<double> time, distance, speed;
  /// The time at which it has come this far.
  double when(double d) const {
    const auto k =
        static_cast<std::size_t>(std::lower_bound(distance.begin(), distance.end(), d) - distance.begin());
    if (k == 0 || k == distance.size()) return 0;
    const double part = (d - distance[k - 1]) / (distance[k] - distance[k - 1]);
    return time[k - 1] + part * (time[k] - time[k - 1]);
  }
};

/// Until `end`, in equal steps; twice as many change mean speeds by 0.001 of themselves.
inline SpherePath motion_of(const SphereMotion& m, double end) {
  constexpr std::size_t steps = 3000;
  const double dt = end / steps, nu = m.viscosity, d = m.diameter, balance = m.balance();
  const double slower = balance / (balance - m.counterflow()), history = 18 * nu / (d * d),
               half = 0.75 + 0.105 * balance * d / nu;  // f_H
  // The change of the step itself: K is Basset's, 1/sqrt(4 pi nu t/D^2), whose integral over the step is this.
  const double own = history * 2 * d / std::sqrt(4 * pi * nu * dt) * dt;
  SpherePath path{{0}, {0}, {0}};
  for (std::size_t k = 0; k < steps; ++k) {
    const double v = path.speed[k];
    double past = 0;
    for (std::size_t j = 0; j < k; ++j) {
      const double t = (static_cast<double>(k - j) + 0.5) * dt;
      const double root = std::sqrt(std::sqrt(4 * pi * nu * t / (d * d))) +
                          std::sqrt(pi * v * v * v * t * t / (d * nu * half * half * half));
      past += (path.speed[j + 1] - path.speed[j]) / (root * root);
    }
    const double next = v + dt * (m.drive - m.drag(v * slower) - history * past) / (m.ratio + 0.5 + own);
    path.time.push_back(static_cast<double>(k + 1) * dt);
    path.distance.push_back(path.distance[k] + 0.5 * dt * (v + next));
    path.speed.push_back(next);
  }
  return path;
}

}  // namespace validation
