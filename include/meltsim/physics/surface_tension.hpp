// SPDX-License-Identifier: Apache-2.0
// Surface tension and wetting by forces between pairs of particles.
//
// Sources: Tartakovsky & Panchenko (2016), J. Comput. Phys. 305:1119, pair forces and the tension that they amount to; Kirkwood
// & Buff (1949), J. Chem. Phys. 17:338, the tension of a sharp surface from a pair force; Young and Dupre for angles.
//
//   symbol  meaning                                                        unit
//   a       1 - r/H                                                        -
//   w       b a^5 - a^2, b = 6                                             -
//   S       strength, of two liquids sqrt(S_i S_j)                         N/m^7
//   F       force on i from j, V_i V_j S w(r) x_ij                         N
//   sigma   surface tension, gain (pi/8) S H^6 int_0^1 u^5 (a^2 - b a^5) du  N/m
//   theta   contact angle, through the liquid                              degrees
//
// The force is central and antisymmetric, so momentum and angular momentum are kept to rounding. It attracts beyond
// 0.45 H and repels within; b is half of what would leave the inside of a liquid without stress. The inside is therefore
// under the pressure `cohesion_pressure`, which the Tait equation balances: that compresses the liquid by about 1 % at the
// sound speed below, and readings of pressure contain it. With b = 12 the inside is free of stress, but particles stay on
// a lattice that resists shear: a drop then keeps the shape that it had (docs/design/tried.md).
//
// Deviation: particles are not spread as the formula takes for granted: b and gain hold for H = 2.5 dx, gain being what they
// give in its place, measured once from the shape of puddles, which then are as high as theory has them. Drops at rest
// are a lattice besides, which adds to what restores a small deformation (docs/limits.md).
//
// Wetting. The work that parts a liquid from a solid is sigma (1 + cos theta) by Young and Dupre, and that which parts it
// from itself 2 sigma; so a solid whose particles attract liquid with (1 + cos theta)/2 of its strength has that angle.
// Images in walls: a liquid and its image count one energy, not two, hence 1 + cos theta.
#pragma once

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// b.
inline constexpr double cohesion_core = 6.0;
/// Tension of particles over that of the formula.
inline constexpr double cohesion_gain = 1.25;

/// w(r) [-].
template <class T>
MELTSIM_HD T cohesion_shape(const SphKernel<T>& k, T r) {
  const T a = falling(r, k.inv_support), a2 = a * a;
  return (T(cohesion_core) * (a2 * a) - T(1)) * a2;
}

/// Strength of a pair [N/m^7] from the roots of two liquids' strengths.
template <class T>
MELTSIM_HD T cohesion_of(T root_i, T root_j) {
  return root_i * root_j;
}
/// Strength of a liquid and a solid [N/m^7]; wetting = wetting_share of the solid.
template <class T>
MELTSIM_HD T adhesion_of(T root, T wetting) {
  return root * root * wetting;
}

/// Force on i from j, divided by x_ij and w [N/m]; symmetric.
template <class T>
MELTSIM_HD T cohesion_factor(T volume_i, T volume_j, T strength) {
  return (volume_i * volume_j) * strength;
}

/// S [N/m^7] of a liquid of tension sigma [N/m]; int u^5 (a^2 - b a^5) du = 1/168 - b/2772.
inline double cohesion_strength(double tension, double support) {
  constexpr double pi = 3.14159265358979323846;
  const double h2 = support * support;
  return tension / (cohesion_gain * pi / 8 * h2 * h2 * h2 * (1.0 / 168 - cohesion_core / 2772));
}

/// Pressure [Pa] that the attraction inside a liquid takes from it: the virial of F, (2 pi/3) S H^5 int u^4 (a^2 - b a^5) du.
inline double cohesion_pressure(double tension, double support) {
  constexpr double pi = 3.14159265358979323846;
  const double h2 = support * support;
  return 2 * pi / 3 * cohesion_strength(tension, support) * h2 * h2 * support *
         (1.0 / 105 - cohesion_core / 1260);
}

/// Share of a liquid's strength with which a solid attracts it, (1 + cos theta)/2; twice that holds of a wall's images.
inline double wetting_share(double contact_angle) {
  constexpr double pi = 3.14159265358979323846;
  return 0.5 * (1 + std::cos(contact_angle * (pi / 180)));
}

/// Least sound speed [m/s] of a liquid with tension, 14 sqrt(sigma/(rho dx)): cohesion_pressure then compresses it by about 1 %.
inline double cohesion_sound_speed(double tension, double density, double spacing) {
  return 14 * std::sqrt(tension / (density * spacing));
}

/// Largest sub-step [s] from waves of two spacings' length: sqrt(rho dx^3/(2 pi sigma)) (Brackbill, Kothe & Zemach 1992,
/// J. Comput. Phys. 100:335, eq. 61).
inline double capillary_dt(double tension, double density, double spacing) {
  constexpr double pi = 3.14159265358979323846;
  return std::sqrt(density * spacing * spacing * spacing / (2 * pi * tension));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
