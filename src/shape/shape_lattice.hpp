// SPDX-License-Identifier: Apache-2.0
// The cubic lattice a shape is sampled on, and the mask of its sites that lie inside.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "meltsim/result.hpp"
#include "meltsim/shape.hpp"
#include "shape/affine.hpp"

namespace meltsim {
inline namespace v0 {

class ShapeNode;

/// Sites origin + (i + 1/2) spacing in world space, seen from the frame of one node of a shape.
struct Lattice {
  Vec3d origin;
  double spacing = 1;
  Affine to_local;  ///< world -> the node's frame
  Affine to_world;  ///< its inverse

  Vec3d site(double x, double y, double z) const {
    return to_local(origin + Vec3d{x + 0.5, y + 0.5, z + 0.5} * spacing);
  }
  /// Where a local point lies in units in which site i is at i.
  Vec3d coordinates(Vec3d local) const {
    return (to_world(local) - origin) * (1 / spacing) - Vec3d{0.5, 0.5, 0.5};
  }
};

/// Sites lo <= i < hi.
struct SiteRange {
  Vec3i lo, hi;

  bool empty() const { return hi.x <= lo.x || hi.y <= lo.y || hi.z <= lo.z; }
  std::size_t width() const { return static_cast<std::size_t>(hi.x - lo.x); }
  std::size_t height() const { return static_cast<std::size_t>(hi.y - lo.y); }
  std::size_t depth() const { return static_cast<std::size_t>(hi.z - lo.z); }
  std::size_t count() const { return empty() ? 0 : width() * height() * depth(); }
};

/// One byte per site of the range, x fastest: non-zero inside.
struct SiteMask {
  SiteRange range;
  std::vector<std::uint8_t> inside;

  std::size_t row(std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z - range.lo.z) * range.height() +
            static_cast<std::size_t>(y - range.lo.y)) *
           range.width();
  }
};

/// The sites of `range` that can lie in a box given in world space: at most one too many on each side.
SiteRange crop(const SiteRange& range, const Box& world, const Lattice& lattice);

/// Samples a node on its own part of the range, so that many small parts cost what they hold.
SiteMask sample(const ShapeNode& node, const Lattice& lattice, const SiteRange& within);

/// Calls its second argument for 0, 1, ... of so many parts, in any order, perhaps in several threads.
using EachPart = std::function<void(std::int64_t parts, const std::function<void(std::int64_t)>& part)>;

/// Sites of a node, x fastest. Parts are layers of the lattice, which do not depend on how they are gone through.
std::vector<Vec3i> sites_inside(const ShapeNode& node, Vec3d origin, double spacing, const EachPart& each);

/// Shape::lattice_points, shared out.
Status lattice_points(const Shape& shape, Vec3d origin, double spacing, const EachPart& each,
                      std::vector<Vec3i>& points);

/// One bit per site of the range, x fastest: set inside.
struct SiteBits {
  SiteRange range;
  std::vector<std::uint32_t> inside;  ///< empty where no site is
};

/// The sites origin + (i + 1/2) spacing of a valid shape that lie in a box given in world space, with at most one more
/// on each side. Sampled in slabs, so that the memory needed is that of the bits. The shape's bounds within the box must
/// pass check_lattice.
SiteBits sample_bits(const Shape& shape, Vec3d origin, double spacing, const Box& within);

/// The same without outer layers in which nothing is inside.
SiteBits trimmed(const SiteBits& bits);

}  // namespace v0
}  // namespace meltsim
