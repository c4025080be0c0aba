// SPDX-License-Identifier: Apache-2.0
// Sums over a rigid piece in fixed point, which do not depend on the order of addition.
#pragma once

#include <cmath>
#include <cstdint>

#include "frame/piece_sums.hpp"
#include "meltsim/physics/rigid_piece.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// physics::RigidPieceSums as integers, in the units of SumUnits.
struct RigidSums {
  std::int64_t mass = 0;
  std::int64_t first[3] = {}, rest_first[3] = {}, rest_second[6] = {};  ///< xx, yy, zz, yz, zx, xy
  std::int64_t momentum[3] = {}, spin[3] = {}, kicked_momentum[3] = {}, kicked_spin[3] = {};
  static constexpr int words = 25;  ///< all of them, one after the other
};
static_assert(sizeof(RigidSums) == RigidSums::words * sizeof(std::int64_t));

/// One particle: mass m, u, q, v and v' as in physics/rigid_piece.hpp.
MELTSIM_HD void count_particle(RigidSums& s, const SumUnits& units, double m, Vec3<double> u, Vec3<double> q,
                               Vec3<double> v, Vec3<double> kicked) {
  s.mass = counted(m, units.mass);
  count(u * m, units.first, s.first);
  count(q * m, units.first, s.rest_first);
  const double second[6] = {q.x * q.x, q.y * q.y, q.z * q.z, q.y * q.z, q.z * q.x, q.x * q.y};
  for (int k = 0; k < 6; ++k) s.rest_second[k] = counted(second[k] * m, units.second);
  count(v * m, units.momentum, s.momentum);
  count(cross(u, v) * m, units.spin, s.spin);
  count(kicked * m, units.momentum, s.kicked_momentum);
  count(cross(u, kicked) * m, units.spin, s.kicked_spin);
}

MELTSIM_HD physics::RigidPieceSums rigid_sums_of(const RigidSums& s, const SumUnits& units) {
  physics::RigidPieceSums r;
  r.mass = static_cast<double>(s.mass) * units.mass.size;
  r.first = sum_of(s.first, units.first);
  r.rest_first = sum_of(s.rest_first, units.first);
  Sym3<double> second;
  const auto part = [&](int k) { return static_cast<double>(s.rest_second[k]) * units.second.size; };
  second.diagonal = {part(0), part(1), part(2)};
  second.mixed = {part(3), part(4), part(5)};
  r.rest_second = to_matrix(second);
  r.momentum = sum_of(s.momentum, units.momentum);
  r.spin = sum_of(s.spin, units.spin);
  r.kicked_momentum = sum_of(s.kicked_momentum, units.momentum);
  r.kicked_spin = sum_of(s.kicked_spin, units.spin);
  return r;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
