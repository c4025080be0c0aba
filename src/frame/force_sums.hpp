// SPDX-License-Identifier: Apache-2.0
// Impulses on a body in fixed point, whose sum does not depend on the order of addition, and their sum over sub-steps.
#pragma once

#include <cstdint>

#include "frame/rigid_sums.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// An impulse and its moment as integers.
struct ImpulseSum {
  std::int64_t impulse[3] = {}, spin[3] = {};  ///< in units of SumUnits::momentum and spin
};

/// Impulses on a body in a sub-step. Positions are relative to a point of reference.
struct ForceSums {
  std::int64_t mass = 0, first[3] = {};  ///< of its particles
  ImpulseSum all, pressure, contact;     ///< all: also viscosity; without gravity
  static constexpr int words = 22;       ///< all of them, one after the other
};
static_assert(sizeof(ForceSums) == ForceSums::words * sizeof(std::int64_t));

/// Enthalpies at the end of a sub-step less those at its beginning. Every enthalpy is rounded by itself, so that what one
/// sub-step adds the next one takes away, and no rounding adds up.
struct HeatSums {
  std::int64_t enthalpy = 0;
  static constexpr int words = 1;  ///< all of them
};
static_assert(sizeof(HeatSums) == HeatSums::words * sizeof(std::int64_t));

/// Unit of enthalpy sums [J] from that of mass sums [kg]: 2^30 J/kg, more than any material holds.
MELTSIM_HD SumUnit heat_unit(const SumUnit& mass) {
  constexpr double most = 1073741824.0;
  return {mass.size * most, mass.per / most};
}

/// An impulse [N s] and an angular impulse [N m s].
struct Impulses {
  Vec3<double> linear{}, angular{};
};

/// Sums over the sub-steps since the host took them. A World that halts keeps those of its last good sub-step.
struct BodyForceTotals {
  double seconds = 0;     ///< that they cover
  Vec3<double> center{};  ///< of mass, in the middle of the last sub-step, in stored coordinates [m]
  Impulses all, pressure, contact;  ///< angular: about the centre, or the pivot of a kinematic body or proxy
  double heat = 0;                  ///< enthalpy that its particles gained [J]
};

/// Adds a force [N] over dt [s] at a place relative to the point of reference.
MELTSIM_HD void count_impulse(ImpulseSum& s, const SumUnits& units, Vec3<double> arm, Vec3<double> force,
                              double dt) {
  const Vec3<double> impulse = force * dt;
  count(impulse, units.momentum, s.impulse);
  count(cross(arm, impulse), units.spin, s.spin);
}

/// The sum, its moment about a point at `center` from the point of reference.
MELTSIM_HD Impulses impulses_of(const ImpulseSum& s, const SumUnits& units, Vec3<double> center) {
  const Vec3<double> linear = sum_of(s.impulse, units.momentum);
  return {linear, sum_of(s.spin, units.spin) - cross(center, linear)};
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
