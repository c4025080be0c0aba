// SPDX-License-Identifier: Apache-2.0
#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"
#include "shape/shape_primitives.hpp"
#include "shape/shape_round.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

/// All points within `minor` of the circle of radius `major` around the axis. Closed.
class TorusNode final : public ShapeNode {
 public:
  TorusNode(Vec3d center, Vec3d axis, double major, double minor)
      : center_(center), axis_(axis), unit_(unit(axis)), major_(major), minor_(minor) {
    const double reach = minor + tie_width(minor, magnitude(center) + major);
    reach_squared_ = minor > 0 ? reach * reach : -1;
  }

  bool contains(Vec3d p) const override {
    const Vec3d d = p - center_;
    const double t = dot(d, unit_);
    const double ring = length(d - unit_ * t) - major_;
    return ring * ring + t * t <= reach_squared_;
  }

  Box bounds(const Affine& to_world) const override {
    const double s = to_world.scale(), tube = minor_ * s;
    if (!(minor_ > 0 && major_ > 0)) return empty_box();
    const Vec3d ring = disc_extent(to_world.direction(unit_) * (1 / s), major_ * s);
    return around(to_world(center_), ring + Vec3d{tube, tube, tube});
  }

  Status validate() const override {
    if (Status s = check_point("torus.center", center_); !s) return s;
    if (Status s = check_axis("torus.axis", axis_); !s) return s;
    if (Status s = check_positive("torus.major_radius", major_); !s) return s;
    if (Status s = check_positive("torus.minor_radius", minor_); !s) return s;
    if (minor_ <= major_) return {};
    return refuse_shape("torus.minor_radius is " + number_text(minor_) +
                        " but must not exceed torus.major_radius = " + number_text(major_));
  }

 private:
  Vec3d center_, axis_, unit_;
  double major_, minor_, reach_squared_ = 0;
};

}  // namespace

ShapePtr make_torus(Vec3d center, Vec3d axis, double major_radius, double minor_radius) {
  return std::make_shared<TorusNode>(center, axis, major_radius, minor_radius);
}

}  // namespace v0
}  // namespace meltsim
