// SPDX-License-Identifier: Apache-2.0
// The kinematic viscosity that is equivalent to the artificial viscosity of fluid.hpp.
//
//   symbol  meaning                                          unit
//   alpha   WorldDesc::artificial_viscosity                  -
//   c       sound speed                                      m/s
//   h       smoothing length, half the support radius H      m
#pragma once

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Kinematic viscosity [m^2/s] equivalent to artificial_pressure in a shear flow: alpha c h / 20. Monaghan (2005), Rep. Prog.
/// Phys. 68:1703, sec. 8, has alpha c h / 10 in three dimensions if all pairs count. Deviations: only approaching pairs count,
/// in a shear flow half of them; and it is that of liquid under pressure, since bounded_artificial_pressure takes
/// from what nothing presses.
inline double artificial_kinematic_viscosity(double alpha, double sound_speed, double support) {
  return alpha * sound_speed * 0.5 * support / 20;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
