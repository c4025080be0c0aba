// SPDX-License-Identifier: Apache-2.0
#include "show/camera.hpp"

#include <algorithm>
#include <cmath>

namespace runner {

namespace {

using meltsim::Vec3d;

constexpr double margin = 0.88;  ///< share of the picture that the contents may fill

Vec3d unit(const Vec3d& v) { return v * (1 / length(v)); }

std::optional<Vec3d> given(const Json& camera, const char* key) {
  if (!camera.is_object() || !camera.contains(key)) return std::nullopt;
  const Json& v = camera.at(key);
  return Vec3d{v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
}

}  // namespace

void Box::add(const Vec3d& x) {
  min = {std::min(min.x, x.x), std::min(min.y, x.y), std::min(min.z, x.z)};
  max = {std::max(max.x, x.x), std::max(max.y, x.y), std::max(max.z, x.z)};
}

Vec3d Box::size() const { return empty() ? Vec3d{0, 0, 0} : max - min; }

Vec3d upward(const Scene& scene) {
  const Vec3d g = scene.world.gravity;
  if (length(g) == 0) return {0, 1, 0};
  return unit(Vec3d{0, 0, 0} - g);
}

std::array<double, 4> turn_upright(const Vec3d& up) {
  const Vec3d axis = cross(up, Vec3d{0, 1, 0});
  const double w = 1 + up.y, size = std::sqrt(dot(axis, axis) + w * w);
  if (size < 1e-9) return {1, 0, 0, 0};  // upside down: half a turn around x
  return {axis.x / size, axis.y / size, axis.z / size, w / size};
}

Box view_box(const Scene& scene, const Box& contents) {
  const meltsim::DomainDesc& domain = scene.world.domain;
  if (!contents.empty() || !domain.bounded) return contents;
  Box box;
  box.add(domain.min);
  box.add(domain.max);
  return box;
}

Camera scene_camera(const Scene& scene, const Box& box, double aspect) {
  const Json& wish = scene.output.camera;
  Camera camera;
  camera.up = given(wish, "up").value_or(upward(scene));
  if (wish.is_object() && wish.contains("fov")) camera.fov = wish.at("fov").get<double>();
  const Vec3d size = box.size(), center = box.empty() ? Vec3d{0, 0, 0} : box.min + size * 0.5;
  camera.look_at = given(wish, "look_at").value_or(center);
  if (const auto eye = given(wish, "eye")) {
    camera.eye = *eye;
    return camera;
  }
  // From in front, a little from the right and above; as near as lets every corner of the box be seen.
  const Vec3d towards = std::abs(camera.up.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0};
  const Vec3d front = unit(towards - camera.up * dot(towards, camera.up)), side = cross(camera.up, front);
  const Vec3d back = unit(front + side * 0.55 + camera.up * 0.45);
  const Vec3d right = unit(cross(camera.up, back)), above = cross(back, right);
  const double slope = margin * std::tan(0.5 * camera.fov * 3.14159265358979 / 180);
  double distance = 2 * scene.world.spacing;
  for (int corner = 0; corner < 8 && !box.empty(); ++corner) {
    const Vec3d x{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                  (corner & 4) != 0 ? box.max.z : box.min.z};
    const Vec3d off = x - camera.look_at;
    const double nearer = dot(off, back);
    distance = std::max({distance, nearer + std::abs(dot(off, above)) / slope,
                         nearer + std::abs(dot(off, right)) / (slope * std::min(aspect, usual_aspect))});
  }
  camera.eye = camera.look_at + back * distance;
  return camera;
}

}  // namespace runner
