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

/// One ellipsoid of a blend, along the axes of the World.
struct Ellipsoid {
  Vec3d center;          ///< [m]
  Vec3d radii{1, 1, 1};  ///< half axes [m], > 0
};

/// Triangles over shared vertices. Of shells that are closed and of one orientation, whichever it is, a point is inside where their
/// winding number is not 0: parts that overlap are one, and a shell within another is a cavity if it faces the other way. The
/// mesh need not be closed: of other shells a point is inside if an odd number of their surfaces is before it. It is looked at along
/// three axes and the majority decides, which tolerates small holes.
struct TriangleMesh {
  std::vector<Vec3d> vertices;         ///< [m]
  std::vector<std::uint32_t> indices;  ///< three per triangle, from 0
};
/// A part of space [m]. Shapes are immutable values; copies share their data.
class MELTSIM_API Shape {
 public:
  Shape();                                                 ///< contains nothing
  static Shape box(Vec3d min, Vec3d max);                  ///< axis-aligned box between two corners
  static Shape sphere(Vec3d center, double radius);        ///< ball
  static Shape capsule(Vec3d a, Vec3d b, double radius);   ///< all points within `radius` of the segment a-b
  static Shape cylinder(Vec3d a, Vec3d b, double radius);  ///< flat ends at a and b
  static Shape torus(Vec3d center, Vec3d axis, double major_radius, double minor_radius);  ///< ring
  /// Smooth union of ellipsoids; blend [m] is the width over which neighbours merge, 0 = sharp.
  static Shape blend(std::vector<Ellipsoid> parts, double blend);
  static Shape mesh(TriangleMesh mesh);           ///< inside of a triangle mesh
  static Shape unite(std::vector<Shape> parts);   ///< points in at least one part
  static Shape subtract(Shape from, Shape what);  ///< points in `from` and not in `what`
  /// Points in every part; contains nothing if there are no parts.
  static Shape intersect(std::vector<Shape> parts);

  /// The shape moved: x -> scale * R x + offset, R = rotation about `axis` by `angle` [rad].
  Shape transformed(Vec3d offset, Vec3d axis = {0, 1, 0}, double angle = 0, double scale = 1) const;

  bool contains(Vec3d point) const;  ///< whether `point` [m] is inside
  Box bounds() const;                ///< smallest box around it; min > max if the shape is empty
  bool empty() const;                ///< whether the shape is known to contain nothing
  /// The first reason why the shape cannot be sampled (non-finite or inverted extents), or success.
  Status validate() const;

  /// Returns the points origin + (i + 1/2) spacing of a cubic lattice, i integer, that lie inside. Order: x
  /// fastest, z slowest. Meshes are rastered once per call. Points on the lower faces of boxes and meshes are
  /// inside, points on the upper faces are not, so a box n spacings wide holds n points per axis in spite of
  /// rounding. Returns nothing for an invalid shape, a spacing that is not positive, bounds of more than 2^31
  /// points or farther than 1e9 spacings from the origin, and when host memory runs out.
  std::vector<Vec3i> lattice_points(Vec3d origin, double spacing) const;
  /// The same, with the reason for no points: errors invalid_argument, out_of_memory. `points` is then empty.
  Status lattice_points(Vec3d origin, double spacing, std::vector<Vec3i>& points) const;

 private:
  friend struct ShapeAccess;  // samples within a box
  explicit Shape(std::shared_ptr<const ShapeNode> node);
  std::shared_ptr<const ShapeNode> node_;
};

/// Reads an OBJ, STL (text or binary) or PLY (text or binary) file, recognised by its content; in builds with
/// MELTSIM_ASSIMP also glTF, FBX, Collada and all other formats of assimp, with the transforms of their nodes. Errors
/// name the file, the line or byte, and what was expected. Faces with more than three corners are split into a fan.
MELTSIM_API Result<TriangleMesh> read_mesh(const std::string& path);

}  // namespace v0
}  // namespace meltsim
