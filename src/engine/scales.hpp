// SPDX-License-Identifier: Apache-2.0
// Scales of the scene from which the arguments of a sub-step are computed, in double.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/scene.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

struct Scales {
  double largest_mass = 1, spacing = 1, support_in_spacings = 2.5, body_size = 1;  ///< kg, m, -, spacings
  double spring_dt = 1, largest_modulus_rate = 0;                                  ///< s, 1/s^2
  int sum_bits = 40;                                                               ///< of lsm.balance
  bool operator==(const Scales& o) const {
    return largest_mass == o.largest_mass && spacing == o.spacing &&
           support_in_spacings == o.support_in_spacings && body_size == o.body_size &&
           spring_dt == o.spring_dt && largest_modulus_rate == o.largest_modulus_rate &&
           sum_bits == o.sum_bits;
  }
};

/// 63 bits hold the sum of all vertices, each at most a few units of motion: 6 bits of head room.
inline int sum_bits_of(const SceneLattice& l) {
  return 56 - static_cast<int>(std::ceil(std::log2(double(l.vertex_site.size()) + 1.0)));
}

/// The largest of a body's extents, from its vertices on [spacings].
inline double body_size_from(const SceneLattice& l, std::size_t first_vertex, double size) {
  Vec3i low{}, high{};
  for (std::size_t v = first_vertex, body = core::none; v < l.vertex_coordinates.size(); ++v) {
    const Vec3i p = l.vertex_coordinates[v];
    if (l.vertex_body[v] != body) low = high = p;
    body = l.vertex_body[v];
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    size = std::max({size, high.x - low.x + 1.0, high.y - low.y + 1.0, high.z - low.z + 1.0});
  }
  return size;
}

/// With the body that was added last.
inline void extend(Scales& s, const SceneLattice& l, const AddedBody& a) {
  s.largest_mass = std::max(s.largest_mass, a.largest_mass);
  s.sum_bits = sum_bits_of(l);
  s.body_size = body_size_from(l, a.first_vertex, s.body_size);
}

inline Scales scales_of(const SceneConstants& c, const SceneLattice& l) {
  Scales s;
  s.largest_mass = c.largest_mass > 0 ? c.largest_mass : 1.0;
  s.spacing = c.spacing;
  s.support_in_spacings = c.support / c.spacing;
  s.spring_dt = c.spring_dt;
  for (const MaterialRow<double>& m : c.materials)
    s.largest_modulus_rate = std::max(s.largest_modulus_rate, m.modulus_rate);
  s.sum_bits = sum_bits_of(l);
  s.body_size = body_size_from(l, 0, s.body_size);
  return s;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
