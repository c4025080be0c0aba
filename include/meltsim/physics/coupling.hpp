// SPDX-License-Identifier: Apache-2.0
// Forces between liquid and solid particles.
//
// Sources: Shao & Yu (2017), eqs. (1)-(3); Crespo, Gomez-Gesteira & Dalrymple (2007), CMC 5:173, and Canelas
// et al. (2015), Int. J. Numer. Meth. Fluids 78:365, for solid particles that answer with the liquid's
// equation of state.
//
//   phi_i   sum_j V_j W_ij over liquid and solid alike, and their images in walls            -
//   phi_k   the same sum at a solid particle, its own piece as its lattice has it            -
//   tau_k   (phi_k^7 - 1)/phi_k^2, not below 0                                                -
//   F_i<-k  V_i V_k (P_i/phi_i^2 + B_i tau_k) f x_ik + viscous terms; B_i = rho0_i c^2/7      N
//   mu_ik   2 mu_i, the viscosity of the pair                                                Pa s
//   F_k<-i  -F_i<-k, by the same function
//
// So a solid particle in contact with liquid carries the pressure of that liquid. The forces are minus the gradient
// of the energy of phi_i and phi_k. Between two solid particles there are none, so the particles of one piece count in phi_k where
// the lattice has them, however the piece is strained (lattice_offset): what they add is then a constant, and no work is
// left out. If liquid and body lie on one lattice, the surface of the body
// is no discontinuity for the liquid: phi is 1.000 beside faces, edges and corners, and a start in contact is
// a start at rest.
//
// No slip: a solid particle is a liquid one of infinite viscosity, so the harmonic mean of the pair (pair_viscosity) is
// 2 mu_i, and the velocity of the body holds midway between the two, at its surface (Cleary & Monaghan 1999, J. Comput.
// Phys. 148:227, for heat across an interface; Morris, Fox & Zhu 1997, J. Comput. Phys. 136:214, eq. (17), continue the profile
// into the wall by a factor 1 + d_k/d_i on the velocity difference: 2 on average over the pairs across a plane lattice face,
// with which the traction of a linear profile is exact). With mu_i alone liquid sticks half a spacing below the surface. Beside
// a plane face of a lattice the profile extrapolates to the velocity of the body 0.00, 0.02, 0.07 dx above the surface at
// H = 2, 2.5, 3 dx.
//
// Deviations: V_k is the lattice's dx^3 instead of 1/sum_l W_kl (eq. 1: 1.25 dx^3 on a face, where the
// liquid's first layer then reads 1.049 rho0), and P_k stands beside P_i. The one-sided sum carries half of
// the pressure, so the first layer would approach until it holds twice the hydrostatic pressure; doubling P_i
// instead would feed energy into all liquid in contact with a solid. Known limit: a plate one particle thick
// with liquid on one side only has phi_k < 1, and the first layer of liquid comes too near to it and reads
// too large a pressure; from two particles on it reads the right one within 8 % (docs/limits.md has
// the numbers).
#pragma once

#include "meltsim/physics/contact.hpp"
#include "meltsim/physics/fluid.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// tau_k [-]; multiplied by the stiffness B_i of the liquid at the other end it is P_k/phi_k^2.
template <class T>
MELTSIM_HD T solid_term(T phi) {
  return pressure_term(tait_pressure(T(1), phi), phi);
}

/// x_kl of two particles of one piece in phi_k [m]. steps: from l to k on the lattice; turn: rotation of the region of k. Deviation:
/// a pair that is strained to beyond H is left out; it would add at most 0.007 of W(0) below a strain of a quarter.
template <class T>
MELTSIM_HD Vec3<T> lattice_offset(const Mat3<T>& turn, Vec3<T> steps, T spacing) {
  return turn * (steps * spacing);
}

/// Least E/(rho c^2) of a body in liquid: what splashes do not crush at once. Measured where strain moved what phi_k counts
/// (docs/design/steps.md).
inline constexpr double least_modulus = 0.5;

/// The same of a body of this density [kg/m^3]. What presses on it is the liquid: in liquid of more than twice its density E is
/// at least (rho_liquid - 1.5 rho) c^2, about as stiff as at the default stiffness.
inline double least_modulus_of(double body_density, double densest_liquid) {
  const double excess = densest_liquid / body_density - 1;
  return excess > 1 ? least_modulus * (2 * excess - 1) : least_modulus;
}

/// What least_modulus_of times (spring_dt/acoustic step)^2 is at most: widths of regions follow from it.
inline constexpr double most_least_spring = 2.0;

/// Factor on the velocity difference between liquid and the particle of a body, as viscosity and the shear rate take it [-]: the
/// surface lies midway between the two.
inline constexpr int no_slip_factor = 2;

/// Viscosity of a pair of liquid of viscosity mu [Pa s] and a particle of a body [Pa s]: what pair_viscosity tends to as
/// the other one grows.
template <class T>
MELTSIM_HD T no_slip_viscosity(T mu) {
  return T(no_slip_factor) * mu;
}

/// Operands of one liquid-solid pair: i is the liquid particle, k the solid one, for the force on either.
template <class T>
struct CouplingPair {
  T fluid_volume, solid_volume;  ///< V_i, V_k [m^3]
  T terms;                       ///< P_i/phi_i^2 + B_i tau_k [Pa]
  T viscosity;                   ///< mu_i [Pa s]
  Vec3<T> x_ik;                  ///< x_i - x_k [m]
  Vec3<T> v_ik;                  ///< v_i - v_k [m/s]
};

/// The pair as two particles of the same liquid, the solid one with the pressure term B_i tau_k and the pair's viscosity mu_ik. No
/// artificial viscosity, as between liquid and walls: it acts on what slides, too, and would make liquid stick to bodies.
template <class T>
MELTSIM_HD LiquidPair<T> as_liquid(const CouplingPair<T>& p) {
  return {p.fluid_volume, p.solid_volume, p.terms, T(0), no_slip_viscosity(p.viscosity),
          undamped<T>(),  p.x_ik,         p.v_ik};
}

/// Force on the liquid particle [N]; the solid particle receives exactly the negative.
template <class T>
MELTSIM_HD Vec3<T> coupling_force(const SphKernel<T>& k, const CouplingPair<T>& p, T r2) {
  return add_liquid_force(Vec3<T>{}, pair_factors(k, as_liquid(p), T(0), r2), p.x_ik, p.v_ik);
}

/// Distance in spacings below which liquid could slip between lattice sites (the middle of four sites is at
/// 0.71); the first layer of liquid at rest is at 1.
inline constexpr double leak_distance = 0.9;

/// How solid a liquid particle finds its surroundings.
template <class T>
struct SolidCover {
  /// s = sum V_k W_ik over the particles of bodies and their images in walls [-]
  T fraction{};
  T rate{};  ///< ds/dt = sum V_k v_ik.grad W_ik [1/s]

  /// What one particle of a body, or its image, adds. x_ik, v_ik as in CouplingPair.
  MELTSIM_HD void add(const SphKernel<T>& k, T solid_volume, Vec3<T> x_ik, Vec3<T> v_ik, T r2) {
    const T r = std::sqrt(r2);
    fraction += solid_volume * kernel_value(k, r);
    rate -= solid_volume * kernel_gradient_factor(k, r) * dot(v_ik, x_ik);
  }
};

/// Share of leak_force that acts on a liquid particle, 0 to 1. s is smooth where the surface of a lattice has steps, and of what
/// slides along a body it hardly changes. So what slides does not catch at the steps, which would drag the first layer of
/// liquid along; what comes nearer, or is in already, is held. Faster than a hundredth of the sound speed it is held in full.
template <class T>
MELTSIM_HD T leak_share(const SolidCover<T>& cover, T spacing, T sound_speed) {
  const T approach = (cover.rate * spacing / sound_speed - static_cast<T>(1e-3)) * T(200);
  const T within = (cover.fraction - static_cast<T>(0.42)) * T(20);
  return minimum(maximum(maximum(approach, within), T(0)), T(1));
}

/// Safeguard against leaks through thin solids: the contact spring of contact.hpp on the liquid particle [N],
/// without friction, times its leak_share; the solid receives the negative. It stops particles of up to 0.15 dx/dt_s normal to a
/// single layer.
/// x_ik, v_ik as in CouplingPair.
template <class T>
MELTSIM_HD Vec3<T> leak_force(T spacing, T spring_dt, T fluid_mass, T solid_mass, Vec3<T> x_ik, Vec3<T> v_ik,
                              T r2) {
  const T r = std::sqrt(r2);
  if (!(r > T(0))) return {};
  return contact_force(T(leak_distance) * spacing - r, x_ik * (T(1) / r), v_ik,
                       reduced_mass(fluid_mass, solid_mass), T(0), spring_dt);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
