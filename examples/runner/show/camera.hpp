// SPDX-License-Identifier: Apache-2.0
// Where pictures are taken from: as the scene says, or so that everything is in view.
#pragma once

#include <array>

#include "scene.hpp"

namespace runner {

struct Box {
  meltsim::Vec3d min{1e300, 1e300, 1e300}, max{-1e300, -1e300, -1e300};  ///< [m]; empty at first
  bool empty() const { return min.x > max.x; }
  void add(const meltsim::Vec3d& x);
  meltsim::Vec3d size() const;
};

struct Camera {
  meltsim::Vec3d eye, look_at, up{0, 1, 0};
  double fov = 40;  ///< degrees, from top to bottom of the picture
};

/// Against gravity, or y where there is none.
meltsim::Vec3d upward(const Scene& scene);
/// Whether two unit vectors are one direction, but for rounding.
inline bool is_along(const meltsim::Vec3d& a, const meltsim::Vec3d& b) { return dot(a, b) > 1 - 1e-12; }
/// The shortest turn that brings a unit vector to +y, for files whose readers take that for up: x, y, z, w of a unit quaternion.
std::array<double, 4> turn_upright(const meltsim::Vec3d& up);
/// Width to height that automatic cameras fit at least, also of wider pictures: those of any usual width are alike.
inline constexpr double usual_aspect = 1.4;
/// The camera of output.camera; what it leaves out follows from `box`, what there is to see, and from `aspect`, width to height of
/// the picture: all of the box is in it.
Camera scene_camera(const Scene& scene, const Box& box, double aspect = usual_aspect);
/// What there is to see: `contents`, or the domain while there are none.
Box view_box(const Scene& scene, const Box& contents);

}  // namespace runner
