// SPDX-License-Identifier: Apache-2.0
// A camera that turns around a point, and the matrices that draw what it sees.
#pragma once

#include <array>

#include "meltsim/types.hpp"

namespace view {

using meltsim::Vec3d;

/// Column-major, as OpenGL takes it.
struct Mat4 {
  std::array<float, 16> m{};
  float& at(int row, int column) { return m[static_cast<std::size_t>(4 * column + row)]; }
  float at(int row, int column) const { return m[static_cast<std::size_t>(4 * column + row)]; }
};
Mat4 operator*(const Mat4& a, const Mat4& b);
Mat4 look_at(const Vec3d& eye, const Vec3d& target, const Vec3d& up);
/// `fov` from top to bottom [degrees]; depth from `near` to `far` goes to -1..1.
Mat4 perspective(double fov, double aspect, double near, double far);
/// A box `2 half` wide and high around the axis of sight.
Mat4 orthographic(double half, double near, double far);

Vec3d normalized(const Vec3d& v);

struct Ray {
  Vec3d origin, direction;  ///< direction has length 1
};

struct Viewport {
  int width = 1, height = 1;  ///< pixels
  double aspect() const { return static_cast<double>(width) / static_cast<double>(height); }
};

class Camera {
 public:
  static constexpr double fov = 40;  ///< degrees, from top to bottom

  /// Everything in `box` is in view, from the front, the right and above, in a window `aspect` times as wide
  /// as high.
  void frame(const meltsim::Box& box, const Vec3d& up, double aspect);
  /// As if from `eye`, looking at `target`.
  void place(const Vec3d& eye, const Vec3d& target, const Vec3d& up);

  // By the mouse: parts of the window's height.
  void orbit(double dx, double dy);
  void pan(double dx, double dy);
  void zoom(double steps);  ///< one step of the wheel is a tenth

  /// The target is seen this far to the right of the window's middle, in half widths: beside a panel.
  void shift(double x) { shift_ = x; }

  Vec3d eye() const;
  const Vec3d& target() const { return target_; }
  const Vec3d& up() const { return up_; }
  double distance() const { return distance_; }

  Mat4 view() const;
  /// Deep enough for a sphere of `radius` around `center`.
  Mat4 projection(const Viewport& viewport, const Vec3d& center, double radius) const;
  /// Through a pixel, counted from the upper left.
  Ray ray(double x, double y, const Viewport& viewport) const;
  /// Where a point is seen, in pixels from the upper left; false when it is behind the eye.
  bool project(const Vec3d& point, const Viewport& viewport, double& x, double& y) const;

 private:
  struct Axes {
    Vec3d right, up, back;  ///< back points at the eye
  };
  Axes axes() const;

  Vec3d target_{0, 0, 0}, up_{0, 1, 0};
  double yaw_ = 0.6, pitch_ = 0.35, distance_ = 5, shift_ = 0;
};

}  // namespace view
