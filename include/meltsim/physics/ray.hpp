// SPDX-License-Identifier: Apache-2.0
// Rays against boxes and surfaces between particles.
//
// Sources: a box as slabs: Kay & Kajiya 1986, SIGGRAPH, 269. Surfaces as level sets of the smoothed volume fraction: sampling.hpp.
//
//   symbol   meaning                                                                      unit
//   o, u, t  origin of the ray, its direction as a unit vector, distance along it         m, -, m
//   f_S      volume fraction of solids, images in walls included (sampling.hpp)           -
//   g        excess of liquid over empty space (sampling.hpp)                             -
//   dx       spacing                                                                      m
//
// A point is in a body where f_S > 1/2 or a solid particle is nearer than dx/2: on a flat face both end half a spacing outside
// the outermost particles, where the sampled shape does; the second one is for parts too thin for the first. It is in liquid where
// g > 0.
#pragma once

#include <cstdint>

#include "meltsim/physics/sampling.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// The part of a ray within a box; enter > leave: none.
struct RaySpan {
  double enter = 0, leave = -1;  ///< distances along the ray [m]
  int face = -1;                 ///< through which it leaves: 0 to 5; -1: it ends inside
};

/// A ray of a length against a box [low, high].
MELTSIM_HD RaySpan ray_in_box(Vec3<double> o, Vec3<double> u, Vec3<double> low, Vec3<double> high,
                              double length) {
  RaySpan s{0, length, -1};
  const double from[3] = {o.x, o.y, o.z}, along[3] = {u.x, u.y, u.z}, a[3] = {low.x, low.y, low.z},
               b[3] = {high.x, high.y, high.z};
  for (int k = 0; k < 3; ++k) {
    if (along[k] == 0) {
      if (from[k] < a[k] || from[k] > b[k]) return {};
      continue;
    }
    const double to_low = (a[k] - from[k]) / along[k], to_high = (b[k] - from[k]) / along[k];
    const double in = along[k] > 0 ? to_low : to_high, out = along[k] > 0 ? to_high : to_low;
    s.enter = maximum(s.enter, in);
    if (!(out < s.leave)) continue;
    s.leave = out;
    s.face = 2 * k + (along[k] > 0 ? 1 : 0);
  }
  return s;
}

/// What is at a point.
enum class Medium : std::uint32_t { nothing, liquid, body };

/// Sums around a point, and what is nearest to it there.
template <class T>
struct MediumSums {
  FillSums<T> fill;  ///< volume fractions
  T nearest_solid2 =
      static_cast<T>(INFINITY);  ///< square of the distance of the nearest solid particle [m^2]
  T nearest_liquid2 = static_cast<T>(INFINITY);  ///< likewise of liquid [m^2]
};

/// f_S less the 1/2 of a body's surface; g of liquid's: both grow inwards.
template <class T>
MELTSIM_HD T surface_level(const SphKernel<T>& k, const MediumSums<T>& s, Medium of) {
  return of == Medium::body ? k.w_scale * s.fill.solid - T(0.5) : liquid_excess(k, s.fill);
}

/// What is at a point. Bit 0 of `sought`: liquid counts; bit 1: bodies do.
template <class T>
MELTSIM_HD Medium medium_at(const SphKernel<T>& k, T spacing, const MediumSums<T>& s, std::uint32_t sought) {
  if ((sought & 2u) != 0u &&
      (surface_level(k, s, Medium::body) > T(0) || s.nearest_solid2 < T(0.25) * spacing * spacing))
    return Medium::body;
  if ((sought & 1u) != 0u && surface_level(k, s, Medium::liquid) > T(0)) return Medium::liquid;
  return Medium::nothing;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
