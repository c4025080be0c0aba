// SPDX-License-Identifier: Apache-2.0
// How the inside of a body follows its mesh, and where a point of it is at a time.
//
// Source: a point inside a closed surface as a weighted mean of points on it, Floater (2003), Mean value coordinates; Ju,
// Schaefer & Warren (2005), Mean value coordinates for closed triangular meshes; what it sees of the surface, Lipman, Kopf,
// Cohen-Or & Levin (2007), GPU-assisted positive mean value coordinates. A chord through the point p along an axis a ends at
// the surface at p - d1 a and p + d2 a, so p = (d2 x1 + d1 x2)/(d1 + d2); so do the ends of the chord once the mesh has moved.
//
//   d1, d2  distances to the surface along an axis, as built        m
//   x1, x2  ends of the chord                                       m
//   u       weight of an axis                                       1/m^4
//
// Deviations: three chords (x, y, z) stand for all directions, and the weight of a chord falls as (d1 d2)^-2 where mean value
// coordinates have 1/d1 + 1/d2: a long chord through a bent body cuts its bend off and then counts little. All weights are
// positive, and every affine map of the mesh moves the inside by the same map.
//
//   x(i)    place of a site of the lattice                          m
//   F       (x(i+1) - x(i-1))/(2 dx) per axis                       -
//   V       dx^3 |det F|, the volume of a site                      m^3
//
// Liquid sums volumes (coupling.hpp), so the sites of a body that is squeezed hold less, and of one that is stretched more: a wall
// squeezed to two thirds of its height would else push liquid as if it were half as dense again. On a face of the body F is
// one-sided; across a body one site thick it is 1.
//
// Between two poses points move at constant velocity, from the later one on at the velocity that the host gave.
#pragma once

#include <cmath>
#include <cstdint>

#include "meltsim/physics/rigid_motion.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Weight of the chord that ends at distances d1 and d2.
MELTSIM_HD double chord_weight(double d1, double d2) { return 1 / (d1 * d2 * (d1 * d2)); }

/// A point of a body whose mesh moves, relative to the pivot in the frame of the body as built.
struct MeshPoint {
  Vec3<double> first{};     ///< place at `from` [m]
  Vec3<double> then{};      ///< place at `until` [m]
  Vec3<double> velocity{};  ///< from `until` on [m/s]
  double from = 0;          ///< [s]
  double until = 0;         ///< [s]
};

/// Where it is at a time [s] and how fast it moves, in that frame.
MELTSIM_HD RigidPoint mesh_point_at(const MeshPoint& p, double time) {
  if (!(time < p.until)) return {p.then + p.velocity * (time - p.until), p.velocity};
  const double span = p.until - p.from, share = (time - p.from) / span;
  const Vec3<double> way = p.then - p.first;
  return {p.first + way * share, way * (1 / span)};
}

/// The same in space, of a body that is at `place`.
MELTSIM_HD RigidPoint moved_point_of(const RigidPlace& place, const RigidPoint& local) {
  RigidPoint p = point_of(place, local.position);
  p.velocity += rotate(place.orientation, local.velocity);
  return p;
}

/// V/dx^3 stays within this and its inverse: a mesh that is folded flat leaves no site without volume.
inline constexpr double most_volume_change = 20;

/// V/dx^3 of a site. x, y, z: columns of F; known: bit per column, clear across a body one site thick.
MELTSIM_HD double volume_ratio(Vec3<double> x, Vec3<double> y, Vec3<double> z, std::uint32_t known) {
  double ratio = 1;
  if (known == 7u) ratio = std::fabs(dot(cross(x, y), z));
  else if (known == 3u) ratio = length(cross(x, y));
  else if (known == 5u) ratio = length(cross(x, z));
  else if (known == 6u) ratio = length(cross(y, z));
  else if (known != 0u) ratio = length((known & 1u) != 0u ? x : (known & 2u) != 0u ? y : z);
  return ratio < 1 / most_volume_change ? 1 / most_volume_change
         : ratio > most_volume_change   ? most_volume_change
                                        : ratio;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
