// SPDX-License-Identifier: Apache-2.0
// Exchange with a plane wall: momentum (no slip) and heat.
//
// Source: ghost particles that continue a linear profile beyond the wall, Morris, Fox & Zhu (1997), J.
// Comput. Phys. 136:214, sec. 2.5, here summed in closed form for the Wendland kernel.
//
//   d     distance of the particle from the wall                                     m
//   s     distance, along the normal, of a ghost from the particle                   m
//   I(d)  integral of L(r) s over the outside, s > d                                 1/m
//   V I   wall area that a particle of volume V represents                           m^2
//
// A ghost at s carries A_wall + (A_wall - A_i)(s - d)/d, so that sum_j V L (A_j - A_i) over the ghosts is
// I(d)/d (A_wall - A_i): exact for a linear profile, and one function of d. With a = d/H, b = 1 - a and
// L = C (1 - r/H)^3:  I = C pi H^4 [(1-a^2) b^4/4 + (a^2-3) b^5/5 + b^6/2 - b^7/7].
// Lattice correction: I is taken at dx/2 + stretch (d - dx/2) and scaled, so that the first two layers (d =
// dx/2, 3 dx/2) get the sums over the missing lattice layers; those sums add up to dx^2 of wall per column.
#pragma once

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {
/// Constants of the exchange.
template <class T>
struct WallExchange {
  T support{}, inv_support{};   ///< H [m]; 1/H [1/m]
  T half_spacing{}, stretch{};  ///< dx/2 [m]; stretch [-]
  T scale{};                    ///< C pi H^4, lattice corrected [1/m]
  T smallest_distance{};        ///< at smaller distances the exchange is that at this one [m]
};

/// I(d) [1/m]: times the volume of the particle, the wall area that it represents [m^2]; 0 beyond H.
template <class T>
MELTSIM_HD T wall_area(const WallExchange<T>& e, T distance) {
  const T stretched = e.half_spacing + e.stretch * (distance - e.half_spacing);
  const T a = clamp(stretched * e.inv_support, T(0), T(1)), b = T(1) - a, a2 = a * a, b2 = b * b;
  return e.scale * (b2 * b2) *
         ((T(1) - a2) * T(0.25) + b * ((a2 - T(3)) * T(0.2) + b * (T(0.5) - b * T(1.0 / 7.0))));
}

/// d, but not less than smallest_distance [m].
template <class T>
MELTSIM_HD T wall_depth(const WallExchange<T>& e, T distance) {
  return maximum(distance, e.smallest_distance);
}

/// Makes the constants for H = support on a lattice of spacing dx (host).
template <class T>
inline WallExchange<T> make_wall_exchange(double support, double spacing) {
  const auto k = make_kernel<double>(support, spacing);
  const int n = static_cast<int>(support / spacing) + 1;
  double missing[2] = {};  // sums over the lattice layers beyond a wall dx/2 and 3 dx/2 away of V L s
  for (int x = 1; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const double r2 = spacing * spacing * double(x * x + y * y + z * z);
        const double term =
            kernel_laplacian(k, std::sqrt(r2), r2) * x * spacing * (spacing * spacing * spacing);
        missing[0] += term;
        if (x > 1) missing[1] += term;
      }
  WallExchange<double> e{support, 1.0 / support, 0.5 * spacing, 1.0, 1.0, 0.25 * spacing};
  double low = 1.0, high = support / spacing;  // the second layer's share falls as the stretch grows
  for (int step = 0; step < 60; ++step) {
    e.stretch = 0.5 * (low + high);
    const double share = wall_area(e, 1.5 * spacing) / wall_area(e, 0.5 * spacing);
    (share > missing[1] / missing[0] ? low : high) = e.stretch;
  }
  e.scale = missing[0] / wall_area(e, 0.5 * spacing);
  return {static_cast<T>(e.support), static_cast<T>(e.inv_support), static_cast<T>(e.half_spacing),
          static_cast<T>(e.stretch), static_cast<T>(e.scale),       static_cast<T>(e.smallest_distance)};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
