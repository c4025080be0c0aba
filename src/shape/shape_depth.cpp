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

/// Another face is one that stands at more than 50 degrees to the first, and ends what lies beneath that if it is nearer than `beside` of the
/// depth up to which faces are looked for.
constexpr double across = 0.64, beside = 0.6;

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

/// A unit vector across another.
Vec3d across_of(Vec3d n) {
  const Vec3d c = cross(n, std::fabs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0});
  return c * (1 / length(c));
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
void MeshDistance::nearest(std::size_t begin, std::size_t end, Vec3d x, Vec3d outward, double slack,
                           Nearest& best) const {
  for (std::size_t k = begin; k < end; ++k) {
    const std::size_t t = order_[k];
    const Vec3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2), way = to_triangle(x, a, b, c);
    if (!(square(way) < best.distance2 && is_way_out(way + outward * slack, outward))) continue;
    const Vec3d n = cross(b - a, c - a);
    const double size = length(n), along = dot(way, n);
    const bool over = size > 0 && square(way * size) - along * along <= 1e-4 * along * along;
    best = {square(way), over ? n * ((dot(n, outward) < 0 ? -1 : 1) / size) : Vec3d{}};
  }
}

MeshDistance::Nearest MeshDistance::nearest(Vec3d x, Vec3d outward, double most) const {
  Nearest best{most * most, {}};
  if (nodes_.empty()) return best;
  std::vector<std::size_t> open{0};
  while (!open.empty()) {
    const Node& node = nodes_[open.back()];
    const std::size_t first = open.back() + 1;
    open.pop_back();
    if (!(to_box2(x, node.bounds) < best.distance2)) continue;
    if (node.second == 0) {
      nearest(node.begin, node.end, x, outward, 1e-6 * most, best);
    } else {
      open.push_back(node.second);
      open.push_back(first);
    }
  }
  return best;
}

double MeshDistance::at(Vec3d x, Vec3d outward, double most) const {
  return nodes_.empty() ? most : std::sqrt(nearest(x, outward, most).distance2);
}

/// Whether a triangle is nearer than `within` whose normal is at more than an angle, of this cosine, to another.
bool MeshDistance::is_beside_another(Vec3d x, Vec3d normal, double within, double cosine) const {
  std::vector<std::size_t> open{0};
  while (!open.empty()) {
    const Node& node = nodes_[open.back()];
    const std::size_t first = open.back() + 1;
    open.pop_back();
    if (!(to_box2(x, node.bounds) < within * within)) continue;
    for (std::size_t k = node.begin; node.second == 0 && k < node.end; ++k) {
      const Vec3d a = corner(order_[k], 0), b = corner(order_[k], 1), c = corner(order_[k], 2);
      const Vec3d n = cross(b - a, c - a);
      const double along = dot(n, normal);
      if (along * along < cosine * cosine * square(n) && square(to_triangle(x, a, b, c)) < within * within)
        return true;
    }
    if (node.second != 0) open.insert(open.end(), {node.second, first});
  }
  return false;
}

std::optional<ShapeFace> MeshDistance::face(Vec3d x, Vec3d outward, double most) const {
  constexpr double level = 0.9986;  // 3 degrees
  const Nearest found = nearest(x, outward, most);
  if (!(square(found.normal) > 0) || is_beside_another(x, found.normal, beside * most, across)) return {};
  return ShapeFace{found.normal, is_beside_another(x, found.normal, beside * most, level)};
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
double ShapeDepth::along(Vec3d x, Vec3d direction, double most, double share) const {
  if (shape_.contains(x + direction * most)) return most;
  double inside = 0, outside = most;
  while (outside - inside > share * most) {
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

/// The plane through the ends of the ways out of the shape along a direction and beside it, and how far from it they are.
std::optional<ShapeDepth::Plane> ShapeDepth::plane(Vec3d x, Vec3d direction, double most) const {
  const Vec3d u = across_of(direction), v = cross(direction, u);
  const Vec3d ways[] = {u, u * -1.0, v, v * -1.0, {}};
  Vec3d end[5];
  for (int k = 0; k < 5; ++k) {
    const Vec3d way = direction + ways[k] * 0.5, d = way * (1 / length(way));
    const double reached = along(x, d, most, 1e-3);
    if (!(reached < most)) return {};
    end[k] = d * reached;
  }
  const Vec3d n = cross(end[0] - end[1], end[2] - end[3]);
  if (!(square(n) > 0)) return {};
  Plane p{n * ((dot(n, direction) < 0 ? -1 : 1) / length(n)), 0};
  const Vec3d middle = (end[0] + end[1] + end[2] + end[3]) * 0.25;
  for (const Vec3d& e : end) p.bend = std::max(p.bend, std::fabs(dot(e - middle, p.normal)));
  return p;
}

std::optional<ShapeFace> ShapeDepth::face(Vec3d x, Vec3d outward, double most) const {
  if (is_mesh_) return mesh_.face(x, outward, most);
  if (!of_parts_ || !(square(outward) > 0) || !shape_.contains(x)) return {};
  const auto first = plane(x, outward, most);
  if (!first) return {};
  // Along the normal that was found, and from farther in, where ways out end farther apart.
  const Vec3d deeper = x - first->normal * (most / 3);
  const auto second = plane(shape_.contains(deeper) ? deeper : x, first->normal, 4 * most / 3);
  if (!second || second->bend > 0.05 * most || is_beside_another(x, second->normal, beside * most)) return {};
  return ShapeFace{second->normal, second->bend > 0.006 * most};
}

/// Whether a way into the shape, away from a face of this normal at 30 degrees, ends within a distance: another face is near.
bool ShapeDepth::is_beside_another(Vec3d x, Vec3d normal, double within) const {
  const Vec3d u = across_of(normal), v = cross(normal, u);
  constexpr double into = 0.5, aside = 0.866, diagonal = 0.6124;  // aside/sqrt(2)
  for (const Vec3d& way : {u * aside, u * -aside, v * aside, v * -aside, (u + v) * diagonal,
                           (u - v) * diagonal, (v - u) * diagonal, (u + v) * -diagonal})
    if (!shape_.contains(x + (way - normal * into) * within)) return true;
  return false;
}

}  // namespace v0
}  // namespace meltsim
