// SPDX-License-Identifier: Apache-2.0
#include "camera.hpp"

#include <algorithm>
#include <cmath>

namespace view {

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double steepest = 0.499 * pi;

double half_height() { return std::tan(0.5 * Camera::fov * pi / 180); }

/// Two directions on the ground: to the right and to the viewer of a camera that has not been turned.
void ground_axes(const Vec3d& up, Vec3d& right, Vec3d& front) {
  const Vec3d beside = std::abs(up.y) > 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, std::abs(up.z) > 0.9 ? -1.0 : 1.0, 0};
  right = normalized(cross(up, beside));
  front = cross(right, up);
}

}  // namespace

Vec3d normalized(const Vec3d& v) {
  const double l = length(v);
  return l > 0 ? v * (1 / l) : Vec3d{0, 1, 0};
}

Mat4 operator*(const Mat4& a, const Mat4& b) {
  Mat4 c;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) c.at(i, j) += a.at(i, k) * b.at(k, j);
  return c;
}

Mat4 look_at(const Vec3d& eye, const Vec3d& target, const Vec3d& up) {
  const Vec3d back = normalized(eye - target), right = normalized(cross(up, back)), top = cross(back, right);
  Mat4 v;
  const Vec3d rows[3] = {right, top, back};
  for (int i = 0; i < 3; ++i) {
    v.at(i, 0) = static_cast<float>(rows[i].x);
    v.at(i, 1) = static_cast<float>(rows[i].y);
    v.at(i, 2) = static_cast<float>(rows[i].z);
    v.at(i, 3) = static_cast<float>(-dot(rows[i], eye));
  }
  v.at(3, 3) = 1;
  return v;
}

Mat4 perspective(double fov, double aspect, double near, double far) {
  const double f = 1 / std::tan(0.5 * fov * pi / 180);
  Mat4 p;
  p.at(0, 0) = static_cast<float>(f / aspect);
  p.at(1, 1) = static_cast<float>(f);
  p.at(2, 2) = static_cast<float>((far + near) / (near - far));
  p.at(2, 3) = static_cast<float>(2 * far * near / (near - far));
  p.at(3, 2) = -1;
  return p;
}

Mat4 orthographic(double half, double near, double far) {
  Mat4 p;
  p.at(0, 0) = p.at(1, 1) = static_cast<float>(1 / half);
  p.at(2, 2) = static_cast<float>(2 / (near - far));
  p.at(2, 3) = static_cast<float>((far + near) / (near - far));
  p.at(3, 3) = 1;
  return p;
}

void Camera::frame(const meltsim::Box& box, const Vec3d& up, double aspect) {
  up_ = normalized(up);
  target_ = (box.min + box.max) * 0.5;
  yaw_ = 0.6;
  pitch_ = 0.35;
  distance_ =
      std::max(1e-6, 0.52 * length(box.max - box.min) / (half_height() * std::clamp(aspect, 0.2, 1.0)));
}

void Camera::place(const Vec3d& eye, const Vec3d& target, const Vec3d& up) {
  up_ = normalized(up);
  target_ = target;
  const Vec3d back = eye - target;
  distance_ = std::max(1e-6, length(back));
  Vec3d right, front;
  ground_axes(up_, right, front);
  const double height = dot(back, up_) / distance_;
  pitch_ = std::clamp(std::asin(std::clamp(height, -1.0, 1.0)), -steepest, steepest);
  yaw_ = std::atan2(dot(back, right), dot(back, front));
}

void Camera::orbit(double dx, double dy) {
  yaw_ -= pi * dx;
  pitch_ = std::clamp(pitch_ + pi * dy, -steepest, steepest);
}

void Camera::pan(double dx, double dy) {
  const double scale = 2 * distance_ * half_height();  // what follows the pointer lies at the target's depth
  const Axes a = axes();
  target_ += a.right * (-dx * scale) + a.up * (dy * scale);
}

void Camera::zoom(double steps) { distance_ = std::clamp(distance_ * std::pow(0.9, steps), 1e-6, 1e9); }

Camera::Axes Camera::axes() const {
  Vec3d right, front;
  ground_axes(up_, right, front);
  const Vec3d outward = right * std::sin(yaw_) + front * std::cos(yaw_);
  const Vec3d back = outward * std::cos(pitch_) + up_ * std::sin(pitch_);
  const Vec3d side = normalized(cross(up_, back));
  return {side, cross(back, side), back};
}

Vec3d Camera::eye() const { return target_ + axes().back * distance_; }

Mat4 Camera::view() const { return look_at(eye(), target_, up_); }

Mat4 Camera::projection(const Viewport& viewport, const Vec3d& center, double radius) const {
  const double depth = dot(eye() - center, axes().back);
  const double far = std::max(depth + radius, 2 * distance_);
  const double near = std::max({depth - radius, 1e-3 * distance_, 1e-4 * far});
  Mat4 p = perspective(fov, viewport.aspect(), near, far);
  p.at(0, 2) = static_cast<float>(-shift_);
  return p;
}

Ray Camera::ray(double x, double y, const Viewport& viewport) const {
  const Axes a = axes();
  const double h = half_height();
  const double right = (2 * x / viewport.width - 1 - shift_) * h * viewport.aspect();
  const double top = (1 - 2 * y / viewport.height) * h;
  return {eye(), normalized(a.right * right + a.up * top - a.back)};
}

bool Camera::project(const Vec3d& point, const Viewport& viewport, double& x, double& y) const {
  const Axes a = axes();
  const Vec3d d = point - eye();
  const double depth = -dot(d, a.back), h = half_height();
  if (depth <= 0) return false;
  x = 0.5 * viewport.width * (1 + shift_ + dot(d, a.right) / (depth * h * viewport.aspect()));
  y = 0.5 * viewport.height * (1 - dot(d, a.up) / (depth * h));
  return true;
}

}  // namespace view
