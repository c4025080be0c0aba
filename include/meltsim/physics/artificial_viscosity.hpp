// SPDX-License-Identifier: Apache-2.0
// What the artificial viscosity of fluid.hpp amounts to.
//
//   symbol  meaning                                          unit
//   alpha   WorldDesc::artificial_viscosity                  -
//   c       sound speed                                      m/s
//   h       smoothing length, half the support radius H      m
#pragma once

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Kinematic viscosity [m^2/s] that artificial_pressure amounts to in a shear flow: alpha c h / 20. Monaghan (2005), Rep.
/// Prog. Phys. 68:1703, sec. 8: alpha c h / 10 in three dimensions where all pairs count. Deviation: only pairs that approach
/// count, in a shear flow half of all.
inline double artificial_kinematic_viscosity(double alpha, double sound_speed, double support) {
  return alpha * sound_speed * 0.5 * support / 20;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
