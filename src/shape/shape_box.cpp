// SPDX-License-Identifier: Apache-2.0
// Half open, min <= p < max: boxes that share a face share no lattice point, and a box n spacings wide holds
// exactly n sites wherever it starts.
#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"
#include "shape/shape_primitives.hpp"
#include "shape/shape_round.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

class BoxNode final : public ShapeNode {
 public:
  BoxNode(Vec3d min, Vec3d max) : box_{min, max} {
    const double size = magnitude(max - min), reach = maximum(magnitude(min), magnitude(max));
    tie_ = tie_width(size, reach);
  }

  bool contains(Vec3d p) const override {
    const Vec3d q = p + Vec3d{tie_, tie_, tie_};
    return q.x >= box_.min.x && q.x < box_.max.x && q.y >= box_.min.y && q.y < box_.max.y &&
           q.z >= box_.min.z && q.z < box_.max.z;
  }

  Box bounds(const Affine& to_world) const override {
    if (inverted(box_)) return box_;
    Box out = empty_box();
    for (int corner = 0; corner < 8; ++corner)
      grow(out,
           to_world({(corner & 1) != 0 ? box_.max.x : box_.min.x, (corner & 2) != 0 ? box_.max.y : box_.min.y,
                     (corner & 4) != 0 ? box_.max.z : box_.min.z}));
    return out;
  }

  Status validate() const override {
    if (Status s = check_point("box.min", box_.min); !s) return s;
    if (Status s = check_point("box.max", box_.max); !s) return s;
    if (Status s = ordered("x", box_.min.x, box_.max.x); !s) return s;
    if (Status s = ordered("y", box_.min.y, box_.max.y); !s) return s;
    return ordered("z", box_.min.z, box_.max.z);
  }

  bool primitive(const Affine& to_world, PlacedPrimitive& out) const override {
    const double s = to_world.scale();
    out.kind = PlacedPrimitive::Kind::box;
    out.center = to_world((box_.min + box_.max) * 0.5);
    const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int k = 0; k < 3; ++k) out.axes[k] = to_world.direction(axes[k]) * (1 / s);
    out.half = (box_.max - box_.min) * (0.5 * s);
    return true;
  }

 private:
  static Status ordered(const std::string& axis, double min, double max) {
    if (min < max) return {};
    return refuse_shape("box.min." + axis + " is " + number_text(min) + " but must be less than box.max." +
                        axis + " = " + number_text(max));
  }

  Box box_;
  double tie_ = 0;
};

}  // namespace

ShapePtr make_box(Vec3d min, Vec3d max) { return std::make_shared<BoxNode>(min, max); }

}  // namespace v0
}  // namespace meltsim
