// SPDX-License-Identifier: Apache-2.0
// Particle shifting: liquid particles move slightly down the gradient of their concentration, in addition to the flow.
//
// Sources: Lind, Xu, Stansby & Rogers (2012), J. Comput. Phys. 231:1499, eq. (20) (Fick's law for the
// concentration of particles); Sun, Colagrossi, Marrone & Zhang (2017), Comput. Methods Appl. Mech. Engrg.
// 315:25, eq. (14) (the displacement in units of the step; the term against clusters is Monaghan 2000, J.
// Comput. Phys. 159:290).
//
//   symbol  meaning                                                              unit
//   G_i     -sum_j V_j (1 + R (W_ij/W(dx))^4) grad_i W_ij, j liquid, solid, images    1/m
//   dr_i    K c dt H s(phi_i) G_i, no longer than 0.05 dx                         m
//   K       0.1, R 2                                                             -
//   s       0 at phi <= 0.9, 1 at phi >= 1, linear between                        -
//
// Why it is needed: a steady strain squeezes a lattice into strings. Every lattice, however strained, has
// sum V grad W = 0, so neither the pressure nor Fick's law reacts to it; the R term reacts to pairs that come
// close. R is therefore ten times the usual value, which is meant for particles that start disordered
// (docs/validation.md: liquid.taylor_green).
// Deviations: c replaces 10 u_max, so that no maximum over all particles is needed; K = 0.1 with H = 2h then
// equals the value of Sun et al. (their CFL * Ma * 4 h^2 with Ma = 0.1). Velocities are not corrected:
// momentum is exact, and a uniform motion causes no shift (flux terms v dr are either not conservative or
// not Galilean invariant; their first order, dr.grad v, slows the decay of vortices). At a free surface,
// where G points out of the liquid, s switches off the whole shift, not only its normal part: on the lattice
// the outermost layer has phi = 0.80, the next 0.998.
// Liquid moves with v + dr/dt, which is smoother than v: shifts remove the part of v on the scale of the
// lattice, and oppose its peaks. In the heated cavity (heat.cavity) shifts are 0.4 of the largest velocity
// (rms), and the peak of v is 12 % above that of the motion at 40 cells, 22 % at 20. So measure a flow by
// displacements. Subtracting the kernel mean of the shifts, at the cost of one more sweep, would bring v
// closer to the motion, but would change neither the motion nor the heat that it carries.
// Limit: for liquid that fills its domain (with tension) only. Below a free surface the second layer has
// G = 0.018/dx because there is only one layer above; that lifts it and stirs a tank at rest
// (docs/limits.md). A switch by the lowest phi among the neighbours, which exempts three layers,
// does not prevent it.
#pragma once

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

inline constexpr double shift_rate = 0.1;      ///< K
inline constexpr double shift_repulsion = 2;   ///< R
inline constexpr double shift_limit = 0.05;    ///< spacings per sub-step
inline constexpr double shift_from_phi = 0.9;  ///< s is 0 up to this phi
inline constexpr double shift_full_phi = 1;    ///< s is 1 from this phi on

/// Term of j in G_i [1/m]; inv_w_dx = 1/W(dx) [m^3].
template <class T>
MELTSIM_HD Vec3<T> shift_term(const SphKernel<T>& k, T inv_w_dx, T volume_j, T r, Vec3<T> x_ij) {
  const T q = kernel_value(k, r) * inv_w_dx, q2 = q * q;
  return x_ij *
         (volume_j * kernel_gradient_factor(k, r) * (T(1) + static_cast<T>(shift_repulsion) * q2 * q2));
}

/// s(phi) [-]: 0 at a free surface, 1 inside.
template <class T>
MELTSIM_HD T shift_share(T phi) {
  return clamp((phi - static_cast<T>(shift_from_phi)) * static_cast<T>(1 / (shift_full_phi - shift_from_phi)),
               T(0), T(1));
}

/// dr_i [m].
template <class T>
MELTSIM_HD Vec3<T> shift_displacement(const SphKernel<T>& k, T spacing, T sound_speed, T dt, T phi,
                                      Vec3<T> g) {
  const Vec3<T> dr = g * (static_cast<T>(shift_rate) * sound_speed * dt * k.support * shift_share(phi));
  const T most = static_cast<T>(shift_limit) * spacing, l = length(dr);
  return l > most ? dr * (most / l) : dr;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
