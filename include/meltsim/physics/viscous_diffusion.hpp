// SPDX-License-Identifier: Apache-2.0
// Viscosity as diffusion of velocity, in super-steps (diffusion.hpp): for liquids so viscous that the explicit limit
// (integrate.hpp, viscous_dt) would be the smallest one.
//
// Source: the pair form of fluid.hpp, mu_ij V_i V_j L_ij (v_j - v_i), is the exchange of heat with velocity as potential,
// mass as capacity and 1/mu as resistivity: the mean of pair_viscosity is that of pair_conductance. Between particles of liquid the
// force is along the line between them, as in Monaghan (1997), J. Comput. Phys. 136:298:
//
//   dv_i/dt = a_i + sum_liquid g_ij (v_ji.u_ij) u_ij/m_i + sum_bodies g_ij v_ji/m_i + sum_walls g_w (v_w - v_i)/m_i
//
//   a_i     acceleration by all forces but viscosity: pressure, gravity, contact, shape matching; constant in a sub-step
//   v_ji    v_j - v_i                                                                                    m/s
//   u_ij    (x_i - x_j)/dx                                                                               -
//   g_ij    mu V_i V_j L_ij with a body; mu V_i V_j C_ij between particles of liquid                     kg/s
//   C_ij    C (1-q)^3, C from central_viscosity_scale                                                    1/m^5
//   g_w     mu V I(d)/d of a no-slip wall (wall_exchange.hpp)                                            kg/s
//
// Why along the line: what turns as a whole feels nothing, and angular momentum is exact. mu V V L v_ji stands for a stress of mu grad v
// instead of mu (grad v + grad v^T). Inside the two have the same divergence; at a free surface the former holds what turns, so
// that sheets and threads do not fold. Summed over a neighbourhood that is the same in all directions, C_ij gives
// mu (lap v + 2 grad div v).
// Deviation: Monaghan's weight is L_ij, which on a lattice, whose nearest neighbours it counts most, shears 13 % too easily and
// stretches 9 % too hard. (1-q)^3 u u counts those farther off, whose directions are many.
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
/// lighter than `lightest_body` [kg/m^3] (infinity: none that moves) that liquid drags along (drag_dt). A rod
/// one particle thick has neighbours on twice as many sides as drag_dt counts: with half of this viscosity such a rod of 0.3 of
/// the liquid's density was unstable.
inline double explicit_viscous_dt(double mu, double density, double lightest_body, double laplacian_sum) {
  return std::fmin(viscous_dt(mu / density, laplacian_sum) / viscous_margin,
                   drag_dt(2 * no_slip_viscosity(mu), lightest_body, laplacian_sum));
}

/// Root of the resistivity of a particle of a body, which has none.
inline constexpr double root_of_solid = 0;

/// Root of the resistivity 1/mu [1/sqrt(Pa s)], negative of a liquid with a yield stress: pairs of such take another mean. Of the
/// roots both means are products.
template <class T>
MELTSIM_HD T resistivity_root(T mu, bool yields) {
  const T root = std::sqrt(T(1) / mu);
  return yields ? -root : root;
}

/// mu [Pa s] of a liquid particle.
template <class T>
MELTSIM_HD T viscosity_of_root(T root) {
  return T(1) / (root * root);
}

/// 2/mu of a pair [1/(Pa s)], as pair_viscosity has it, from the roots of both; 0 where both are of bodies, not a number where one
/// is infinite. R_i + R_j as (r_i + r_j)^2 - 2 r_i r_j, which is symmetric to the last bit where products and sums are fused, too.
template <class T>
MELTSIM_HD T pair_resistivities(T own, T other) {
  const T twice = T(2) * std::fabs(own * other), sum = std::fabs(own) + std::fabs(other);
  return ((own < T(0)) & (other < T(0))) ? twice : sum * sum - twice;
}

/// Whether one of a pair with these roots is of a body.
template <class T>
MELTSIM_HD bool with_body(T own, T other) {
  return own == T(0) || other == T(0);
}

/// Share of a conductance that counts towards the bound of the stages [-]. Twice a particle's conductance bounds its mode, as
/// neighbours may move against it; what a body does not follow counts once, as that of walls does. So a pair with a body,
/// of twice the conductance, counts like one of liquid.
template <class T>
MELTSIM_HD T bound_share(T own, T other) {
  return with_body(own, other) ? T(1.0 / no_slip_factor) : T(1);
}

/// Least support H/dx [-] with which forces are along the line between particles of liquid. Within less there are so few directions
/// that a lattice resists stretching more than shear, by 31 % at 2 and six times at 1.6: the whole difference of velocities counts then, as
/// with a body.
inline constexpr double least_central_support = 2.2;

/// The force along the line between particles of liquid.
template <class T>
struct CentralViscosity {
  T scale{};            ///< C [1/m^5]; 0: the support is too small
  T inverse_spacing{};  ///< 1/dx [1/m]
};

/// C dx^5 [-] (host): that with which a plane shear on the lattice has the stress mu gd, on average over all that flow makes of the
/// lattice, whose layers it moves past each other by any share of a spacing. 0 where the support is too small.
inline double central_viscosity_scale(double support, double spacing) {
  const double H = support / spacing;
  if (H < least_central_support) return 0;
  const int n = static_cast<int>(H) + 1;
  constexpr int shares = 20;
  double sum = 0;
  for (int k = 0; k < shares; ++k)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z)
        for (int l = -n; l <= n; ++l) {
          const double shift = double(y) * k / shares, x = l + shift - std::floor(shift);
          const double a = std::fmax(0.0, 1 - std::sqrt(x * x + double(y * y + z * z)) / H);
          sum += a * a * a * x * x * double(y * y);
        }
  return 2 * shares / sum;
}

/// sum_j V_j C_ij u_x^2 over the lattice [1/m^2]: bounds the rate of this exchange as lattice_laplacian_sum does that of L (host).
/// 0 where the support is too small.
inline double lattice_central_sum(double support, double spacing) {
  const double H = support / spacing;
  const int n = static_cast<int>(H) + 1;
  double sum = 0;
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const double a = std::fmax(0.0, 1 - std::sqrt(double(x * x + y * y + z * z)) / H);
        sum += a * a * a * double(x * x);
      }
  return central_viscosity_scale(support, spacing) * sum / (spacing * spacing);
}
/// The same of H [m] and dx [m], as sums take it (host).
template <class T>
inline CentralViscosity<T> make_central_viscosity(double support, double spacing) {
  return {static_cast<T>(central_viscosity_scale(support, spacing) / std::pow(spacing, 5)),
          static_cast<T>(1 / spacing)};
}

/// C_ij at distance r [m], as the quotient that viscous_conductance takes.
template <class T>
MELTSIM_HD LaplacianQuotient<T> central_quotient(const CentralViscosity<T>& c, const SphKernel<T>& k, T r) {
  return {c.scale * kernel_gradient_shape(k, r), T(1)};
}

/// The same of a pair of liquid: a third of u^2, as much as each direction takes of a neighbourhood that is the same in all.
template <class T>
MELTSIM_HD T central_share(Vec3<T> u) {
  return dot(u, u) * T(1.0 / 3.0);
}

/// g_ij [kg/s] from the roots of both; 0 between particles of bodies, and with a liquid without viscosity (an infinite root).
/// Symmetric to the last bit.
template <class T>
MELTSIM_HD T viscous_conductance(T volume_i, T volume_j, const LaplacianQuotient<T>& l, T own, T other) {
  const T resistivities = pair_resistivities(own, other);
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
