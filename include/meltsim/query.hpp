// SPDX-License-Identifier: Apache-2.0
// Spatial queries: rays and shapes against the present state of a World.
#pragma once

#include <cstdint>
#include <vector>

#include "meltsim/handle.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

/// A ray of World::cast_rays.
struct Ray {
  Vec3d origin;              ///< where it begins [m]
  Vec3d direction{0, 0, 1};  ///< of any length but 0
  double length = infinity;  ///< how far it looks [m]; > 0
};

inline constexpr std::uint32_t ray_liquid = 1;  ///< rays end at the surface of liquid
inline constexpr std::uint32_t ray_bodies = 2;  ///< rays end at bodies
inline constexpr std::uint32_t ray_walls = 4;   ///< rays end at walls, from inside the domain
inline constexpr std::uint32_t ray_all = 7;     ///< all of these

/// Kinds of things that a ray ends at.
enum class RayTarget : std::uint32_t { nothing, liquid, body, wall };

/// Where a ray ends.
struct RayHit {
  RayTarget what = RayTarget::nothing;   ///< what is there
  double distance = infinity;            ///< from the ray's origin [m]; 0: it begins inside
  Vec3d point;                           ///< [m]; the origin if there is nothing
  Vec3d normal;                          ///< of the surface, outward: a unit vector; 0 if there is nothing
  BodyId body;                           ///< null but for a body
  int wall = -1;                         ///< 0 to 5, in the order of DomainDesc::faces; -1 but for a wall
  std::uint32_t particle = 0xffffffffu;  ///< id of the nearest particle of what is there; none of a wall
};

/// A body within a shape.
struct BodyOverlap {
  BodyId body;                  ///< the body
  std::uint64_t particles = 0;  ///< its particles whose centres are in the shape
};

/// Contents of a shape: World::overlap.
struct Overlap {
  std::uint64_t liquid = 0;  ///< liquid particles whose centres are in the shape
  double liquid_volume = 0;  ///< their volume at rest [m^3]
  std::vector<BodyOverlap>
      bodies;  ///< those with a particle in the shape, in the order in which they were added
};

}  // namespace v0
}  // namespace meltsim
