// SPDX-License-Identifier: Apache-2.0
// How far inside a shape points are. Host only, when a body is added.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "meltsim/shape.hpp"

namespace meltsim {
inline namespace v0 {

/// Of the surface of a shape.
struct ShapeFace {
  Vec3d normal;  ///< outwards
  bool curved = false;
};

/// Distances from points to the surface of a mesh: a tree of boxes around its triangles.
class MeshDistance {
 public:
  MeshDistance() = default;
  explicit MeshDistance(TriangleMesh mesh);
  /// The smaller of `most` and the distance from x to the nearest of the triangles whose nearest point lies within 45 degrees of
  /// `outward`, a unit vector; to the nearest of all where that is 0.
  double at(Vec3d x, Vec3d outward, double most) const;
  /// The face of that triangle, where the nearest point is not at its rim; empty where none is nearer than `most`, or another face is near.
  std::optional<ShapeFace> face(Vec3d x, Vec3d outward, double most) const;

 private:
  /// A point of a triangle as seen from x.
  struct Nearest {
    double distance2 = 0;
    Vec3d normal;  ///< 0: the point is at the rim
  };
  struct Node {
    Box bounds;
    std::size_t begin = 0, end = 0;  ///< of order_
    std::size_t second = 0;          ///< the other child, the first one follows its parent; 0: a leaf
  };
  std::size_t build(std::size_t begin, std::size_t end);
  Vec3d corner(std::size_t triangle, std::size_t k) const {
    return mesh_.vertices[mesh_.indices[3 * triangle + k]];
  }
  Box bounds_of(std::size_t begin, std::size_t end) const;
  bool is_beside_another(Vec3d x, Vec3d normal, double within, double cosine) const;
  void nearest(std::size_t begin, std::size_t end, Vec3d x, Vec3d outward, double slack, Nearest& best) const;
  Nearest nearest(Vec3d x, Vec3d outward, double most) const;

  TriangleMesh mesh_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
};

/// Depth of points in a valid shape.
class ShapeDepth {
 public:
  explicit ShapeDepth(const Shape& shape);
  /// Distance from x to the surface of the shape within 45 degrees of `outward`, `most` at most; in any direction where `outward`, a
  /// unit vector else, is 0. So a point at an edge of a box is as deep as the edge lies out, not as the nearer of its faces: the box
  /// stands on its rims. Of a mesh to its triangles, of what consists of primitives along those of 26 directions of space, and
  /// `outward`, to a hundredth of `most`. `most` where x is outside, and in what is put together from meshes: asking those of many
  /// points would take too long.
  double at(Vec3d x, Vec3d outward, double most) const;
  /// The face of the shape that x lies beneath: the ways out along `outward`, a unit vector, and beside it end in one plane, to a twentieth of
  /// `most`. Of a mesh the nearest triangle. Empty where another face is near, where x is outside or lies deeper than `most`, and in what is
  /// put together from meshes.
  std::optional<ShapeFace> face(Vec3d x, Vec3d outward, double most) const;

 private:
  double along(Vec3d x, Vec3d direction, double most, double share = 0.01) const;
  bool is_beside_another(Vec3d x, Vec3d normal, double within) const;
  struct Plane {
    Vec3d normal;
    double bend = 0;
  };
  std::optional<Plane> plane(Vec3d x, Vec3d direction, double most) const;

  Shape shape_;
  bool of_parts_ = false, is_mesh_ = false;
  MeshDistance mesh_;
};

}  // namespace v0
}  // namespace meltsim
