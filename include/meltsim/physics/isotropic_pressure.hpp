// SPDX-License-Identifier: Apache-2.0
// Isotropic pressure: takes out of the pressure forces what the arrangement of the particles adds to them.
//
// Sources: Bonet & Lok (1999), Comput. Methods Appl. Mech. Eng. 180:97, and Oger, Doring, Alessandrini & Ferrant (2007), J.
// Comput. Phys. 225:1472, for corrected gradients in momentum equations; Kirkwood & Buff (1949), J. Chem. Phys. 17:338, for the
// stress that pair forces amount to.
//
//   symbol  meaning                                                                unit
//   A_i     sum_j V_j f_ij x_ij x_ij^T over liquid, solids and images in walls      -      (grad_i W_ij = -f_ij x_ij)
//   D_i     1 - A_i/(tr A_i/3): how far the surroundings are from being isotropic    -
//   s       1 where |D_i| <= 0.2, 0 from 0.4 on and where P_i < 0                   -
//   S_i     s (P_i/phi_i^2) D_i                                                     Pa
//   F       force on i from j, V_i V_j (S_i + S_j) f_ij x_ij                        N
//
// Why. The pressure forces of fluid.hpp are minus the gradient of an energy that is a function of phi, so the stress that particle
// i carries is (P_i/phi_i^2) A_i. Where a flow shears the particles, A_i is no multiple of the unit matrix, and liquid
// resists shear with a stress in proportion to its pressure: the level of pressure acts as a viscosity. F adds (P_i/phi_i^2)
// times what A_i lacks, to first order in D_i, so that the stress is isotropic whatever the arrangement is.
//
// The forces are antisymmetric, so that momentum is exact. They are not along x_ij, so that angular momentum is not, and not the gradient
// of an energy: particles that jitter gain from them what artificial viscosity must take away again (least_artificial_viscosity).
// Liquid that pulls is left to particle shifting (shifting.hpp): s is 0 where P_i < 0.
// At surfaces, where neighbours are missing, D_i is large and s is 0: pressure there is small, and the forces are those of fluid.hpp.
// Bodies carry no S of their own; their forces are the negatives of what they give the liquid.
// Deviations: the papers invert A_i, and scale the force to the gradient of a linear field; here the trace is left as it is, so that
// phi alone says how strong the pressure is.
#pragma once

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// |D| up to which S is whole [-].
inline constexpr double anisotropy_whole = 0.2;
/// Least artificial viscosity (Monaghan's alpha) beside isotropic pressure [-]: below, liquid gains motion.
inline constexpr double least_artificial_viscosity = 0.01;

/// A v, a symmetric matrix times a vector.
template <class T>
MELTSIM_HD Vec3<T> times(const Sym3<T>& A, Vec3<T> v) {
  return {A.diagonal.x * v.x + A.mixed.z * v.y + A.mixed.y * v.z,
          A.mixed.z * v.x + A.diagonal.y * v.y + A.mixed.x * v.z,
          A.mixed.y * v.x + A.mixed.x * v.y + A.diagonal.z * v.z};
}

/// S [Pa] from A, or a multiple of it, and the pressure term P/phi^2 [Pa].
template <class T>
MELTSIM_HD Sym3<T> isotropic_stress(const Sym3<T>& A, T term) {
  const T third = (A.diagonal.x + A.diagonal.y + A.diagonal.z) * T(1.0 / 3.0);
  if (!(third > T(0))) return {};
  const T inverse = T(1) / third;
  const Vec3<T> d = Vec3<T>{T(1), T(1), T(1)} - A.diagonal * inverse, m = A.mixed * -inverse;
  const T size = std::sqrt(dot(d, d) + T(2) * dot(m, m));
  const T s = maximum(term, T(0)) * clamp(T(2) - size * static_cast<T>(1 / anisotropy_whole), T(0), T(1));
  return {d * s, m * s};
}

/// S_i + S_j.
template <class T>
MELTSIM_HD Sym3<T> sum_of(const Sym3<T>& a, const Sym3<T>& b) {
  return {a.diagonal + b.diagonal, a.mixed + b.mixed};
}

/// S mirrored in the planes of `mask` (bit a: across axis a).
template <class T>
MELTSIM_HD Sym3<T> mirrored_in(const Sym3<T>& S, std::uint32_t mask) {
  const T x = (mask & 1u) != 0u ? T(-1) : T(1), y = (mask & 2u) != 0u ? T(-1) : T(1),
          z = (mask & 4u) != 0u ? T(-1) : T(1);
  return {S.diagonal, {S.mixed.x * (y * z), S.mixed.y * (z * x), S.mixed.z * (x * y)}};
}

/// F [N] on i from j; stress = S_i + S_j, volumes = V_i V_j, f = kernel_gradient_factor.
template <class T>
MELTSIM_HD Vec3<T> isotropic_force(const Sym3<T>& stress, T volumes, T f, Vec3<T> x_ij) {
  return times(stress, x_ij) * (volumes * f);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
