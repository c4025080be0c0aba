// SPDX-License-Identifier: Apache-2.0
// Leap-frog, drift-kick-drift: x += v dt/2; forces; v += a dt; x += v dt/2.
//
// Source: Hairer, Lubich & Wanner (2003), Acta Numerica 12:399 (the Stoermer-Verlet scheme's second form).
// Positions and velocities meet at whole steps, one force evaluation per step, symplectic for constant dt.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

template <class T>
MELTSIM_HD Vec3<T> drift(Vec3<T> x, Vec3<T> v, T half_dt) {
  return x + v * half_dt;
}

template <class T>
MELTSIM_HD Vec3<T> kick(Vec3<T> v, Vec3<T> a, T dt) {
  return v + a * dt;
}

/// Largest sub-step [s] from sound: courant H / c. Measured stable to 0.6, 0.4 is the default.
inline double acoustic_dt(double courant, double support, double sound_speed) {
  return courant * support / sound_speed;
}

/// Springs whose stiffness follows the step (shape matching without a modulus, contact) take it to be no
/// shorter than this share of the acoustic step: their stiffness then belongs to the scene, and a single
/// short step does not release at once, at a distance over dt, what longer ones hold against a load. Bodies
/// with alpha = 1, w = 2 are 6 times as fast as sound in the liquid then, at the default H and Courant
/// number.
inline constexpr double spring_share = 0.25;

/// The step that springs go by [s]. reference: acoustic_dt, 0 = none (nothing presses on anything).
inline double spring_dt(double dt, double reference) {
  const double least = spring_share * reference;
  return dt < least ? least : dt;
}

/// Factor on the acoustic step where something lighter than the densest liquid meets it (a light liquid, a
/// light body): the heavy side's pressure accelerates the light side more. (light/dense)^(1/4), measured: 100
/// under 10000 is stable at 0.5 of the acoustic step and not at 1.
inline double contrast_factor(double lightest, double densest_liquid) {
  return lightest < densest_liquid ? std::pow(lightest / densest_liquid, 0.25) : 1.0;
}

/// Largest sub-step [s] from viscosity: explicit diffusion of momentum, 1 / (nu sum_j V_j L_ij).
inline double viscous_dt(double kinematic_viscosity, double laplacian_sum) {
  return 1.0 / (kinematic_viscosity * laplacian_sum);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
