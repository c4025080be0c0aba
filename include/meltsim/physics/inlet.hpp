// SPDX-License-Identifier: Apache-2.0
// Open faces beyond which liquid stands at a level: it comes in and goes out.
//
// Sources: characteristics of shallow water (Stoker 1957, Water Waves, ch. 10; Flather 1976, Mem. Soc. R. Sci. Liege 10:141;
// Blayo & Debreu 2005, Ocean Modelling 9:231, sec. 3): u + 2 sqrt(g h) arrives at the face from inside, u - 2 sqrt(g h) of liquid
// at rest from beyond. Liquid near the face moves at the velocity that both have in common, as the paddle of a flume that
// absorbs waves (Schaeffer & Klopman 2000, J. Waterway Port Coast. Ocean Eng. 126:88):
//
//   R    = u + 2 sqrt(g h)
//   u_b  = max(R/2 - c_L, -2 c_L/3),   c_L = sqrt(g h_L)              m/s
//   h_b  = (R/2 + c_L)^2/(4 g),  4 h_L/9 where u_b is at its bound    m
//   u_p  = u_b h_b/(n dx) where liquid comes in, n = round(h_b/dx); else u_b
//   du/dt = (u_p - u)/tau,   tau = H/c_L                              m/s^2
//   h    = sum w V/(B H),   u = sum w V v.n / sum w V,   w = 1 - 3 s^2 + 2 s^3,   s = |d/H - 2| < 1
//
//   symbol    meaning                                                               unit
//   u_b, h_b  velocity out of the face and depth there                              m/s, m
//   u         in the last line but one: velocity of the liquid within H of the face m/s
//   h_L       height of the level beyond above the floor                            m
//   B         breadth of the face                                                   m
//   d         distance from the face                                                m
//   n         outward unit normal; of layers: how many of them come in              -
//
// So a channel between two levels flows at c_1 - c_2, a closed one fills to the level, and long waves leave, troughs and crests. The
// bound is critical flow, of a reservoir that empties into a dry channel (Ritter 1892). u_p carries the flux of h_b in whole layers.
// What is measured between H and 3 H from the face reaches the liquid that is moved H/c_L later: hence tau, whose second-order
// error leaves a reflection of (omega tau)^2/2 of a wave of angular frequency omega.
//
// Deviations: pressure over the depth is hydrostatic and the floor the domain's; what stands on it within 3 H of the face counts as no
// liquid. Across a bore that comes in, R is taken as constant. What moves with the face is moved as a whole, so it keeps its depth.
#pragma once

#include "meltsim/physics/outlet.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Velocity and depth at a face; out of it velocities are positive.
struct InletFlow {
  double speed = 0;  ///< [m/s]
  double depth = 0;  ///< [m]
};

/// Liquid ahead of such a face. Whole numbers and a maximum, so that the order of the particles does not matter.
struct InletSums {
  static constexpr double nothing = -1e300;  ///< of `moved`: there is no such liquid
  OutletSums ahead;                          ///< sum w V, sum w V v.n
  double moved = nothing;  ///< velocity of the liquid that moves with the face; nothing: there is none
  MELTSIM_HD static InletSums combine(InletSums a, const InletSums& b) {  ///< of both
    a.ahead = OutletSums::combine(a.ahead, b.ahead);
    a.moved = maximum(a.moved, b.moved);
    return a;
  }
};

/// w at a distance from the face, in support radii: smooth, so that layers that come and go do not change the sum.
template <class T>
MELTSIM_HD T inlet_weight(T distance) {
  const T s = minimum(T(1), std::fabs(distance - T(0.5 * (outlet_reach + outlet_end))));
  return T(1) + s * s * (T(2) * s - T(3));
}

/// u_b and h_b. `ahead` over an area of B H [m^2] of the floor.
MELTSIM_HD InletFlow inlet_flow(const OutletSums& ahead, double spacing, double sound_speed, double area,
                                double head, double gravity) {
  const double beyond = std::sqrt(gravity * head);
  double arriving = 0;
  if (ahead.volume > 0) {
    const double volume = static_cast<double>(ahead.volume) / OutletSums::volume_units;
    const double flow = static_cast<double>(ahead.flow) / OutletSums::flow_units * sound_speed;
    arriving = flow / volume + 2 * std::sqrt(gravity * volume * spacing * spacing * spacing / area);
  }
  const double critical = -2 * beyond / 3;
  InletFlow b;
  b.speed = 0.5 * arriving - beyond;
  double wave = 0.5 * (0.5 * arriving + beyond);
  if (!(b.speed > critical)) {
    b.speed = critical;
    wave = -critical;
  }
  b.depth = gravity > 0 ? wave * wave / gravity : 0;
  return b;
}

/// u_p of whole layers of this thickness.
MELTSIM_HD double inlet_speed(const InletFlow& b, double layer) {
  if (!(b.speed < 0)) return b.speed;
  const double layers = std::floor(b.depth / layer + 0.5);
  return layers < 1 ? 0.0 : b.speed * (b.depth / (layers * layer));
}

/// u after dt.
MELTSIM_HD double inlet_approach(double speed, double wanted, double dt, double support, double head,
                                 double gravity) {
  const double tau = gravity > 0 ? support / std::sqrt(gravity * head) : 0.0;
  return speed + (wanted - speed) * (dt / (tau + dt));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
