// SPDX-License-Identifier: Apache-2.0
#include "picking.hpp"

#include <algorithm>
#include <cmath>

namespace view {

std::optional<double> hit_sphere(const Ray& ray, const Vec3d& center, double radius) {
  const Vec3d to = center - ray.origin;
  const double along = dot(to, ray.direction);
  const double beside = dot(to, to) - along * along, inside = radius * radius - beside;
  if (radius <= 0 || inside < 0) return std::nullopt;
  const double distance = along - std::sqrt(inside);
  if (distance < 0) return std::nullopt;
  return distance;
}

std::optional<std::size_t> pick(const Ray& ray, const meltsim::ParticleData& data,
                                const std::function<double(const Vec3d&, meltsim::ParticleTag)>& radius) {
  std::optional<std::size_t> nearest;
  double distance = meltsim::infinity;
  for (std::size_t i = 0; i < data.id.size(); ++i) {
    const auto hit = hit_sphere(ray, data.position[i], radius(data.position[i], data.tag[i]));
    if (!hit || *hit >= distance) continue;
    distance = *hit;
    nearest = i;
  }
  return nearest;
}

std::optional<std::size_t> find_id(const meltsim::ParticleData& data, std::uint32_t id) {
  const auto at = std::lower_bound(data.id.begin(), data.id.end(), id);
  if (at == data.id.end() || *at != id) return std::nullopt;
  return static_cast<std::size_t>(at - data.id.begin());
}

}  // namespace view
