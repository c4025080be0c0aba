// SPDX-License-Identifier: Apache-2.0
#include "look.hpp"

#include <cmath>

namespace view {

Frame make_frame(const Camera& camera, const Viewport& viewport, const meltsim::Box& box, const Vec3d& origin,
                 double spacing) {
  const Vec3d center = (box.min + box.max) * 0.5;
  const double reach = 0.5 * length(box.max - box.min) + spacing;
  Frame frame;
  frame.viewport = viewport;
  frame.up = camera.up();
  frame.eye = camera.eye() - origin;
  frame.origin = origin;
  frame.radius = 0.5 * spacing;
  frame.view = look_at(frame.eye, camera.target() - origin, frame.up);
  frame.projection = camera.projection(viewport, center, 4 * reach);
  // Steep, over the left shoulder of a camera that has not been turned.
  const Vec3d side = std::abs(frame.up.y) > 0.9 ? Vec3d{-0.45, 0, 0.35} : Vec3d{-0.45, -0.35, 0};
  frame.to_light = normalized(frame.up + side);
  const Vec3d lamp = center - origin + frame.to_light * (2 * reach);
  const Vec3d beside = std::abs(frame.to_light.z) > 0.9 ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
  frame.shadow = orthographic(reach, reach, 3 * reach) * look_at(lamp, center - origin, beside);
  frame.shadow_scale = frame.shadow_depth = 1 / reach;
  return frame;
}

}  // namespace view
