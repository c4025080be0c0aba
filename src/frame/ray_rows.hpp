// SPDX-License-Identifier: Apache-2.0
// Rays as passed to an engine, in double and stored coordinates, and where they end.
#pragma once

#include <cstdint>

#include "meltsim/physics/ray.hpp"
#include "meltsim/query.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

struct RayQuery {
  Vec3<double> from{}, along{};  ///< along: a unit vector
  double length = 0;             ///< [m]
};

struct RayRow {
  double distance = 0;  ///< [m]
  Vec3<double> normal{};
  std::uint32_t what = 0;  ///< RayTarget
  std::uint32_t body = 0xffffffffu, wall = 0xffffffffu, particle = 0xffffffffu;
  std::uint32_t unused = 0;  ///< keeps the size a multiple of 8
};

/// The box around all particles, in stored coordinates.
struct ParticleBounds {
  Vec3<double> low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  MELTSIM_HD static ParticleBounds combine(ParticleBounds a, const ParticleBounds& b) {
    a.low = {minimum(a.low.x, b.low.x), minimum(a.low.y, b.low.y), minimum(a.low.z, b.low.z)};
    a.high = {maximum(a.high.x, b.high.x), maximum(a.high.y, b.high.y), maximum(a.high.z, b.high.z)};
    return a;
  }
};

/// Buffers of World::cast_rays.
struct RayRoom {
  const RayQuery* rays = nullptr;
  RayRow* hits = nullptr;
  ParticleBounds* bounds = nullptr;
  std::uint32_t count = 0, sought = 0;  ///< sought: a sum of ray_liquid, ...
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
