// SPDX-License-Identifier: Apache-2.0
// Leap-frog, drift-kick-drift: x += v dt/2; forces; v += a dt; x += v dt/2.
//
// Source: Hairer, Lubich & Wanner (2003), Acta Numerica 12:399 (the Stoermer-Verlet scheme's second form).
// After a step positions and velocities belong to the same time; one force evaluation; symplectic for constant dt.
#pragma once

#include <algorithm>

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {
/// Position after half a step [m].
template <class T>
MELTSIM_HD Vec3<T> drift(Vec3<T> x, Vec3<T> v, T half_dt) {
  return x + v * half_dt;
}
/// Velocity after a step [m/s].
template <class T>
MELTSIM_HD Vec3<T> kick(Vec3<T> v, Vec3<T> a, T dt) {
  return v + a * dt;
}

/// Largest sub-step [s] from sound: courant H / c. Stable up to courant = 0.6.
inline double acoustic_dt(double courant, double support, double sound_speed) {
  return courant * support / sound_speed;
}

/// Flow over sound up to which the acoustic step holds as it is: what the speed of a liquid in a scene is meant to be at most
/// (Monaghan 1994, J. Comput. Phys. 110:399, sec. 2.2).
inline constexpr double quiet_mach = 0.1;

/// Largest sub-step [s] of liquid that moves at `speed`: a signal passes it at c + v (Monaghan 1992, Annu. Rev. Astron. Astrophys.
/// 30:543, sec. 10, has 0.4 h/c with c far above v).
/// Deviation: the acoustic step holds up to quiet_mach, which its Courant number allows for.
inline double signal_dt(double courant, double support, double sound_speed, double speed) {
  return courant * support / (sound_speed + std::max(0.0, speed - quiet_mach * sound_speed));
}

/// Largest sub-step [s] from a steady acceleration g [m/s^2]: courant sqrt(H/g), in which a particle at rest moves by
/// courant^2 H/2 (Monaghan 1992, Annu. Rev. Astron. Astrophys. 30:543, sec. 10, has 0.25 sqrt(h/f)). It is the smallest
/// limit only if the sound speed is set too low for the scene.
inline double force_dt(double courant, double support, double acceleration) {
  return courant * std::sqrt(support / acceleration);
}

/// Factor on the acoustic step if a liquid or body lighter than the densest liquid meets it, because the pressure
/// of the heavy side accelerates the light side more: (light/dense)^(1/4). Ours, from trials: at a ratio of
/// densities of 100 half of the acoustic step is stable and the whole is not.
inline double contrast_factor(double lightest, double densest_liquid) {
  return lightest < densest_liquid ? std::pow(lightest / densest_liquid, 0.25) : 1.0;
}

/// Time step of the springs of contacts and of bodies without a modulus [s], independent of the sub-steps: the acoustic step,
/// shorter if a heavy body may stand on a light one. The spring between them has the mass of the lighter body and the load
/// of the heavier: with c ten times the speed of a fall through the scene, the acoustic step would let a standing body press
/// a contact in by up to 0.025 spacings times the ratio of densities; this limits it to a tenth of a spacing.
///
/// It is shorter, too, if a body has less than half the density of liquid that it may lie in: liquid is then the spring, of
/// stiffness rho_l c^2, and the body alone the mass, so that its period goes as sqrt(rho_b/rho_l) dx/c. Ours, from trials: with
/// (2 rho_b/rho_l)^0.6 cubes of 27 particles and 1e-4 to 0.5 of the density stay whole at the bottom of a tank; with the
/// power 0.5 those of 0.001 to 0.1 do not at courant 0.6; with the power 1/4 that holds between liquids they halt at 0.1.
inline double spring_dt(double acoustic, double lightest_body, double heaviest_body, double densest_liquid) {
  const double bearable = 4 * lightest_body, floating = 2 * lightest_body;
  double share = 1;
  if (heaviest_body > bearable) share = std::sqrt(bearable / heaviest_body);
  if (densest_liquid > floating) share = std::min(share, std::pow(floating / densest_liquid, 0.6));
  return acoustic * share;
}

/// Factor on the acoustic step for a short support: few neighbours react more strongly to each other's displacements,
/// and would gain energy at the whole step (docs/design/steps.md).
inline double support_factor(double support_in_spacings) { return support_in_spacings < 2.25 ? 0.7 : 1.0; }

/// Largest sub-step [s] from viscosity: explicit diffusion of momentum, 1 / (nu sum_j V_j L_ij).
inline double viscous_dt(double kinematic_viscosity, double laplacian_sum) {
  return 1.0 / (kinematic_viscosity * laplacian_sum);
}

/// Largest sub-step [s] in which liquid of this dynamic viscosity [Pa s] drags a body along: as viscous_dt, with the density
/// of the body and the neighbours that lie on one side of its face.
inline double drag_dt(double viscosity, double body_density, double laplacian_sum) {
  return viscous_dt(viscosity / body_density, 0.5 * laplacian_sum);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
