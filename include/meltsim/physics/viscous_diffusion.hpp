// SPDX-License-Identifier: Apache-2.0
// Viscosity as diffusion of velocity, in super-steps (diffusion.hpp): for liquids so viscous that the explicit limit
// (integrate.hpp, viscous_dt) would be the smallest one.
//
// Source: the pair form of fluid.hpp, mu_ij V_i V_j L_ij (v_j - v_i), is the exchange of heat with velocity as potential,
// mass as capacity and 1/mu as resistivity: the harmonic mean of pair_viscosity is that of pair_conductance.
//
//   dv_i/dt = a_i + sum_j g_ij (v_j - v_i)/m_i + sum_walls g_w (v_w - v_i)/m_i
//
//   a_i     acceleration by all forces but viscosity: pressure, gravity, contact, shape matching; constant in a sub-step
//   g_w     mu V I(d)/d of a no-slip wall (wall_exchange.hpp)                                            kg/s
//
// a_i stands inside the stages: where forces and viscosity are in balance a super-step changes nothing, whatever its length.
// Added before or after, it would move a steady flow off by half of tau lambda. Ours.
// A particle of a body takes part with its own mass and no resistivity, like a liquid one of infinite viscosity that shape
// matching holds, so that no slip holds at the surface (coupling.hpp); one of a fixed or kinematic body keeps its velocity. Artificial viscosity stays with the pressure.
#pragma once

#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/diffusion.hpp"
#include "meltsim/physics/integrate.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Most stages of one super-step. With s stages rounding grows by up to s^2: 64 cost three of the seven digits that single
/// precision has. Beyond, the sub-step is divided into several super-steps.
inline constexpr int most_viscous_stages = 64;

/// Head room over viscous_dt [-], of the stages and of explicit viscosity: a particle a quarter of a spacing from a no-slip wall
/// exchanges 1.35 times as fast as one inside (H = 2.5 dx), and crowds somewhat faster than the lattice. Exceeding that of the
/// stages raises StepResult::viscous_bound_exceeded.
inline constexpr double viscous_margin = 1.4;

/// Largest sub-step [s] of explicit viscosity mu [Pa s] in liquid of this density: with its head room, and that of a body no
/// lighter than `lightest_body` [kg/m^3] (infinity: none that moves), which artificial viscosity [Pa s] drags, too (drag_dt). A rod
/// one particle thick has neighbours on twice as many sides as drag_dt counts: with half of this viscosity such a rod of 0.3 of
/// the liquid's density was unstable.
inline double explicit_viscous_dt(double mu, double density, double lightest_body, double artificial,
                                  double laplacian_sum) {
  return std::fmin(viscous_dt(mu / density, laplacian_sum) / viscous_margin,
                   drag_dt(2 * no_slip_viscosity(mu) + artificial, lightest_body, laplacian_sum));
}

/// Resistivity that marks a particle of a body, which has none.
inline constexpr double resistivity_of_solid = -1;

/// R_i + R_j [1/(Pa s)]; 0 where both are of bodies.
template <class T>
MELTSIM_HD T viscous_resistivities(T own, T other) {
  return maximum(own, T(0)) + maximum(other, T(0));
}

/// Share of a conductance that counts towards the bound of the stages [-]. Twice a particle's conductance bounds its mode, as
/// neighbours may move against it; what a body does not follow counts once, as that of walls does. So a pair with a body,
/// of twice the conductance, counts like one of liquid.
template <class T>
MELTSIM_HD T bound_share(T own, T other) {
  return own < T(0) || other < T(0) ? T(1.0 / no_slip_factor) : T(1);
}

/// g_ij [kg/s]; 0 between particles of bodies, and with a liquid without viscosity (R infinite). Symmetric to the last bit.
template <class T>
MELTSIM_HD T viscous_conductance(T volume_i, T volume_j, const LaplacianQuotient<T>& l, T own, T other) {
  const T resistivities = viscous_resistivities(own, other);
  return resistivities > T(0) ? pair_conductance(volume_i, volume_j, l, resistivities) : T(0);
}

/// lambda [1/s]: bound of the rates of exchange of a particle of density `density` [kg/m^3] in liquid of viscosity mu [Pa s];
/// laplacian_sum = sum_j V_j L_ij of the lattice [1/m^2].
inline double viscous_lambda(double mu, double density, double laplacian_sum) {
  return 2 * viscous_margin * mu / density * laplacian_sum;
}

/// Stages and super-steps of a sub-step.
struct ViscousStages {
  int stages = 0;         ///< of one super-step; 0: viscosity is explicit
  double supersteps = 0;  ///< whole
};

/// Stages up to which there is one super-step.
inline constexpr int single_viscous_stages = 6;

/// Largest 2 d + alpha of a movable body that one super-step bears, d its damping and alpha its stiffness (shape_matching.hpp).
/// Both stand inside the stages as constant accelerations, so a mode with z = tau times its rate goes from u to
/// R u - (1 - R)/z (d u + alpha x): stable while 2 d + alpha < 2 z (1 + R)/(1 - R), which two stages bring down to 2 where
/// R is least, four to 2.8. Of two super-steps R(z/2)^2 stands for R, and all up to 4 is stable. 3/4 of the bound.
inline constexpr double single_step_pull = 1.5;

/// Fewest that tau lambda allows, of several super-steps if `single` is false: one super-step of up to single_viscous_stages; else two, or as many as have
/// most_viscous_stages or fewer each. One super-step leaves R(z) of a mode with z = tau times its rate, where R falls to
/// -0.4: what a sudden load sets going overshoots by that share. Of two it leaves R(z/2)^2, which is never negative. Up to 6
/// stages that concerns only what is as short as a few spacings; beyond, 1.4 times the stages keep smooth flow from
/// overshooting.
inline ViscousStages viscous_stages(double tau_lambda, bool single = true) {
  if (single && tau_lambda <= stage_reach(single_viscous_stages)) return {stage_count(tau_lambda, true), 1};
  const double least = std::ceil(tau_lambda / stage_reach(most_viscous_stages) * (1 - 1e-12));
  const double supersteps = std::fmax(2.0, least);
  return {stage_count(std::fmin(tau_lambda / supersteps, stage_reach(most_viscous_stages)), true),
          supersteps};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
