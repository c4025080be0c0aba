// SPDX-License-Identifier: Apache-2.0
// How the scene is shown: what the panel sets, and what follows from the camera.
#pragma once

#include "camera.hpp"
#include "color_map.hpp"
#include "meltsim/particle_tag.hpp"

namespace view {

struct Look {
  ColorBy by = ColorBy::temperature;
  ColorTable colors = color_table();
  Range temperature, speed{0, 1};
  float liquid_size = 1, solid_size = 1;  ///< of the particles, in half spacings; 0 hides them
  int cut_axis = -1;                      ///< 0..2: only what lies below cut_at on this axis is shown
  float cut_at = 0;                       ///< [m]
  bool shadows = true, box = true, panel = true;

  const Range& range() const { return by == ColorBy::speed ? speed : temperature; }
};

/// Radius that a particle is shown with; 0 = hidden. The vertex shader does the same.
inline double shown_radius(const Look& look, double spacing, const Vec3d& x, meltsim::ParticleTag tag) {
  if (meltsim::is_removed(tag)) return 0;
  const double along[3] = {x.x, x.y, x.z};
  if (look.cut_axis >= 0 && along[look.cut_axis] > look.cut_at) return 0;
  const float size = meltsim::is_solid(tag) ? look.solid_size : look.liquid_size;
  return 0.5 * spacing * static_cast<double>(size);
}

/// One frame. Everything is relative to the World's origin, so that far away scenes stay sharp.
struct Frame {
  Viewport viewport;
  Mat4 view, projection;
  Mat4 shadow;              ///< to the shadow map's clip space
  double shadow_scale = 1;  ///< of that, clip units per metre across
  double shadow_depth = 1;  ///< and in depth
  Vec3d to_light;           ///< length 1
  Vec3d up, eye;
  Vec3d origin;       ///< of the World
  double radius = 0;  ///< of a particle, half a spacing [m]
};

Frame make_frame(const Camera& camera, const Viewport& viewport, const meltsim::Box& box, const Vec3d& origin,
                 double spacing);

}  // namespace view
