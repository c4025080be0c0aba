// SPDX-License-Identifier: Apache-2.0
// Sums over a piece in fixed point, which do not depend on the order of addition.
#pragma once

#include <cmath>
#include <cstdint>

#include "meltsim/physics/math.hpp"
#include "meltsim/physics/shape_matching.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Exact sums over a piece: integers in units chosen by the host, so that no order of addition changes a bit.
struct PieceSums {
  std::int64_t mass = 0;
  std::int64_t momentum[3] = {}, spin[3] = {}, first[3] = {}, second[6] = {};
  static constexpr int words = 16;  ///< all of them, one after the other
};
static_assert(sizeof(PieceSums) == PieceSums::words * sizeof(std::int64_t));

/// The quantity that one integer of a sum stands for, a power of two, and its reciprocal.
struct SumUnit {
  double size = 1, per = 1;
};

/// Units of mass [kg], momentum [kg m/s], spin [kg m^2/s], first moment [kg m] and second moment [kg m^2].
struct SumUnits {
  SumUnit mass, momentum, spin, first, second;
};

/// Units at least as large as these and at most twice as large.
MELTSIM_HD SumUnits sum_units(double mass, double momentum, double spin, double first, double second) {
  const auto unit = [](double least) {
    constexpr double smallest = 1e-290, largest = 1e290;  // both powers below are numbers
    const int exponent = std::ilogb(clamp(least, smallest, largest)) + 1;
    return SumUnit{std::ldexp(1.0, exponent), std::ldexp(1.0, -exponent)};
  };
  return {unit(mass), unit(momentum), unit(spin), unit(first), unit(second)};
}

MELTSIM_HD physics::RigidResidual residual_of(const PieceSums& s, const SumUnits& q) {
  physics::RigidResidual r;
  const auto d = [](std::int64_t n, const SumUnit& unit) { return static_cast<double>(n) * unit.size; };
  r.mass = d(s.mass, q.mass);
  r.momentum = {d(s.momentum[0], q.momentum), d(s.momentum[1], q.momentum), d(s.momentum[2], q.momentum)};
  r.spin = {d(s.spin[0], q.spin), d(s.spin[1], q.spin), d(s.spin[2], q.spin)};
  r.first = {d(s.first[0], q.first), d(s.first[1], q.first), d(s.first[2], q.first)};
  const double xx = d(s.second[0], q.second), yy = d(s.second[1], q.second), zz = d(s.second[2], q.second);
  const double yz = d(s.second[3], q.second), zx = d(s.second[4], q.second), xy = d(s.second[5], q.second);
  r.second.m[0][0] = xx;
  r.second.m[1][1] = yy;
  r.second.m[2][2] = zz;
  r.second.m[1][2] = r.second.m[2][1] = yz;
  r.second.m[0][2] = r.second.m[2][0] = zx;
  r.second.m[0][1] = r.second.m[1][0] = xy;
  return r;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
