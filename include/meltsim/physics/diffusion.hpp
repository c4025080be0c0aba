// SPDX-License-Identifier: Apache-2.0
// Diffusion of any quantity between particles: what a pair exchanges, and the super-steps that advance it beyond the
// limit of an explicit step. Heat (heat.hpp) and, where its limit would bind, velocity (viscous_diffusion.hpp).
//
// Sources: pair conductance: Cleary & Monaghan (1999), J. Comput. Phys. 148:227, eq. (28) (harmonic mean: the flux is
// limited by the poorer conductor). Super-time-stepping: Meyer, Balsara & Aslam (2014), J. Comput. Phys. 257:594, RKL1 and
// RKL2, eqs. (15)-(18).
//
//   symbol  meaning                                  heat               velocity
//   u_i     potential                                T [C]              v [m/s]
//   R_i     resistivity                              1/k [m K/W]        1/mu [1/(Pa s)]
//   C_i     capacity                                 m c [J/K]          m [kg]
//   g_ij    V_i V_j L_ij 2 / (R_i + R_j)             [W/K]              [kg/s]
//   M_i     sum_j g_ij (u_j - u_i) + what else acts  [W]                [N]
//
// g_ij is bitwise symmetric in i, j, so what one particle of a pair gives the other gets: the sum of C u is conserved at any
// number of stages.
#pragma once

#include <cmath>

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// g_ij [W/K] or [kg/s]: V_i V_j L_ij 2/(R_i + R_j) with one division; resistivities = R_i + R_j. Symmetric to the last bit.
template <class T>
MELTSIM_HD T pair_conductance(T volume_i, T volume_j, const LaplacianQuotient<T>& l, T resistivities) {
  const T volumes = (T(2) * volume_i) * volume_j;  // the factor 2 is exact
  return volumes * l.above * (T(1) / (l.below * resistivities));
}

/// Coefficients of stage j of s of one super-step, acting on increments d_j = Y_j - Y_0 of the content C u:
///   d_j = mu d_{j-1} + nu d_{j-2} + mu_rate tau M(Y_{j-1}) + gamma_rate tau M(Y_0).
/// M uses potentials of Y and resistivities of Y_0. If resistivities followed Y, a jump where a particle begins
/// to melt would make M(Y_0) differ from the other stages, and most of the heat of that super-step would be lost.
struct SuperStage {
  double mu = 0, nu = 0, mu_rate = 1, gamma_rate = 0;  ///< as in the formula above
};

/// Coefficients of stage j = 1..s. s = 1: explicit Euler. s even: first-order Runge-Kutta-Legendre (RKL1; R(z) = 1 - z +
/// z^2/6 for s = 2). s odd: second order (RKL2). Two stages of first order are as accurate as three of second: at
/// tau lambda up to 6 (tau alpha/dx^2 up to 0.8 on the lattice) the error of the kernel sum exceeds that of time
/// integration. Numbers are in
/// docs/design/tried.md.
/// Scenes with a phase change use RKL1 with any number of stages: the heat capacity jumps, so order beyond the first is
/// lost, and RKL2 weighs M(Y_0) negatively: heat that flows at first, until melting holds the temperature, would be
/// subtracted again later. So does velocity: RKL1 damps what is stiff by more (to 1/sqrt(s), RKL2 to a half).
inline SuperStage super_stage(int j, int s) {
  if (s <= 1) return {};
  if (s % 2 == 0) {
    const double w1 = 2.0 / (double(s) * s + s);
    if (j == 1) return {0, 0, w1, 0};
    const double mu = (2.0 * j - 1.0) / j;
    return {mu, 1.0 - mu, mu * w1, 0};
  }
  const auto b = [](int i) { return i < 2 ? 1.0 / 3.0 : (double(i) * i + i - 2.0) / (2.0 * i * (i + 1.0)); };
  const double w1 = 4.0 / (double(s) * s + s - 2.0);
  if (j == 1) return {0, 0, b(1) * w1, 0};
  SuperStage c;
  c.mu = (2.0 * j - 1.0) / j * b(j) / b(j - 1);
  c.nu = -(j - 1.0) / j * b(j) / b(j - 2);
  c.mu_rate = c.mu * w1;
  c.gamma_rate = -(1.0 - b(j - 1)) * c.mu_rate;
  return c;
}

/// Largest stable tau lambda of s stages, lambda = 2 max_i sum_j g_ij/C_i (Gershgorin bound of the spectral
/// radius). Euler: up to 2 a new potential is a weighted mean of old ones, so it does not overshoot.
inline double stage_reach(int s) {
  if (s <= 1) return 2.0;
  return s % 2 == 0 ? double(s) * s + s : 0.5 * (double(s) * s + s - 2.0);
}

/// Sub-steps of motion that may share a step of heat. While particles move at c/10, four sub-steps at a Courant number of 0.4
/// take them by 0.16 H, less than half a spacing at H = 2.5 dx.
inline constexpr int most_shared_substeps = 4;
/// How many do, if each has tau lambda: two stages are enough for them.
inline int shared_substeps(double tau_lambda) {
  const double most = stage_reach(2) / tau_lambda;  // infinite where nothing conducts
  return most >= most_shared_substeps ? most_shared_substeps : most >= 2 ? static_cast<int>(most) : 1;
}

/// Stages needed for tau lambda: 1, 2, or the smallest odd s >= 5 that suffices; of first order the smallest even s.
inline int stage_count(double tau_lambda, bool first_order) {
  if (tau_lambda <= stage_reach(1)) return 1;
  if (tau_lambda <= stage_reach(2)) return 2;
  if (first_order) {
    const int s = static_cast<int>(std::ceil(0.5 * (std::sqrt(1.0 + 4.0 * tau_lambda) - 1.0)));
    return s + s % 2;
  }
  const int s = static_cast<int>(std::ceil(0.5 * (std::sqrt(9.0 + 8.0 * tau_lambda) - 1.0)));
  return s < 5 ? 5 : s | 1;
}

/// Most stages of a super-step of first order where matter melts or freezes. With more, temperatures leave the range of those around: between two phases
/// enthalpy is no linear function of temperature, as the method takes it to be. Ours, by trial (docs/design/tried.md).
inline constexpr int phase_stages = 8;

/// Largest number of stages that stage_count returns up to a given limit >= 2.
inline int most_stages(int given, bool first_order) {
  return given == 2 || (given % 2 == 0) == first_order ? given : given == 3 && first_order ? 2 : given - 1;
}

/// Super-steps that tau lambda is divided into where nothing moves, so that no sub-step of motion does: as many as two stages reach in each,
/// 12 at most. One of either order leaves up to half of what is stiff in it, however many stages it has, as the spectral radius of the kernel's sum
/// is some 0.55 of the bound lambda; the next halves that again.
inline double resting_supersteps(double tau_lambda) {
  return minimum(std::ceil(tau_lambda / stage_reach(2)), 12.0);
}

/// Stage j as kernels take it: SuperStage times tau, and where it stands.
template <class S>
struct StageFactors {
  S mu{}, nu{};          ///< of d_{j-1} and d_{j-2} [-]
  S rate{}, rate0{};     ///< of M(Y_{j-1}) and M(Y_0) [s]
  bool first{}, last{};  ///< of its super-step
  bool begins{};         ///< of the first super-step
  bool ends{};           ///< the last stage of the last super-step: its potentials are not needed any more
  /// The same in another precision.
  template <class U>
  StageFactors<U> as() const {
    return {static_cast<U>(mu),
            static_cast<U>(nu),
            static_cast<U>(rate),
            static_cast<U>(rate0),
            first,
            last,
            begins,
            ends};
  }
};

/// Stage j of s in a super-step of tau [s], the first or last of a sub-step or not.
inline StageFactors<double> stage_factors(int j, int s, double tau, bool first_super_step,
                                          bool last_super_step) {
  const SuperStage c = super_stage(j, s);
  StageFactors<double> f;
  f.mu = c.mu;
  f.nu = j == 2 ? 0.0 : c.nu;  // d_0 = 0 and is not stored
  f.rate = c.mu_rate * tau;
  f.rate0 = c.gamma_rate * tau;
  f.first = j == 1;
  f.last = j == s;
  f.begins = first_super_step;
  f.ends = f.last && last_super_step;
  return f;
}

/// d_j; rate = M(Y_{j-1}). last(), before_last() and first_rate() give d_{j-1}, d_{j-2} and M(Y_0), and are called where
/// those count only. V: a number or a vector.
template <class S, class V, class Last, class BeforeLast, class FirstRate>
MELTSIM_HD V next_increment(const StageFactors<S>& c, const V& rate, const Last& last,
                            const BeforeLast& before_last, const FirstRate& first_rate) {
  V d = rate * c.rate;
  if (c.first) return d;
  d += last() * c.mu;
  if (c.nu != S(0)) d += before_last() * c.nu;
  if (c.rate0 != S(0)) d += first_rate() * c.rate0;
  return d;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
