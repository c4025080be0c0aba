// SPDX-License-Identifier: Apache-2.0
// Surface tension and wetting: a stress in the outermost particles, and a weak attraction and a viscosity among them that
// keep them even.
//
// Sources: Lafaurie, Nardone, Scardovelli, Zaleski & Zanetti (1994), J. Comput. Phys. 113:134, tension as a stress; Hu & Adams
// (2006), J. Comput. Phys. 213:844, in SPH, between two phases; Kirkwood & Buff (1949), J. Chem. Phys. 17:338, the tension that a
// pair force amounts to; Young (1805) for angles; Antonow (1907) for liquids that meet.
//
//   symbol  meaning                                                                      unit
//   g_i     sum_j s_ij V_j grad_i W_ij over liquid, solids and images in walls           1/m
//   s_ij    1; of another liquid min(1, sigma_j/sigma_i)                                 -
//   n       g/|g|, into the liquid                                                       -
//   e       0 at |g| H <= 0.0625, 1 at |g| H >= 0.25, smooth between                     -
//   phi     filled share of space around a particle, no less than 0.5                    -
//   g_w     the same sum over solids and images in walls alone; n_w = g_w/|g_w|          1/m
//   m       direction of the part of g_w across the solids' surfaces                     -
//   cos     cosine of the contact angle, mean over those solids                          -
//   theta   contact angle, through the liquid                                            degrees
//   S_i     [2 a sigma e |g| (I - n n) - 2 b sigma cos |g_w| (I - n_w n_w)]/phi          Pa
//   a, b    tension_gain, wetting_gain                                                      -
//   F       force on i from liquid j, V_i V_j (S_i + S_j) grad_i W_ij                    N
//
// Why it is the tension of a surface without a gas. At a plane surface the integral of rho |d rho/dz| with a smoothed rho is
// 1/2 whatever the layers are like, because W is even: so the factor 2. Pairs carry sum_j V_j f x^2 of S along the surface (x one
// component of x_ij), which is phi there, because kernels sum over planes parallel to a surface as over all space: so the
// divisor. On a lattice both hold within 0.5 % at any support, and e leaves out at most 4 % at H from 1.5 to 6 dx.
// S_i g_i = 0, so that where S is the same for all neighbours the force vanishes for every arrangement of particles: it follows
// differences of S alone although it is antisymmetric, and momentum is exact. Angular momentum is not (F is not along x_ij): a drop that
// relaxes gains 1e-3 of sqrt(sigma R/rho) per mass. e leaves out the inside, where g is the noise of the lattice (0.02/dx; 0.45/dx in
// the outermost layer, 0.04/dx in the second). a and b are below 1 because particles are not a lattice and surfaces not plane: the
// stress acts 0.7 spacings below the surface. They are measured, from pressures, periods, puddles and angles at H = 2.5 dx.
//
// The stress alone does not keep a surface even: particles of the outermost layer drift apart along it and out of it, and a drop
// boils. A pair force on top, V_i V_j s w(r) x_ij (e_i + e_j)/2 with w = c a^5 - a^2, a = 1 - r/H, as strong as 0.075 of the tension,
// holds them. It acts at surfaces alone (e), because inside it would be a pressure (0.06 sigma/dx) and would make of particles a lattice
// that resists. As it is not the gradient of an energy, and neither is the stress, they would keep the outermost particles in
// motion: a viscosity along the line between two of them, 0.5 sqrt(rho sigma dx), takes that up. Beside solids with a stress of
// their own it acts, too, times |cos|.
//
// Wetting. The interface of liquid and solid has the tension -sigma cos theta beside that of solid and gas, which is Young's
// equation, and S has it as a stress of the layer at the solid. Pairs of a liquid particle i and a solid or an image: S_i and S_i
// mirrored in the solid's surface, in place of S_j, so that surfaces pull solids along their normal alone. The pair force between a
// liquid and a solid has (1 + cos theta)/2 of its strength, an image in a wall twice that.
//
// Liquids that meet have the difference of their tensions: each takes the other for as much of itself as the other has of its
// tension. One with tension takes one without for empty.
#pragma once

#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// c, of w.
inline constexpr double cohesion_core = 12.0;
/// Tension of the pair force over that of the liquid.
inline constexpr double cohesion_share = 0.075;
/// Stress of the free surface over that of the formula.
inline constexpr double tension_gain = 0.87;
/// The same of the layer at solids.
inline constexpr double wetting_gain = 0.83;
/// |g| H up to which e is 0.
inline constexpr double surface_from = 0.0625;
/// |g| H from which on e is 1.
inline constexpr double surface_full = 0.25;
/// Least phi that stresses are divided by.
inline constexpr double least_filling = 0.5;
/// Viscosity among particles of a surface over sqrt(rho sigma dx).
inline constexpr double skin_ohnesorge = 0.5;

/// e [-].
template <class T>
MELTSIM_HD T surface_share(const SphKernel<T>& k, T g) {
  const T s = clamp(
      (g * k.support - static_cast<T>(surface_from)) * static_cast<T>(1 / (surface_full - surface_from)),
      T(0), T(1));
  return s * s * (T(3) - T(2) * s);
}

/// S, a symmetric tensor [Pa].
template <class T>
struct SurfaceStress {
  Vec3<T> along{};  ///< xx, yy, zz
  Vec3<T> shear{};  ///< xy, xz, yz

  /// Adds a tension along the plane across v, strength |v| [Pa] (I - v v/v^2); nothing where v is 0.
  MELTSIM_HD void add(T strength, Vec3<T> v) {
    const T square = dot(v, v);
    if (!(square > T(0))) return;
    const T s = strength * std::sqrt(square), q = s / square;
    along += Vec3<T>{s - q * v.x * v.x, s - q * v.y * v.y, s - q * v.z * v.z};
    shear += Vec3<T>{-q * v.x * v.y, -q * v.x * v.z, -q * v.y * v.z};
  }
};
/// Sum.
template <class T>
MELTSIM_HD SurfaceStress<T> operator+(const SurfaceStress<T>& a, const SurfaceStress<T>& b) {
  return {a.along + b.along, a.shear + b.shear};
}
/// S v.
template <class T>
MELTSIM_HD Vec3<T> operator*(const SurfaceStress<T>& s, Vec3<T> v) {
  return {s.along.x * v.x + s.shear.x * v.y + s.shear.y * v.z,
          s.shear.x * v.x + s.along.y * v.y + s.shear.z * v.z,
          s.shear.y * v.x + s.shear.z * v.y + s.along.z * v.z};
}
/// (S + S mirrored in the plane across m) v; m of length 1, or 0, and then 2 S v.
template <class T>
MELTSIM_HD Vec3<T> mirrored_sum(const SurfaceStress<T>& s, Vec3<T> m, Vec3<T> v) {
  const Vec3<T> q = s * m;
  const T across = dot(m, v);
  return (s * v - m * (dot(q, v) - T(2) * dot(m, q) * across) - q * across) * T(2);
}

/// What S is made of, summed over the neighbours of a particle.
template <class T>
struct SurfaceSums {
  Vec3<T> all{};     ///< -g/grad_scale
  Vec3<T> wall{};    ///< -g_w/grad_scale
  Vec3<T> normal{};  ///< its part across the solids' surfaces
  T cover{};         ///< sum of V (1-q)^3 over solids and images
  T wetting{};       ///< the same times cos
  /// A neighbour or an image at x, shape = (1-r/H)^3; share = s_ij, 1 unless both are liquid.
  MELTSIM_HD void add(T volume, T share, T shape, Vec3<T> x) { all += x * (volume * share * shape); }
  /// Beside that, of solids and images: x and its part across the solid's surface; of a solid, whose lattice goes on beyond
  /// the liquid, x. Images end where the liquid does.
  MELTSIM_HD void add_wall(T volume, T cosine, T shape, Vec3<T> x, Vec3<T> across) {
    const T weight = volume * shape;
    wall += x * weight;
    normal += across * weight;
    cover += weight;
    wetting += weight * cosine;
  }
};

/// The power of two above 1/H^4 [1/m^4]: sums of V (1-q)^3 x, which go with the fourth power of the spacing, times this have squares
/// within single precision, whose range they leave at spacings of 0.1 mm. It changes no other bit.
template <class T>
MELTSIM_HD T sum_unit(const SphKernel<T>& k) {
  int exponent = 0;
  std::frexp(k.inv_support, &exponent);
  return std::ldexp(T(1), 4 * exponent);
}
/// |grad_scale v| of such a sum v [1/m].
template <class T>
MELTSIM_HD T gradient_length(const SphKernel<T>& k, Vec3<T> v) {
  const T unit = sum_unit(k);
  return k.grad_scale / unit * length(v * unit);
}

/// e of a liquid particle from its sums [-].
template <class T>
MELTSIM_HD T free_share(const SphKernel<T>& k, const SurfaceSums<T>& sums) {
  return surface_share(k, gradient_length(k, sums.all));
}

/// Share of the skin's viscosity that a liquid particle has [-].
template <class T>
MELTSIM_HD T skin_share(const SphKernel<T>& k, const SurfaceSums<T>& sums) {
  const T free = free_share(k, sums);
  if (!(sums.cover > T(0))) return free;
  return maximum(free,
                 std::fabs(sums.wetting / sums.cover) * surface_share(k, gradient_length(k, sums.wall)));
}

/// S of a liquid particle from its volume fraction phi and its sums.
template <class T>
MELTSIM_HD SurfaceStress<T> surface_stress(const SphKernel<T>& k, T tension, T phi,
                                           const SurfaceSums<T>& sums) {
  SurfaceStress<T> s;
  const T unit = sum_unit(k);
  const T twice = T(2) * tension * (k.grad_scale / unit) / maximum(phi, static_cast<T>(least_filling));
  s.add(twice * static_cast<T>(tension_gain) * free_share(k, sums), sums.all * unit);
  if (sums.cover > T(0))
    s.add(-twice * static_cast<T>(wetting_gain) * (sums.wetting / sums.cover), sums.wall * unit);
  return s;
}

/// m, which solids and walls are in reach; 0 where none is.
template <class T>
MELTSIM_HD Vec3<T> wall_direction(const SphKernel<T>& k, const SurfaceSums<T>& sums) {
  const Vec3<T> normal = sums.normal * sum_unit(k);
  const T l = length(normal);
  return l > T(0) ? normal * (T(1) / l) : Vec3<T>{};
}

/// s_ij [-] from the tensions of two liquids.
template <class T>
MELTSIM_HD T liquid_share(T tension_i, T tension_j) {
  return tension_j < tension_i ? tension_j / tension_i : T(1);
}

/// w(r) [-].
template <class T>
MELTSIM_HD T cohesion_shape(const SphKernel<T>& k, T r) {
  const T a = falling(r, k.inv_support), a2 = a * a;
  return (T(cohesion_core) * (a2 * a) - T(1)) * a2;
}

/// s of a pair of liquids [N/m^7] from those of both and their e.
template <class T>
MELTSIM_HD T cohesion_of(T strength_i, T strength_j, T share_i, T share_j) {
  return minimum(strength_i, strength_j) * (T(0.5) * (share_i + share_j));
}
/// s of a liquid and a solid [N/m^7] from the liquid's and the cosine of the contact angle.
template <class T>
MELTSIM_HD T adhesion_of(T strength, T cosine) {
  return strength * (T(0.5) + T(0.5) * cosine);
}

/// Pair force on i from j, divided by x_ij and w [N/m]; symmetric.
template <class T>
MELTSIM_HD T cohesion_factor(T volume_i, T volume_j, T strength) {
  return (volume_i * volume_j) * strength;
}

/// Viscous force of the skin on i from j, antisymmetric and along x_ij [N]; viscosity that of the pair [Pa s].
template <class T>
MELTSIM_HD Vec3<T> skin_force(const SphKernel<T>& k, T volumes, T viscosity, Vec3<T> x_ij, Vec3<T> v_ij,
                              T r2) {
  const LaplacianQuotient<T> l = laplacian_quotient(k, std::sqrt(r2), r2);
  return x_ij * (-volumes * viscosity * l.above * dot(v_ij, x_ij) / (l.below * l.below));
}
/// Viscosity of the skin of a pair of liquids [Pa s] from those of both and their shares of it.
template <class T>
MELTSIM_HD T skin_viscosity_of(T viscosity_i, T viscosity_j, T share_i, T share_j) {
  return minimum(viscosity_i, viscosity_j) * (T(0.5) * (share_i + share_j));
}
/// Viscosity of the skin of a liquid [Pa s].
inline double skin_viscosity(double tension, double density, double spacing) {
  return skin_ohnesorge * std::sqrt(density * tension * spacing);
}

/// s [N/m^7] of a liquid of tension sigma [N/m]: cohesion_share sigma = (pi/8) s H^6 int_0^1 u^5 (a^2 - c a^5) du, the integral
/// being 1/168 - c/2772.
inline double cohesion_strength(double tension, double support) {
  constexpr double pi = 3.14159265358979323846;
  const double h2 = support * support;
  return cohesion_share * tension / (pi / 8 * h2 * h2 * h2 * (1.0 / 168 - cohesion_core / 2772));
}

/// cos theta of an angle in degrees.
inline double wetting_cosine(double contact_angle) {
  constexpr double pi = 3.14159265358979323846;
  return std::cos(contact_angle * (pi / 180));
}

/// Least sound speed [m/s] of a liquid with tension, 7 sqrt(sigma/(rho dx)): the pressure in a drop of five spacings' radius
/// then compresses it by 0.8 %.
inline double tension_sound_speed(double tension, double density, double spacing) {
  return 7 * std::sqrt(tension / (density * spacing));
}

/// Largest sub-step [s] from waves of two spacings' length: sqrt(rho dx^3/(2 pi sigma)) (Brackbill, Kothe & Zemach 1992,
/// J. Comput. Phys. 100:335, eq. 61).
inline double capillary_dt(double tension, double density, double spacing) {
  constexpr double pi = 3.14159265358979323846;
  return std::sqrt(density * spacing * spacing * spacing / (2 * pi * tension));
}

/// Largest sub-step [s] from waves and from the skin, which acts along the lines between particles alone: a third of a viscosity.
inline double tension_dt(double tension, double density, double spacing, double laplacian_sum) {
  const double skin = skin_viscosity(tension, density, spacing) / 3;
  return std::fmin(capillary_dt(tension, density, spacing),
                   viscous_dt(skin / density, laplacian_sum) / viscous_margin);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
