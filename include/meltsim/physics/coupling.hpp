// SPDX-License-Identifier: Apache-2.0
// Liquid and solid push on each other.
//
// Sources: Shao & Yu (2017), eqs. (1)-(3); Akinci et al. (2012), ACM Trans. Graph. 31(4):62, eqs. (4)-(9),
// for contributions relative to a solid particle's own volume.
//
//   S_i     sum_k V_k W_ik, the solid's share of the surroundings          -
//   phi_i   sum_j V0_j W_ij + s(S_i) + wall                                -
//   F_i<-k  V0_i V_k s'(S_i) P_i/phi_i^2 f x_ik + viscous terms            N;  F_k<-i = -F_i<-k, same
//   function
//
// Volume of a solid particle: V_k = 1/sum_l W_kl over every solid particle within H (the set that liquid
// later meets as neighbours), recomputed every step: 1 dx^3 inside, 1.25 on a face, 1.56 on an edge, 1.95 at
// a corner (Wendland C2, H = 2.5 dx), so that S of the liquid's first layer hardly depends on the body's
// shape: 0.249 on a face, 0.239 on an edge, 0.228 at a corner.
//
// Deviation: the paper has s(S) = S. Then the first layer at its proper distance reads 1.049 rho0, and, more
// important, the one-sided sum carries only half of the pressure on the surface. s(S) = lambda (S/S*)^(5/2)
// instead, with S* the sum on a flat face and lambda the lattice's share there: the first layer reads 1.000
// and its pressure acts 2.5-fold (walls.hpp gives the calibration). Written into phi the force remains minus
// the gradient of an energy; doubling the force alone feeds energy into every liquid that touches a solid
// (measured: rms speed grows to 1 m/s in a tank at rest). From 1.2 S* on it rises like the paper's, so that a
// particle that melts in a pit of the surface (S up to 3.4 S*) reads 1.06 rho0 there and not 1.6, an
// explosion.
#pragma once

#include "meltsim/physics/contact.hpp"
#include "meltsim/physics/fluid.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// V_k [m^3] from sum_l W_kl (itself included) and the lattice volume m/rho_s. Not above twice that, what a
/// corner has: the last crumbs of a body would otherwise push like 4.7 times their volume and fly off.
template <class T>
MELTSIM_HD T solid_volume(T kernel_sum, T lattice_volume) {
  return minimum(T(1) / kernel_sum, T(2) * lattice_volume);
}

/// What s(S) is calibrated by; made by make_coupling.
template <class T>
struct CouplingShare {
  T face_sum{};    ///< S*
  T face_share{};  ///< lambda
};

/// Where the steep part of s ends, in units of S*.
inline constexpr double share_knee = 1.2;

/// s(S): the solid's contribution to phi; x = S/S*.
template <class T>
MELTSIM_HD T solid_share(const CouplingShare<T>& c, T sum) {
  const T x = sum / c.face_sum;
  if (x < T(1)) return c.face_share * (x * x * std::sqrt(x));
  return c.face_share * (x + T(1.5) * (minimum(x, T(share_knee)) - T(1)));
}

/// s'(S) [-].
template <class T>
MELTSIM_HD T solid_share_slope(const CouplingShare<T>& c, T sum) {
  const T x = sum / c.face_sum;
  if (x >= T(share_knee)) return c.face_share / c.face_sum;
  const T y = minimum(x, T(1));
  return T(2.5) * (c.face_share / c.face_sum) * y * std::sqrt(y);
}

/// Everything one liquid-solid pair needs. i is the liquid, k the solid, whoever asks.
template <class T>
struct CouplingPair {
  T fluid_volume, solid_volume;  ///< V0_i, V_k [m^3]
  T fluid_term;                  ///< s'(S_i) P_i / phi_i^2 [Pa]
  T viscosity;                   ///< mu_i [Pa s]
  T fluid_density;               ///< rho0_i [kg/m^3]
  Vec3<T> x_ik;                  ///< x_i - x_k [m]
  Vec3<T> v_ik;                  ///< v_i - v_k [m/s]
};

/// Force on the liquid particle [N]; the solid particle receives exactly the negative.
template <class T>
MELTSIM_HD Vec3<T> coupling_force(const SphKernel<T>& k, T alpha, T sound_speed, const CouplingPair<T>& p,
                                  T r2) {
  const T r = std::sqrt(r2);
  const T f = kernel_gradient_factor(k, r);
  Vec3<T> force = pressure_force(p.fluid_volume, p.solid_volume, p.fluid_term, T(0), f, p.x_ik);
  force += viscous_force(p.viscosity, p.fluid_volume, p.solid_volume, kernel_laplacian(k, r, r2), -p.v_ik);
  force += artificial_viscous_force(k, alpha, sound_speed, p.fluid_density, p.fluid_volume, p.solid_volume, f,
                                    r2, dot(p.v_ik, p.x_ik), p.x_ik);
  return force;
}

/// Liquid this close to a solid particle, in spacings, is about to slip between lattice sites (0.71 is the
/// middle of four); its first layer stands at 0.9..1.1.
inline constexpr double leak_distance = 0.8;

/// Last resort against leaking through thin solids: the contact spring of contact.hpp on the liquid particle
/// [N], without friction; the solid receives the negative. It stops 0.07 dx/dt normal to a single layer.
/// x_ik, v_ik as in CouplingPair.
template <class T>
MELTSIM_HD Vec3<T> leak_force(T spacing, T dt, T fluid_mass, T solid_mass, Vec3<T> x_ik, Vec3<T> v_ik, T r2) {
  const T r = std::sqrt(r2);
  if (!(r > T(0))) return {};
  return contact_force(T(leak_distance) * spacing - r, x_ik * (T(1) / r), v_ik,
                       reduced_mass(fluid_mass, solid_mass), T(0), dt);
}

/// S* and lambda on the lattice (host, double).
template <class T>
inline CouplingShare<T> make_coupling(double support, double spacing) {
  const auto k = make_kernel<double>(support, spacing);
  const int n = static_cast<int>(support / spacing) + 1;
  const double cell = spacing * spacing * spacing;
  // Sum of W dx^3 over one lattice plane at height h, and of a half-space below a vertex.
  const auto plane = [&](int h) {
    double sum = 0;
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x)
        sum += kernel_value(k, spacing * std::sqrt(double(x * x + y * y + h * h)));
    return sum * cell;
  };
  double sum = 0;
  for (int layer = 0; layer < n; ++layer) {  // layer 0 is the face; the liquid stands one spacing above it
    double own = 0;
    for (int other = 0; other <= layer + n; ++other) own += plane(other - layer);
    sum += plane(layer + 1) / own;
  }
  return {static_cast<T>(sum), static_cast<T>(lattice_half_space(support, spacing))};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
