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

/// Largest sub-step [s] from a steady acceleration g [m/s^2], courant sqrt(H/g): what starts at rest moves by
/// courant^2 H/2 meanwhile (Monaghan 1992, Annu. Rev. Astron. Astrophys. 30:543, sec. 10, has 0.25 sqrt(h/f)). Binds
/// only where the sound speed is set too low for the scene.
inline double force_dt(double courant, double support, double acceleration) {
  return courant * std::sqrt(support / acceleration);
}

/// Factor on the acoustic step where something lighter than the densest liquid meets it (a light liquid, a
/// light body): the heavy side's pressure accelerates the light side more. (light/dense)^(1/4), measured: 100
/// under 10000 is stable at 0.5 of the acoustic step and not at 1.
inline double contrast_factor(double lightest, double densest_liquid) {
  return lightest < densest_liquid ? std::pow(lightest / densest_liquid, 0.25) : 1.0;
}

/// The step that contacts and bodies without a modulus go by [s], whatever sub-steps are taken: the acoustic step, less where
/// a heavy body may stand on a light one. Their spring has the lighter one's mass and the heavier one's load: where c is ten
/// times the speed of a fall through the scene, what stands presses a contact in by at most 0.025 spacings times their ratio
/// of densities, by a tenth of a spacing with this.
inline double spring_dt(double acoustic, double lightest_body, double heaviest_body) {
  const double bearable = 4 * lightest_body;
  return heaviest_body > bearable ? acoustic * std::sqrt(bearable / heaviest_body) : acoustic;
}

/// Factor on the acoustic step where the support is short: few neighbours answer more strongly to each other's
/// displacements, and gain energy at the whole of it (docs/design/steps.md).
inline double support_factor(double support_in_spacings) { return support_in_spacings < 2.25 ? 0.7 : 1.0; }

/// Largest sub-step [s] from viscosity: explicit diffusion of momentum, 1 / (nu sum_j V_j L_ij).
inline double viscous_dt(double kinematic_viscosity, double laplacian_sum) {
  return 1.0 / (kinematic_viscosity * laplacian_sum);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
