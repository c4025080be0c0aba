// SPDX-License-Identifier: Apache-2.0
// Which particle is under the pointer.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "camera.hpp"
#include "meltsim/world.hpp"

namespace view {

/// Distance along the ray to where it enters the sphere; nothing when it misses or the sphere lies behind.
std::optional<double> hit_sphere(const Ray& ray, const Vec3d& center, double radius);

/// Index in `data` of the first particle that the ray meets. `radius` of a particle is given by its position
/// and tag; 0 = not shown.
std::optional<std::size_t> pick(const Ray& ray, const meltsim::ParticleData& data,
                                const std::function<double(const Vec3d&, meltsim::ParticleTag)>& radius);

/// Index of an id; ids are in ascending order.
std::optional<std::size_t> find_id(const meltsim::ParticleData& data, std::uint32_t id);

}  // namespace view
