// SPDX-License-Identifier: Apache-2.0
// Solid shapes: what a body or a volume of liquid is sampled from. Immutable values, cheap to copy.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "meltsim/export.hpp"
#include "meltsim/result.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

class ShapeNode;

/// One ellipsoid of a blend: centre, half axes, all in metres.
struct Ellipsoid {
  Vec3d center;
  Vec3d radii{1, 1, 1};
};

/// Triangles over shared vertices, in any orientation. Need not be closed: points are classified by parity
/// along three axes and the majority decides, so small holes are tolerated. Regions covered twice are
/// outside: give parts that overlap as meshes of their own and unite them.
struct TriangleMesh {
  std::vector<Vec3d> vertices;
  std::vector<std::uint32_t> indices;  ///< three per triangle
};

class MELTSIM_API Shape {
 public:
  Shape();  ///< contains nothing
  static Shape box(Vec3d min, Vec3d max);
  static Shape sphere(Vec3d center, double radius);
  static Shape capsule(Vec3d a, Vec3d b, double radius);
  static Shape cylinder(Vec3d a, Vec3d b, double radius);
  static Shape torus(Vec3d center, Vec3d axis, double major_radius, double minor_radius);
  /// Smooth union of ellipsoids; blend [m] is the width over which neighbours melt together, 0 = sharp.
  static Shape blend(std::vector<Ellipsoid> parts, double blend);
  static Shape mesh(TriangleMesh mesh);
  static Shape unite(std::vector<Shape> parts);
  static Shape subtract(Shape from, Shape what);
  /// What lies in every part; nothing where there are none.
  static Shape intersect(std::vector<Shape> parts);

  /// The shape moved: x -> scale * R x + offset, R = rotation about `axis` by `angle` [rad].
  Shape transformed(Vec3d offset, Vec3d axis = {0, 1, 0}, double angle = 0, double scale = 1) const;

  bool contains(Vec3d point) const;
  Box bounds() const;  ///< min > max when empty
  bool empty() const;
  /// First reason why the shape cannot be sampled (non-finite or inverted extents), or success.
  Status validate() const;

  /// The cubic-lattice points origin + (i + 1/2) spacing, i integer, that lie inside. Order: x fastest, z
  /// slowest. Meshes are rastered once per call. Points on the lower faces of boxes and meshes are inside,
  /// those on the upper faces are not, so a box n spacings wide holds n points per axis in spite of rounding.
  /// Nothing comes back for shapes that are not valid, spacings that are not positive, bounds of more than
  /// 2^31 points or farther than 1e9 spacings from the origin, and when host memory runs out.
  std::vector<Vec3i> lattice_points(Vec3d origin, double spacing) const;
  /// The same, and why nothing came back: errors invalid_argument, out_of_memory. `points` is then empty.
  Status lattice_points(Vec3d origin, double spacing, std::vector<Vec3i>& points) const;

 private:
  friend struct ShapeAccess;  // samples within a box
  explicit Shape(std::shared_ptr<const ShapeNode> node);
  std::shared_ptr<const ShapeNode> node_;
};

/// Reads OBJ, STL (text or binary) or PLY (text or binary) by its content; in builds with MELTSIM_ASSIMP also
/// glTF, FBX, Collada and whatever else assimp reads, with the transforms of its nodes. Errors name the file,
/// the line or byte, and what was expected. Faces with more than three corners are split into a fan.
MELTSIM_API Result<TriangleMesh> read_mesh(const std::string& path);

}  // namespace v0
}  // namespace meltsim
