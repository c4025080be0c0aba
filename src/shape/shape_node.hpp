// SPDX-License-Identifier: Apache-2.0
// The nodes of a Shape: an immutable tree, each node in its own frame.
#pragma once

#include <memory>

#include "meltsim/result.hpp"
#include "meltsim/shape.hpp"
#include "shape/shape_lattice.hpp"

namespace meltsim {
inline namespace v0 {

/// Coordinates on a face differ by rounding from where they are meant to be. Everything within this distance
/// counts as on the face, and each shape says on which side its faces lie.
inline double tie_width(double size, double magnitude) { return 1e-9 * size + 2e-15 * magnitude; }

/// A box, a sphere or a cylinder anywhere in the World.
struct PlacedPrimitive {
  enum class Kind { box, sphere, cylinder } kind = Kind::box;
  Vec3d center;   ///< [m]
  Vec3d axes[3];  ///< unit vectors along its sides; the last one along the cylinder
  Vec3d
      half;  ///< half its sides; sphere: the radius three times; cylinder: radius, radius, half its height [m]
};

class ShapeNode {
 public:
  explicit ShapeNode(int depth = 1) : depth_(depth) {}
  virtual ~ShapeNode() = default;
  ShapeNode(const ShapeNode&) = delete;
  ShapeNode& operator=(const ShapeNode&) = delete;

  virtual bool contains(Vec3d local) const = 0;
  virtual Box bounds(const Affine& to_world) const = 0;
  virtual Status validate() const = 0;
  /// Marks the sites inside; the mask arrives cleared. Only called on valid shapes.
  virtual void fill(const Lattice& lattice, SiteMask& mask) const;
  /// The mesh in World coordinates if the shape is one.
  virtual bool mesh(const Affine& to_world, TriangleMesh& out) const {
    static_cast<void>(to_world);
    static_cast<void>(out);
    return false;
  }

  /// Whether it is a mesh or has one in it: contains() then goes through its triangles, and fill() rounds its vertices relative to the
  /// range of the mask, so that parts of a lattice must not be filled on their own.
  virtual bool holds_mesh() const { return false; }

  /// The primitive if the shape is one, moved, turned and scaled. Only called on valid shapes.
  virtual bool primitive(const Affine& to_world, PlacedPrimitive& out) const {
    static_cast<void>(to_world);
    static_cast<void>(out);
    return false;
  }

  /// Levels of the tree below and including this node: recursion has to be bounded.
  int depth() const { return depth_; }

 private:
  int depth_;
};

using ShapePtr = std::shared_ptr<const ShapeNode>;

/// The tree of a Shape; null: it is empty.
struct ShapeAccess {
  static const ShapeNode* node(const Shape& shape) { return shape.node_.get(); }
};

}  // namespace v0
}  // namespace meltsim
