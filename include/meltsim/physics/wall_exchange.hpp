// SPDX-License-Identifier: Apache-2.0
// What flows through a plane wall by diffusion: momentum (no-slip traction) and heat.
//
// Source: ghost liquid beyond the wall whose value continues the particle's profile through the wall's own
// value, Morris, Fox & Zhu (1997), J. Comput. Phys. 136:214, sec. 3.2, eqs. (35), (36); the sum over ghosts
// is replaced by its integral. A ghost at normal offset s from particle i carries A_i + (A_wall - A_i) s/d,
// so
//   sum_ghosts V L (A_ghost - A_i) = I(d) (A_wall - A_i)/d,   I(d) = integral of L(r) s dV over the outside.
//
//   symbol  meaning                                                     unit
//   d       distance of the particle to the wall                        m
//   L       Laplacian weight of sph_kernels.hpp                         1/m^5
//   a, b    d / H', 1 - a                                               -
//   I       scale [(1-a^2) b^4/4 + (a^2-3) b^5/5 + b^6/2 - b^7/7]        1/m;  scale = pi C H^4 in the
//   continuum V I     wall area that particle i serves                            m^2
//
// so that the force on i is mu V I(d)/d (v_wall - v_i) and the heat into it k V I(d)/d (T_wall - T_i): exact
// for a profile linear across the wall. The bracket is the integral in closed form for L = C (1 - r/H)^3 (the
// 0.01 h^2 under r^2 is dropped: 0.2 % of it).
// Deviation: on a lattice with layers at d_m = (m - 1/2) dx the sum over ghosts is
//   D_m = sum_{k >= m} k dx (sum of V L over lattice plane k),   sum_m dx D_m = 1 by L's normalisation,
// and it falls off faster than the integral. `scale` and the reach H' < H are set so that I meets D_1 and
// D_2: a linear profile on a lattice then has no net force on any layer and the wall feels mu (dv/dn) per
// area exactly (support up to 2.5 dx; 1 % at 4 dx, where D_3 counts).
#pragma once

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

template <class T>
struct WallExchange {
  T support{};            ///< H' [m]: walls further away exchange nothing
  T inv_support{};        ///< 1/H' [1/m]
  T scale{};              ///< [1/m]
  T smallest_distance{};  ///< dx/4 [m]: what is nearer exchanges as if it stood there
};

/// max(d, smallest_distance) [m].
template <class T>
MELTSIM_HD T wall_depth(const WallExchange<T>& e, T distance) {
  return maximum(distance, e.smallest_distance);
}

/// I(d) [1/m]; 0 beyond H'.
template <class T>
MELTSIM_HD T wall_area(const WallExchange<T>& e, T distance) {
  const T a = minimum(wall_depth(e, distance) * e.inv_support, T(1));
  const T b = T(1) - a, a2 = a * a, b2 = b * b;
  const T bracket =
      (T(1) - a2) * T(0.25) + b * ((a2 - T(3)) * T(0.2) + b * (T(0.5) - b * static_cast<T>(1.0 / 7.0)));
  return e.scale * (b2 * b2) * bracket;
}

/// D_m [1/m] of the header comment, m >= 1 (host, double).
inline double lattice_wall_area(double support, double spacing, int layer) {
  const auto k = uncorrected_kernel<double>(support);
  const int n = static_cast<int>(support / spacing) + 1;
  double sum = 0;
  for (int z = layer; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const double r2 = spacing * spacing * double(x * x + y * y + z * z);
        sum += spacing * double(z) * kernel_laplacian(k, std::sqrt(r2), r2);
      }
  return sum * spacing * spacing * spacing / lattice_laplacian_gain(support, spacing);
}

/// Calibrated on the lattice of spacing dx (see the header comment).
template <class T>
inline WallExchange<T> make_wall_exchange(double support, double spacing) {
  const auto make = [&](double reach) {
    WallExchange<double> e;
    e.support = reach;
    e.inv_support = 1.0 / reach;
    e.scale = 1.0;
    e.smallest_distance = 0.25 * spacing;
    return e;
  };
  const double first = lattice_wall_area(support, spacing, 1),
               second = lattice_wall_area(support, spacing, 2);
  const auto second_share = [&](double reach) {
    return wall_area(make(reach), 1.5 * spacing) / wall_area(make(reach), 0.5 * spacing);
  };
  // The share of layer 2 grows with the reach: bisection. No layer 2 on the lattice: its distance is the
  // reach.
  double low = minimum(1.5 * spacing, support), high = support;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (second_share(middle) < second / first ? low : high) = middle;
  }
  WallExchange<double> e = make(high);
  e.scale = first / wall_area(e, 0.5 * spacing);
  WallExchange<T> out;
  out.support = static_cast<T>(e.support);
  out.inv_support = static_cast<T>(e.inv_support);
  out.scale = static_cast<T>(e.scale);
  out.smallest_distance = static_cast<T>(e.smallest_distance);
  return out;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
