// SPDX-License-Identifier: Apache-2.0
// Half open along the axis (the cap at `a` is inside, the one at `b` outside), as the box is; closed around
// it.
#include <cmath>

#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"
#include "shape/shape_primitives.hpp"
#include "shape/shape_round.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

class CylinderNode final : public ShapeNode {
 public:
  CylinderNode(Vec3d a, Vec3d b, double radius) : a_(a), b_(b), axis_(unit(b - a)), radius_(radius) {
    const double far = maximum(magnitude(a), magnitude(b));
    height_ = length(b - a);
    tie_ = tie_width(height_, far);
    const double reach = radius + tie_width(radius, far);
    reach_squared_ = radius > 0 ? reach * reach : -1;
  }

  bool contains(Vec3d p) const override {
    const Vec3d d = p - a_;
    const double t = dot(d, axis_);
    const Vec3d across = d - axis_ * t;
    return t + tie_ >= 0 && t + tie_ < height_ && dot(across, across) <= reach_squared_;
  }

  Box bounds(const Affine& to_world) const override {
    const double s = to_world.scale();
    const Vec3d half = disc_extent(to_world.direction(axis_) * (1 / s), radius_ * s);
    Box out = around(to_world(a_), half);
    grow(out, around(to_world(b_), half));
    return radius_ > 0 && height_ > 0 ? out : empty_box();
  }

  Status validate() const override {
    if (Status s = check_point("cylinder.a", a_); !s) return s;
    if (Status s = check_point("cylinder.b", b_); !s) return s;
    if (!(height_ > 0)) return refuse_shape("cylinder.a equals cylinder.b; the axis must have a length");
    return check_positive("cylinder.radius", radius_);
  }

  bool primitive(const Affine& to_world, PlacedPrimitive& out) const override {
    const double s = to_world.scale();
    out.kind = PlacedPrimitive::Kind::cylinder;
    out.center = to_world((a_ + b_) * 0.5);
    out.axes[2] = to_world.direction(axis_) * (1 / s);
    const Vec3d n = out.axes[2];
    const Vec3d aside = std::fabs(n.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    out.axes[0] = unit(cross(n, aside));
    out.axes[1] = cross(n, out.axes[0]);
    out.half = Vec3d{radius_, radius_, 0.5 * height_} * s;
    return true;
  }

 private:
  Vec3d a_, b_, axis_;
  double radius_, height_ = 0, tie_ = 0, reach_squared_ = 0;
};

}  // namespace

ShapePtr make_cylinder(Vec3d a, Vec3d b, double radius) {
  return std::make_shared<CylinderNode>(a, b, radius);
}

}  // namespace v0
}  // namespace meltsim
