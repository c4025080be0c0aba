// SPDX-License-Identifier: Apache-2.0
#include "core/shape_lattice.hpp"

#include <cmath>

#include "core/shape_node.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

// Clamped before the conversion: a double outside the range of the integer has no defined conversion.
std::int32_t clamp_to(double v, std::int32_t lo, std::int32_t hi) {
  return static_cast<std::int32_t>(clamp(v, static_cast<double>(lo), static_cast<double>(hi)));
}

void crop_axis(std::int32_t& lo, std::int32_t& hi, double from, double to) {
  const std::int32_t old_lo = lo, old_hi = hi;
  lo = clamp_to(std::floor(from), old_lo, old_hi);
  hi = clamp_to(std::floor(to) + 2, old_lo, old_hi);
}

}  // namespace

SiteRange crop(const SiteRange& range, const Box& world, const Lattice& lattice) {
  const Lattice outer{lattice.origin, lattice.spacing, {}, {}};
  const Vec3d from = outer.coordinates(world.min), to = outer.coordinates(world.max);
  SiteRange r = range;
  crop_axis(r.lo.x, r.hi.x, from.x, to.x);
  crop_axis(r.lo.y, r.hi.y, from.y, to.y);
  crop_axis(r.lo.z, r.hi.z, from.z, to.z);
  return r;
}

SiteMask sample(const ShapeNode& node, const Lattice& lattice, const SiteRange& within) {
  SiteMask mask{crop(within, node.bounds(lattice.to_world), lattice), {}};
  mask.inside.assign(mask.range.count(), 0);
  if (!mask.inside.empty()) node.fill(lattice, mask);
  return mask;
}

void ShapeNode::fill(const Lattice& lattice, SiteMask& mask) const {
  const SiteRange& r = mask.range;
  std::size_t site = 0;
  for (std::int32_t z = r.lo.z; z < r.hi.z; ++z)
    for (std::int32_t y = r.lo.y; y < r.hi.y; ++y)
      for (std::int32_t x = r.lo.x; x < r.hi.x; ++x, ++site)
        mask.inside[site] = contains(lattice.site(x, y, z)) ? 1 : 0;
}

}  // namespace v0
}  // namespace meltsim
