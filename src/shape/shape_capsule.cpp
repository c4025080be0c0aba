// SPDX-License-Identifier: Apache-2.0
// Sphere and capsule. Closed: points on the surface are inside, so that what is symmetric is sampled
// symmetrically.
#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"
#include "shape/shape_primitives.hpp"
#include "shape/shape_round.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

/// All points within `radius` of the segment a b; a sphere where a = b.
class CapsuleNode final : public ShapeNode {
 public:
  CapsuleNode(Vec3d a, Vec3d b, double radius, bool sphere)
      : a_(a), b_(b), along_(b - a), radius_(radius), sphere_(sphere) {
    const double squared = dot(along_, along_);
    inverse_squared_ = squared > 0 ? 1 / squared : 0;
    const double reach = radius + tie_width(radius, maximum(magnitude(a), magnitude(b)));
    reach_squared_ = radius > 0 ? reach * reach : -1;
  }

  bool contains(Vec3d p) const override {
    const double t = clamp(dot(p - a_, along_) * inverse_squared_, 0.0, 1.0);
    const Vec3d d = p - a_ - along_ * t;
    return dot(d, d) <= reach_squared_;
  }

  Box bounds(const Affine& to_world) const override {
    const double r = radius_ * to_world.scale();
    Box out = around(to_world(a_), {r, r, r});
    if (!(r > 0)) return out;
    grow(out, around(to_world(b_), {r, r, r}));
    return out;
  }

  Status validate() const override {
    if (sphere_) {
      if (Status s = check_point("sphere.center", a_); !s) return s;
      return check_positive("sphere.radius", radius_);
    }
    if (Status s = check_point("capsule.a", a_); !s) return s;
    if (Status s = check_point("capsule.b", b_); !s) return s;
    return check_positive("capsule.radius", radius_);
  }

  bool primitive(const Affine& to_world, PlacedPrimitive& out) const override {
    if (!sphere_) return false;
    const double s = to_world.scale();
    out.kind = PlacedPrimitive::Kind::sphere;
    out.center = to_world(a_);
    const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int k = 0; k < 3; ++k) out.axes[k] = to_world.direction(axes[k]) * (1 / s);
    out.half = Vec3d{radius_, radius_, radius_} * s;
    return true;
  }

 private:
  Vec3d a_, b_, along_;
  double radius_, inverse_squared_ = 0, reach_squared_ = 0;
  bool sphere_;
};

}  // namespace

ShapePtr make_sphere(Vec3d center, double radius) {
  return std::make_shared<CapsuleNode>(center, center, radius, true);
}

ShapePtr make_capsule(Vec3d a, Vec3d b, double radius) {
  return std::make_shared<CapsuleNode>(a, b, radius, false);
}

}  // namespace v0
}  // namespace meltsim
