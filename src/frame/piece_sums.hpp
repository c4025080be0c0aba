// SPDX-License-Identifier: Apache-2.0
// Sums over a piece in fixed point, which do not depend on the order of addition.
#pragma once

#include <cmath>
#include <cstdint>

#include "meltsim/physics/math.hpp"
#include "meltsim/physics/rigid_push.hpp"
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

/// Values far beyond the range of a sum are limited to that of an integer; the World then halts anyway.
MELTSIM_HD std::int64_t counted(double value, const SumUnit& unit) {
  constexpr double most = 4e18;
  return static_cast<std::int64_t>(std::rint(clamp(value * unit.per, -most, most)));
}
MELTSIM_HD void count(Vec3<double> value, const SumUnit& unit, std::int64_t (&to)[3]) {
  to[0] = counted(value.x, unit);
  to[1] = counted(value.y, unit);
  to[2] = counted(value.z, unit);
}
MELTSIM_HD Vec3<double> sum_of(const std::int64_t (&n)[3], const SumUnit& unit) {
  return {static_cast<double>(n[0]) * unit.size, static_cast<double>(n[1]) * unit.size,
          static_cast<double>(n[2]) * unit.size};
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

/// What physics::MassSums of a body may come to: units of its sums follow from it.
struct MassReach {
  double mass = 0, distance2 = 0;  ///< the largest of a particle [kg], and of u^2 [m^2]
  std::uint64_t count = 0;
  MELTSIM_HD static MassReach combine(MassReach a, const MassReach& b) {
    a.mass = maximum(a.mass, b.mass);
    a.distance2 = maximum(a.distance2, b.distance2);
    a.count += b.count;
    return a;
  }
  MELTSIM_HD SumUnits units() const {
    const double m = mass * static_cast<double>(count) * 0x1p-61, u = std::sqrt(distance2);
    return sum_units(m, 0, 0, m * u, m * u * u);
  }
};

/// physics::MassSums as integers.
struct MassCounts {
  std::int64_t mass = 0, first[3] = {}, second[6] = {};  ///< xx, yy, zz, yz, zx, xy
  MELTSIM_HD void count(const SumUnits& units, double m, Vec3<double> u) {
    mass = counted(m, units.mass);
    core::count(u * m, units.first, first);
    const double squares[6] = {u.x * u.x, u.y * u.y, u.z * u.z, u.y * u.z, u.z * u.x, u.x * u.y};
    for (int k = 0; k < 6; ++k) second[k] = counted(squares[k] * m, units.second);
  }
  MELTSIM_HD static MassCounts combine(MassCounts a, const MassCounts& b) {
    a.mass += b.mass;
    for (int k = 0; k < 3; ++k) a.first[k] += b.first[k];
    for (int k = 0; k < 6; ++k) a.second[k] += b.second[k];
    return a;
  }
  MELTSIM_HD physics::MassSums sums(const SumUnits& units) const {
    const auto part = [&](int k) { return static_cast<double>(second[k]) * units.second.size; };
    Sym3<double> squares;
    squares.diagonal = {part(0), part(1), part(2)};
    squares.mixed = {part(3), part(4), part(5)};
    return {static_cast<double>(mass) * units.mass.size, sum_of(first, units.first), to_matrix(squares)};
  }
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
