// SPDX-License-Identifier: Apache-2.0
// A shape moved, turned and scaled. Points are taken back into the frame of the shape; the lattice of a mesh
// is taken along instead, so that its vertices are mapped once and not every site.
#include <cmath>

#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"
#include "shape/shape_combine.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

Mat3<double> rotation(Vec3d axis, double angle) {
  if (angle == 0) return identity3<double>();  // the axis may be anything, and faces stay exact
  const double s = std::sin(0.5 * angle) / length(axis);
  return to_matrix(Quat<double>{std::cos(0.5 * angle), axis.x * s, axis.y * s, axis.z * s});
}

Mat3<double> scaled(Mat3<double> m, double factor) {
  for (auto& row : m.m)
    for (double& v : row) v *= factor;
  return m;
}

class TransformNode final : public ShapeNode {
 public:
  TransformNode(ShapePtr child, Vec3d offset, Vec3d axis, double angle, double scale)
      : ShapeNode(child->depth() + 1), child_(std::move(child)) {
    status_ = check(offset, axis, angle, scale);
    if (!status_) return;
    const Mat3<double> r = rotation(axis, angle);
    to_parent_ = {scaled(r, scale), offset};
    to_child_.linear = scaled(transpose(r), 1 / scale);
    to_child_.offset = -to_child_.direction(offset);
  }
  TransformNode(const TransformNode& inner, const TransformNode& outer)
      : ShapeNode(inner.depth()),
        child_(inner.child_),
        to_parent_(compose(outer.to_parent_, inner.to_parent_)),
        to_child_(compose(inner.to_child_, outer.to_child_)) {}

  bool valid() const { return status_.ok(); }

  bool contains(Vec3d p) const override { return valid() && child_->contains(to_child_(p)); }

  Box bounds(const Affine& to_world) const override {
    return valid() ? child_->bounds(compose(to_world, to_parent_)) : empty_box();
  }

  Status validate() const override { return status_ ? child_->validate() : status_; }

  void fill(const Lattice& lattice, SiteMask& mask) const override {
    child_->fill({lattice.origin, lattice.spacing, compose(to_child_, lattice.to_local),
                  compose(lattice.to_world, to_parent_)},
                 mask);
  }

  bool holds_mesh() const override { return child_->holds_mesh(); }

  bool mesh(const Affine& to_world, TriangleMesh& out) const override {
    return valid() && child_->mesh(compose(to_world, to_parent_), out);
  }

  bool primitive(const Affine& to_world, PlacedPrimitive& out) const override {
    return valid() && child_->primitive(compose(to_world, to_parent_), out);
  }

 private:
  static Status check(Vec3d offset, Vec3d axis, double angle, double scale) {
    if (Status s = check_point("transformed.offset", offset); !s) return s;
    if (Status s = check_number("transformed.angle", angle); !s) return s;
    if (Status s = angle == 0 ? Status() : check_axis("transformed.axis", axis); !s) return s;
    return check_positive("transformed.scale", scale);
  }

  ShapePtr child_;
  Affine to_parent_, to_child_;
  Status status_;
};

}  // namespace

ShapePtr make_transformed(ShapePtr child, Vec3d offset, Vec3d axis, double angle, double scale) {
  if (!child) return nullptr;
  auto moved = std::make_shared<TransformNode>(child, offset, axis, angle, scale);
  // Moving a shape over and over, say once per frame, must not build a tower of nodes.
  if (const auto* inner = dynamic_cast<const TransformNode*>(child.get()))
    if (inner->valid() && moved->valid()) return std::make_shared<TransformNode>(*inner, *moved);
  return moved;
}

}  // namespace v0
}  // namespace meltsim
