// SPDX-License-Identifier: Apache-2.0
// Particle shifting: liquid's particles move slightly towards where there are fewer, beside the flow.
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
// Why it is needed: a flow that strains steadily squeezes a lattice into strings. Every lattice, however
// strained, has sum V grad W = 0, so neither the pressure nor Fick's law sees it; the pairs that come close
// are seen by the R term, which is why R is ten times what is usual for particles that start disordered
// (Taylor-Green at Re 100, 24^2, K = 0.2: decay rate 41 % off at R = 0, 17 % at 0.2, 1 % at 1).
// Deviations: c in place of 10 u_max, so that no maximum over all particles is needed; K = 0.1 with H = 2h is
// then what Sun et al. use (their CFL * Ma * 4 h^2 with Ma 0.1). Velocities stay what they are: momentum is
// exact, and a uniform motion is none (flux terms v dr are either not conservative or not Galilean
// invariant; their first order, dr.grad v, was tried and slows the decay by 8 to 10 %). At a free surface,
// where G points out of the liquid, s turns shifting off instead of its normal part: on the lattice the
// outermost layer has phi = 0.80, the next 0.998.
// So liquid moves with v + dr/dt, which is smoother than v: shifts undo the part of v that is as small as the
// lattice, and oppose its peaks. In the heated cavity (heat.cavity) shifts are 0.4 of the largest velocity
// (rms); the peak of v is 12 % above that of the motion at 40 cells, 22 % at 20. Who measures a flow takes
// displacements. (To take the kernel mean of the shifts off, one more sweep, was tried: v comes within 8 %
// instead of 28 % of the motion in a cavity of 20 cells, but motion and the heat it carries stay the same.)
// Limit: for liquid that fills its domain (with tension) only. Below a free surface the second layer has
// G = 0.018/dx for want of a layer above; that lifts it, and a tank of 8 layers at rest is stirred to 0.8 m/s
// rms within 4 s. Letting the lowest phi among the neighbours decide, which leaves three layers alone, gave
// 0.7 m/s.
#pragma once

#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

inline constexpr double shift_rate = 0.1;      ///< K
inline constexpr double shift_repulsion = 2;   ///< R
inline constexpr double shift_limit = 0.05;    ///< spacings per sub-step
inline constexpr double shift_from_phi = 0.9;  ///< s is 0 there
inline constexpr double shift_full_phi = 1;    ///< s is 1 there

/// What j adds to G_i [1/m]; inv_w_dx = 1/W(dx).
template <class T>
MELTSIM_HD Vec3<T> shift_term(const SphKernel<T>& k, T inv_w_dx, T volume_j, T r, Vec3<T> x_ij) {
  const T q = kernel_value(k, r) * inv_w_dx, q2 = q * q;
  return x_ij *
         (volume_j * kernel_gradient_factor(k, r) * (T(1) + static_cast<T>(shift_repulsion) * q2 * q2));
}

/// s(phi): how far a particle is inside the liquid.
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
