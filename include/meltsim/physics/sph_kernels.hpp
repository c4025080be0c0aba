// SPDX-License-Identifier: Apache-2.0
// The smoothing kernel, its gradient and the sign-definite Laplacian weight.
//
// Source: Wendland, H. (1995), Adv. Comput. Math. 4:389, the C2 function in 3D; used for SPH by Dehnen &
// Aly (2012), MNRAS 425:1068, because it does not clump at 65 neighbours. Laplacian: Brookshaw (1985),
// Proc. ASA 6:207; Cleary & Monaghan (1999), J. Comput. Phys. 148:227, eq. (28).
//
//   symbol  meaning                                      unit
//   H       support radius: W(r >= H) = 0                m
//   q       r / H                                        -
//   W       21/(2 pi H^3) (1-q)^4 (1+4q)                 1/m^3
//   grad W  -(210/(pi H^5)) (1-q)^3 x_ij                 1/m^4      x_ij = x_i - x_j
//   L       -2 x_ij.grad W / (r^2 + 0.01 h^2), h = H/2   1/m^5      >= 0 for every pair
//
// Deviation from the paper: it writes nabla^2 W; the true second derivative of the usual kernels changes
// sign and makes every heat scheme unstable, so L replaces nabla^2 W everywhere.
// Lattice correction: each of the three is divided by its discrete gain on the cubic lattice of spacing dx,
// so that the sums over a lattice give exactly the rest density (W), the gradient of a linear field (grad W) and
// the Laplacian of a quadratic field (L). At H = 2.5 dx the gains are 1.013, 0.979 and 0.970; `uncorrected_kernel`
// omits them. The corrected grad W is then 1.035 times the gradient of the corrected W: forces are minus the
// gradient of sum V e(phi) times this constant, so energy is still conserved, and P is the pressure that the
// liquid exerts (with one common correction a tank at rest would read 3 % above rho g h).
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {
/// The kernel: its support and scales.
template <class T>
struct SphKernel {
  T support{};          ///< H [m]
  T inv_support{};      ///< 1/H [1/m]
  T support2{};         ///< H^2 [m^2]
  T w_scale{};          ///< 21/(2 pi H^3), lattice corrected [1/m^3]
  T grad_scale{};       ///< 210/(pi H^5), lattice corrected [1/m^5]
  T laplacian_scale{};  ///< 2 * 210/(pi H^5), lattice corrected [1/m^5]
  T epsilon2{};         ///< 0.01 (H/2)^2, keeps L finite at r = 0 [m^2]
};

/// W(r) / w_scale [-], with a = 1 - q: a^4 (5 - 4a) = (1-q)^4 (1+4q). Sums over many neighbours apply the scale
/// once.
template <class T>
MELTSIM_HD T kernel_shape(const SphKernel<T>& k, T r) {
  const T a = falling(r, k.inv_support);
  const T a2 = a * a;
  return (a2 * a2) * (T(5) - T(4) * a);
}

/// W(r) [1/m^3]; r in [0, H].
template <class T>
MELTSIM_HD T kernel_value(const SphKernel<T>& k, T r) {
  return k.w_scale * kernel_shape(k, r);
}

/// f / grad_scale [-]: (1-q)^3.
template <class T>
MELTSIM_HD T kernel_gradient_shape(const SphKernel<T>& k, T r) {
  const T a = falling(r, k.inv_support);
  return product(a * a, a);
}

/// Factor f >= 0 with grad_i W_ij = -f x_ij [1/m^5].
template <class T>
MELTSIM_HD T kernel_gradient_factor(const SphKernel<T>& k, T r) {
  return k.grad_scale * kernel_gradient_shape(k, r);
}

/// L_ij as a quotient, so that a caller with another divisor divides once.
template <class T>
struct LaplacianQuotient {
  T above, below;  ///< dividend [1/m^3]; divisor [m^2]
};
/// L_ij at distance r, r2 = r^2.
template <class T>
MELTSIM_HD LaplacianQuotient<T> laplacian_quotient(const SphKernel<T>& k, T r, T r2) {
  const T a = falling(r, k.inv_support);
  return {k.laplacian_scale * (a * a * a) * r2, r2 + k.epsilon2};
}

/// L_ij >= 0 [1/m^5]: sum_j V_j L_ij (A_j - A_i) approximates the Laplacian of A.
template <class T>
MELTSIM_HD T kernel_laplacian(const SphKernel<T>& k, T r, T r2) {
  const LaplacianQuotient<T> l = laplacian_quotient(k, r, r2);
  return l.above * (T(1) / l.below);
}

/// The kernel as published: unit integral, no lattice correction.
template <class T>
inline SphKernel<T> uncorrected_kernel(double support) {
  constexpr double pi = 3.14159265358979323846;
  const double h3 = support * support * support;
  SphKernel<T> k;
  k.support = static_cast<T>(support);
  k.inv_support = static_cast<T>(1.0 / support);
  k.support2 = static_cast<T>(support * support);
  k.w_scale = static_cast<T>(21.0 / (2.0 * pi * h3));
  k.grad_scale = static_cast<T>(210.0 / (pi * h3 * support * support));
  k.laplacian_scale = static_cast<T>(420.0 / (pi * h3 * support * support));
  k.epsilon2 = static_cast<T>(0.01 * 0.25 * support * support);
  return k;
}

/// Sum of W dx^3 over the infinite cubic lattice of spacing dx (host, double).
inline double lattice_sum(double support, double spacing) {
  const auto k = uncorrected_kernel<double>(support);
  const int n = static_cast<int>(support / spacing) + 1;
  double sum = 0;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x)
        sum += kernel_value(k, spacing * std::sqrt(double(x * x + y * y + z * z)));
  return sum * spacing * spacing * spacing;
}

/// Sum of V f x^2 over the lattice: the gradient that the discrete sum gives for a field of unit gradient.
inline double lattice_gradient_gain(double support, double spacing) {
  const auto k = uncorrected_kernel<double>(support);
  const int n = static_cast<int>(support / spacing) + 1;
  double sum = 0;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x)
        sum += kernel_gradient_factor(k, spacing * std::sqrt(double(x * x + y * y + z * z))) *
               (spacing * spacing * double(x * x));
  return sum * spacing * spacing * spacing;
}

/// Sum of V L x^2 / 2 over the lattice: the discrete Laplacian of a field whose Laplacian is 1.
inline double lattice_laplacian_gain(double support, double spacing) {
  const auto k = uncorrected_kernel<double>(support);
  const int n = static_cast<int>(support / spacing) + 1;
  double sum = 0;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const double r2 = spacing * spacing * double(x * x + y * y + z * z);
        sum += kernel_laplacian(k, std::sqrt(r2), r2) * spacing * spacing * double(x * x);
      }
  return 0.5 * sum * spacing * spacing * spacing;
}

/// Sum of V L over the lattice [1/m^2]: bounds the rate of heat and viscous exchange.
inline double lattice_laplacian_sum(double support, double spacing) {
  const auto k = uncorrected_kernel<double>(support);
  const int n = static_cast<int>(support / spacing) + 1;
  double sum = 0;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const double r2 = spacing * spacing * double(x * x + y * y + z * z);
        sum += kernel_laplacian(k, std::sqrt(r2), r2);
      }
  return sum * spacing * spacing * spacing / lattice_laplacian_gain(support, spacing);
}

/// Sum of W dx^3 over the lattice layers beyond a plane half a spacing away, with the corrected kernel: what
/// a half-space of wall or solid adds to phi of the first liquid layer.
inline double lattice_half_space(double support, double spacing) {
  const auto k = uncorrected_kernel<double>(support);
  const int n = static_cast<int>(support / spacing) + 1;
  double sum = 0;
  for (int x = -n; x <= -1; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z)
        sum += kernel_value(k, spacing * std::sqrt(double(x * x + y * y + z * z)));
  return sum * spacing * spacing * spacing / lattice_sum(support, spacing);
}

/// The kernel of the simulation: corrected on the lattice of spacing dx (see the head of this file).
template <class T>
inline SphKernel<T> make_kernel(double support, double spacing) {
  const auto u = uncorrected_kernel<double>(support);
  const double s = lattice_sum(support, spacing);
  auto k = uncorrected_kernel<T>(support);
  k.w_scale = static_cast<T>(u.w_scale / s);
  k.grad_scale = static_cast<T>(u.grad_scale / lattice_gradient_gain(support, spacing));
  k.laplacian_scale = static_cast<T>(u.laplacian_scale / lattice_laplacian_gain(support, spacing));
  return k;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
