// SPDX-License-Identifier: Apache-2.0
// The weakly compressible liquid: volume fraction, Tait equation, pressure, viscosity.
//
// Sources: Shao & Yu (2017), J. Syst. Simul. 29(3):502, eqs. (1)-(3); Becker & Teschner (2007), SCA, for
// the Tait equation; Solenthaler & Pajarola (2008), SCA, for densities that do not smear between liquids;
// Price (2012), J. Comput. Phys. 231:759, sec. 3, for deriving the force from the density estimate.
//
//   symbol  meaning                                                        unit
//   V0      rest volume m/rho0                                             m^3
//   phi     volume fraction sum_j V0_j W_ij + sum_k V_k W_ik + wall        -      (j liquid, k solid)
//   rho     rho0 phi                                                       kg/m^3
//   P       (rho0 c^2/7) (phi^7 - 1), not below 0 unless tension is asked for  Pa
//   mu      dynamic viscosity                                              Pa s
//
// With equal rest volumes phi = rho/rho0 of eq. (1): rho_i = m_i sum_j W_ij. Weighting each neighbour by its
// own rest volume extends this to unequal volumes (a melted particle keeps its mass and takes the density of
// its liquid, so its volume changes); masses do not enter, so a contrast of 100:10000 does not smear.
// The pressure force is minus the gradient of the internal energy under that density estimate, hence
// exactly antisymmetric and energy conserving:
//   F_i<-j = -V0_i V0_j (P_i/phi_i^2 + P_j/phi_j^2) grad_i W_ij.
// Deviations from the paper: eq. (2) prints W where grad W belongs and lacks a mass; eq. (3) lacks a volume.
#pragma once

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// rho0 c^2 / 7 [Pa], the factor of the Tait equation.
template <class T>
MELTSIM_HD T tait_stiffness(T rest_density, T sound_speed) {
  return rest_density * sound_speed * sound_speed / T(7);
}

inline constexpr double usual_density_error = 0.005;  ///< e where none is given

/// c = v_max / sqrt(2 e) [m/s], with v_max of a scene in which particles start at `speed` [m/s] and may fall by `depth` [m].
/// Liquid at rest of that depth is compressed by g h/c^2 = e at its lowest place; e = 0.005 is c = 10 v_max (Monaghan 1994, J.
/// Comput. Phys. 110:399: density then varies by 1 %), to the last bit.
inline double sound_speed_for(double speed, double gravity, double depth, double density_error) {
  return 10.0 * std::sqrt(usual_density_error / density_error) *
         std::sqrt(speed * speed + 2.0 * gravity * depth);
}

/// Largest speed [m/s] of a layer of `depth` [m] that creeps down a wall along gravity, g h^2 / (2 nu) (Nusselt 1916; nu [m^2/s]).
inline double creep_speed(double gravity, double depth, double kinematic_viscosity) {
  return gravity * depth * depth / (2 * kinematic_viscosity);
}

/// Tait equation with exponent 7 [Pa]; stiffness = rho0 c^2 / 7 [Pa]. For phi below `lowest` the pressure is that at
/// `lowest`. 1: no tension, for free surfaces, where phi is small because neighbours are missing; 0: tension,
/// for liquid that fills its domain.
template <class T>
MELTSIM_HD T tait_pressure(T stiffness, T phi, T lowest = T(1)) {
  const T p = maximum(phi, lowest), p2 = p * p;
  return stiffness * (p2 * p2 * p2 * p - T(1));
}

/// P / phi^2 [Pa], the operand that each end of a pair contributes to the pressure force.
template <class T>
MELTSIM_HD T pressure_term(T pressure, T phi) {
  return pressure / (phi * phi);
}

/// Pressure force on i from j, divided by x_ij [N/m]; f = kernel_gradient_factor.
template <class T>
MELTSIM_HD T pressure_factor(T volume_i, T volume_j, T term_i, T term_j, T f) {
  return (volume_i * volume_j) * (term_i + term_j) * f;
}
/// Pressure force on i from j [N].
template <class T>
MELTSIM_HD Vec3<T> pressure_force(T volume_i, T volume_j, T term_i, T term_j, T f, Vec3<T> x_ij) {
  return x_ij * pressure_factor(volume_i, volume_j, term_i, term_j, f);
}

/// Viscous force on i from j, divided by v_ji = v_j - v_i [N s/m]: mu V_i V_j L_ij.
template <class T>
MELTSIM_HD T viscous_factor(T mu, T volume_i, T volume_j, T laplacian) {
  return mu * (volume_i * volume_j) * laplacian;
}
/// Viscous force on i from j [N].
template <class T>
MELTSIM_HD Vec3<T> viscous_force(T mu, T volume_i, T volume_j, T laplacian, Vec3<T> v_ji) {
  return v_ji * viscous_factor(mu, volume_i, volume_j, laplacian);
}

/// Pair viscosity [Pa s]: the harmonic mean, so that the thinner liquid limits the shear stress
/// (Morris et al. 1997; continuous stress across an interface). Of two liquids with a yield stress the geometric mean: what does not yield
/// is some thousand times as viscous as what does, and ends anywhere between the two particles, where the harmonic mean
/// lets all of the pair yield. Symmetric in its arguments.
template <class T>
MELTSIM_HD T pair_viscosity(T mu_i, T mu_j, bool both_yield = false) {
  if (both_yield) return std::sqrt(mu_i * mu_j);
  const T sum = mu_i + mu_j;
  return sum > T(0) ? T(2) * mu_i * mu_j / sum : T(0);
}

/// How fast a pair approaches, h abs(v_ij.x_ij)/(r^2 + 0.01 h^2) where v_ij.x_ij < 0, else 0 [m/s]: abs(mu) of Monaghan (1992), ARA&A
/// 30:543; h = H/2.
template <class T>
MELTSIM_HD T approach_speed(const SphKernel<T>& k, T r2, T v_dot_x) {
  return -(minimum(v_dot_x, T(0)) * (T(1) / (r2 + k.epsilon2))) * (T(0.5) * k.support);
}

/// Artificial viscosity (Monaghan 1992, ARA&A 30:543, eq. 4.2 without its quadratic term) [Pa]: added to the pressure terms of an approaching
/// pair to damp acoustic noise; density = mean rest density of the pair, approach as above.
///   Pi = rho alpha c abs(mu)
template <class T>
MELTSIM_HD T artificial_pressure(T alpha, T sound_speed, T density, T approach) {
  return density * (alpha * sound_speed) * approach;
}

/// beta of Monaghan's quadratic term, as a bound [-].
inline constexpr int artificial_impact = 4;

/// The part of an artificial pressure that a pair gets [Pa]; terms = P_i/phi_i^2 + P_j/phi_j^2. It is at most the size of the pair's
/// pressure and beta rho mu^2 together: liquid that nothing presses carries no sound to damp, and is free to move
/// inward, as in a jet that gravity draws out; what strikes liquid or spreads as a film is held before pressure builds up, or it would bounce.
/// Deviation from Monaghan, who has no such bound and adds beta rho mu^2.
template <class T>
MELTSIM_HD T bounded_artificial_pressure(T artificial, T terms, T density, T approach) {
  return minimum(artificial, std::abs(terms) + T(artificial_impact) * density * (approach * approach));
}

/// Density of a pair on which artificial viscosity does not act [kg/m^3].
template <class T>
MELTSIM_HD constexpr T undamped() {
  return T(0);
}

/// Operands of one pair of liquid particles.
template <class T>
struct LiquidPair {
  T volume_i, volume_j;  ///< V0 [m^3]
  T term_i, term_j;      ///< pressure_term [Pa]
  T viscosity, density;  ///< of the pair: mu [Pa s], mean rest density [kg/m^3] or undamped()
  Vec3<T> x_ij, v_ij;    ///< x_i - x_j [m], v_i - v_j [m/s]
};

/// Force on i from j as two factors: F = along x_ij + drag v_ij.
template <class T>
struct PairFactors {
  T along, drag;  ///< [N/m]; [N s/m]
};
/// What multiplies x_ij and v_ij in the force on i, pressure and viscosity together, with an artificial pressure [Pa].
template <class T>
MELTSIM_HD PairFactors<T> pair_factors(const SphKernel<T>& k, const LiquidPair<T>& p, T artificial, T r2) {
  const T r = std::sqrt(r2), f = kernel_gradient_factor(k, r);
  return {pressure_factor(p.volume_i, p.volume_j, p.term_i + p.term_j, artificial, f),
          -viscous_factor(p.viscosity, p.volume_i, p.volume_j, kernel_laplacian(k, r, r2))};
}
/// The same with the artificial viscosity of two particles of liquid.
template <class T>
MELTSIM_HD PairFactors<T> liquid_factors(const SphKernel<T>& k, T alpha, T sound_speed,
                                         const LiquidPair<T>& p, T r2) {
  const T approach = approach_speed(k, r2, dot(p.v_ij, p.x_ij));
  const T pi = artificial_pressure(alpha, sound_speed, p.density, approach);
  return pair_factors(k, p, bounded_artificial_pressure(pi, p.term_i + p.term_j, p.density, approach), r2);
}
/// force plus the force of a pair [N], in six fused instructions.
template <class T>
MELTSIM_HD Vec3<T> add_liquid_force(Vec3<T> force, const PairFactors<T>& f, Vec3<T> x_ij, Vec3<T> v_ij) {
  return (force + x_ij * f.along) + v_ij * f.drag;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
