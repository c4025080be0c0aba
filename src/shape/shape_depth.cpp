// SPDX-License-Identifier: Apache-2.0
#include "shape/shape_depth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "shape/box_ops.hpp"
#include "shape/shape_node.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

constexpr std::size_t triangles_in_leaf = 4;

double square(Vec3d v) { return dot(v, v); }

/// From x to the nearest point of a segment.
Vec3d to_segment(Vec3d x, Vec3d a, Vec3d b) {
  const Vec3d along = b - a;
  const double size = square(along);
  const double t = size > 0 ? clamp(dot(x - a, along) / size, 0.0, 1.0) : 0.0;
  return a + along * t - x;
}

/// From x to the nearest point of a triangle: in its plane where x is over it, else on its sides.
Vec3d to_triangle(Vec3d x, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d n = cross(b - a, c - a);
  const double size = square(n);
  const auto over = [&](Vec3d p, Vec3d q) { return dot(cross(q - p, x - p), n) >= 0; };
  if (size > 0 && over(a, b) && over(b, c) && over(c, a)) return n * (-dot(x - a, n) / size);
  const Vec3d sides[] = {to_segment(x, a, b), to_segment(x, b, c), to_segment(x, c, a)};
  return *std::min_element(sides, sides + 3, [](Vec3d p, Vec3d q) { return square(p) < square(q); });
}

/// Whether v is within 45 degrees of `outward`, a unit vector; anything is of 0. What is a face at the other side of an edge is not.
bool is_way_out(Vec3d v, Vec3d outward) {
  constexpr double cosine = 0.7072;  // those at 45 degrees are not
  const double along = dot(v, outward);
  return square(outward) == 0 || (along > 0 && along * along > cosine * cosine * square(v));
}

double to_box2(Vec3d x, const Box& b) {
  const auto beyond = [](double v, double low, double high) { return std::max({low - v, v - high, 0.0}); };
  return square(
      {beyond(x.x, b.min.x, b.max.x), beyond(x.y, b.min.y, b.max.y), beyond(x.z, b.min.z, b.max.z)});
}

double component(Vec3d v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

}  // namespace

MeshDistance::MeshDistance(TriangleMesh mesh) : mesh_(std::move(mesh)), order_(mesh_.indices.size() / 3) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  nodes_.reserve(order_.size());
  if (!order_.empty()) build(0, order_.size());
}

Box MeshDistance::bounds_of(std::size_t begin, std::size_t end) const {
  Box box = empty_box();
  for (std::size_t k = begin; k < end; ++k)
    for (std::size_t c = 0; c < 3; ++c) grow(box, corner(order_[k], c));
  return box;
}

/// Halves the triangles across the longest side of their box; its depth is the logarithm of their number.
std::size_t MeshDistance::build(std::size_t begin, std::size_t end) {
  const std::size_t here = nodes_.size();
  nodes_.push_back({bounds_of(begin, end), begin, end, 0});
  if (end - begin <= triangles_in_leaf) return here;
  const Vec3d side = nodes_[here].bounds.max - nodes_[here].bounds.min;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  const auto place = [&](std::size_t t) {
    return component(corner(t, 0) + corner(t, 1) + corner(t, 2), axis);
  };
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::size_t a, std::size_t b) {
    const double pa = place(a), pb = place(b);
    return pa != pb ? pa < pb : a < b;
  });
  build(begin, middle);
  nodes_[here].second = build(middle, end);
  return here;
}

/// A point on a triangle may lie beyond it by rounding: `slack` further inside, it does not.
double MeshDistance::nearest(std::size_t begin, std::size_t end, Vec3d x, Vec3d outward, double slack) const {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t k = begin; k < end; ++k) {
    const std::size_t t = order_[k];
    const Vec3d way = to_triangle(x, corner(t, 0), corner(t, 1), corner(t, 2));
    if (square(way) < best && is_way_out(way + outward * slack, outward)) best = square(way);
  }
  return best;
}

double MeshDistance::at(Vec3d x, Vec3d outward, double most) const {
  if (nodes_.empty()) return most;
  double best = most * most;
  std::vector<std::size_t> open{0};
  while (!open.empty()) {
    const Node& node = nodes_[open.back()];
    const std::size_t first = open.back() + 1;
    open.pop_back();
    if (!(to_box2(x, node.bounds) < best)) continue;
    if (node.second == 0) {
      best = std::min(best, nearest(node.begin, node.end, x, outward, 1e-6 * most));
    } else {
      open.push_back(node.second);
      open.push_back(first);
    }
  }
  return std::sqrt(best);
}

ShapeDepth::ShapeDepth(const Shape& shape) : shape_(shape) {
  const ShapeNode* const node = ShapeAccess::node(shape_);
  if (node == nullptr) return;
  TriangleMesh mesh;
  is_mesh_ = node->mesh(Affine{}, mesh);
  if (is_mesh_) mesh_ = MeshDistance(std::move(mesh));
  of_parts_ = !node->holds_mesh();
}

/// Where the way out of the shape ends.
double ShapeDepth::along(Vec3d x, Vec3d direction, double most) const {
  if (shape_.contains(x + direction * most)) return most;
  double inside = 0, outside = most;
  while (outside - inside > 0.01 * most) {
    const double middle = 0.5 * (inside + outside);
    (shape_.contains(x + direction * middle) ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

double ShapeDepth::at(Vec3d x, Vec3d outward, double most) const {
  if (is_mesh_) return mesh_.at(x, outward, most);
  if (!of_parts_ || !shape_.contains(x)) return most;
  double depth = square(outward) > 0 ? along(x, outward, most) : most;
  for (int k = 0; k < 27; ++k) {
    const Vec3d d{double(k % 3 - 1), double(k / 3 % 3 - 1), double(k / 9 - 1)};
    if (k != 13 && is_way_out(d, outward)) depth = std::min(depth, along(x, d * (1 / length(d)), depth));
  }
  return depth;
}

}  // namespace v0
}  // namespace meltsim
