// SPDX-License-Identifier: Apache-2.0
#include "shape/shape_lattice.hpp"

#include <algorithm>
#include <cmath>

#include "shape/shape_limits.hpp"
#include "shape/shape_node.hpp"

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

SiteBits sample_bits(const Shape& shape, Vec3d origin, double spacing, const Box& within) {
  const Lattice lattice{origin, spacing, {}, {}};
  const auto most = static_cast<std::int32_t>(max_site_index);
  const SiteRange everywhere{{-most, -most, -most}, {most, most, most}};
  SiteBits bits;
  const ShapeNode* node = ShapeAccess::node(shape);
  if (node == nullptr) return bits;
  const SiteRange r = crop(crop(everywhere, within, lattice), node->bounds({}), lattice);
  if (r.empty()) return bits;
  // A mesh is gone through once per slab: few slabs, 64 MB each.
  const std::size_t layer = r.width() * r.height();
  const auto thickness = static_cast<std::int32_t>(std::max<std::size_t>(1, (std::size_t{1} << 26) / layer));
  std::vector<std::uint32_t> inside((r.count() + 31) / 32, 0u);
  bool any = false;
  for (std::int32_t z = r.lo.z; z < r.hi.z; z += std::min(thickness, r.hi.z - z)) {
    const std::int32_t end = z + std::min(thickness, r.hi.z - z);
    const SiteMask slab = sample(*node, lattice, {{r.lo.x, r.lo.y, z}, {r.hi.x, r.hi.y, end}});
    const SiteRange& s = slab.range;
    for (std::int32_t sz = s.lo.z; sz < s.hi.z; ++sz)
      for (std::int32_t sy = s.lo.y; sy < s.hi.y; ++sy) {
        const std::uint8_t* from = slab.inside.data() + slab.row(sy, sz);
        std::size_t bit =
            (static_cast<std::size_t>(sz - r.lo.z) * r.height() + static_cast<std::size_t>(sy - r.lo.y)) *
                r.width() +
            static_cast<std::size_t>(s.lo.x - r.lo.x);
        for (std::size_t x = 0; x < s.width(); ++x, ++bit)
          if (from[x] != 0) {
            inside[bit >> 5] |= 1u << (bit & 31u);
            any = true;
          }
      }
  }
  if (!any) return bits;
  bits.range = r;
  bits.inside = std::move(inside);
  return bits;
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
