// SPDX-License-Identifier: Apache-2.0
#include "meltsim/shape.hpp"

#include <functional>
#include <new>
#include <stdexcept>

#include "shape/box_ops.hpp"
#include "shape/shape_combine.hpp"
#include "shape/shape_limits.hpp"
#include "shape/shape_primitives.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

class RefusedNode final : public ShapeNode {
 public:
  explicit RefusedNode(Error error) : error_(std::move(error)) {}
  bool contains(Vec3d) const override { return false; }
  Box bounds(const Affine&) const override { return empty_box(); }
  Status validate() const override { return error_; }

 private:
  Error error_;
};

const ShapePtr& out_of_memory() {
  static const ShapePtr node = make_refused({ErrorCode::out_of_memory, "shape: host memory ran out"});
  return node;
}

/// Builders run here: nothing is thrown across the interface, and nothing too deep to walk is kept.
template <class Build>
ShapePtr build(const Build& builder) {
  const ShapePtr& spare = out_of_memory();  // made before it is needed
  try {
    ShapePtr node = builder();
    if (!node || node->depth() <= max_shape_depth) return node;
    return make_refused({ErrorCode::invalid_argument, "shape: nested more than " +
                                                          std::to_string(max_shape_depth) +
                                                          " deep; unite the parts in one call"});
  } catch (const std::bad_alloc&) {
    return spare;
  } catch (const std::length_error&) {
    return spare;
  }
}

}  // namespace

ShapePtr make_refused(Error error) { return std::make_shared<RefusedNode>(std::move(error)); }

Shape::Shape() = default;
Shape::Shape(std::shared_ptr<const ShapeNode> node) : node_(std::move(node)) {}

Shape Shape::box(Vec3d min, Vec3d max) {
  return Shape(build([&] { return make_box(min, max); }));
}
Shape Shape::sphere(Vec3d center, double radius) {
  return Shape(build([&] { return make_sphere(center, radius); }));
}
Shape Shape::capsule(Vec3d a, Vec3d b, double radius) {
  return Shape(build([&] { return make_capsule(a, b, radius); }));
}
Shape Shape::cylinder(Vec3d a, Vec3d b, double radius) {
  return Shape(build([&] { return make_cylinder(a, b, radius); }));
}
Shape Shape::torus(Vec3d center, Vec3d axis, double major_radius, double minor_radius) {
  return Shape(build([&] { return make_torus(center, axis, major_radius, minor_radius); }));
}
Shape Shape::blend(std::vector<Ellipsoid> parts, double blend) {
  return Shape(build([&] { return make_blend(std::move(parts), blend); }));
}
Shape Shape::mesh(TriangleMesh mesh) {
  return Shape(build([&] { return make_mesh(std::move(mesh)); }));
}
Shape Shape::unite(std::vector<Shape> parts) {
  return Shape(build([&] {
    std::vector<ShapePtr> nodes;
    for (Shape& part : parts) nodes.push_back(std::move(part.node_));
    return make_union(std::move(nodes));
  }));
}
Shape Shape::subtract(Shape from, Shape what) {
  return Shape(build([&] { return make_difference(std::move(from.node_), std::move(what.node_)); }));
}
Shape Shape::intersect(std::vector<Shape> parts) {
  return Shape(build([&] {
    std::vector<ShapePtr> nodes;
    for (Shape& part : parts) nodes.push_back(std::move(part.node_));
    return make_intersection(std::move(nodes));
  }));
}
Shape Shape::transformed(Vec3d offset, Vec3d axis, double angle, double scale) const {
  return Shape(build([&] { return make_transformed(node_, offset, axis, angle, scale); }));
}

bool Shape::contains(Vec3d point) const { return node_ && node_->contains(point); }
Box Shape::bounds() const { return node_ ? node_->bounds({}) : empty_box(); }
bool Shape::empty() const { return !node_; }

Status Shape::validate() const {
  if (!node_) return {};
  try {
    return node_->validate();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "out of memory"};
  }
}

std::vector<Vec3i> Shape::lattice_points(Vec3d origin, double spacing) const {
  std::vector<Vec3i> points;
  static_cast<void>(lattice_points(origin, spacing, points));
  return points;
}

Status Shape::lattice_points(Vec3d origin, double spacing, std::vector<Vec3i>& points) const {
  const auto one_by_one = [](std::int64_t parts, const std::function<void(std::int64_t)>& part) {
    for (std::int64_t k = 0; k < parts; ++k) part(k);
  };
  return meltsim::lattice_points(*this, origin, spacing, one_by_one, points);
}

}  // namespace v0
}  // namespace meltsim
