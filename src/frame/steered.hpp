// SPDX-License-Identifier: Apache-2.0
// New motions of kinematic bodies on their way to the device.
#pragma once

#include <cstdint>
#include <vector>

#include "meltsim/physics/mesh_motion.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// A body and how it moves from the beginning of a sub-step on, in stored coordinates.
struct Steered {
  std::uint32_t body = 0;
  bool jumps = false;  ///< it is elsewhere from the beginning of the sub-step on
  physics::RigidMotion motion;
  double reach = 0, most = 0;  ///< of a proxy: as proxy_set() takes them [m, m/s]
};

/// New motions of all vertices of a body that deforms, on the host until the sub-step is enqueued.
struct Reshaped {
  std::uint32_t body = 0, first = 0, count = 0;  ///< first: in mesh_points
  const physics::MeshPoint* points = nullptr;
};

/// An impulse on a free body, or its new velocities.
struct PushArguments {
  std::uint32_t body = 0, vertex = 0;  ///< vertex: the body's first
  bool sets = false;                   ///< velocities, not impulses
  Vec3<double> linear, angular;        ///< [N s], [N m s]; or [m/s], [rad/s]
};

/// Most bodies that one launch gives new motions: a kernel's arguments hold no more than 4 KB.
inline constexpr std::uint32_t most_steered = 16;

}  // namespace core
}  // namespace v0
}  // namespace meltsim
