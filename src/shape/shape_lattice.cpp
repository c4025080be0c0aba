// SPDX-License-Identifier: Apache-2.0
#include "shape/shape_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <numeric>
#include <stdexcept>

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

std::vector<Vec3i> sites_inside(const ShapeNode& node, Vec3d origin, double spacing, const EachPart& each) {
  constexpr std::size_t least_sites = 8192;  // worth a thread's while
  const Lattice lattice{origin, spacing, {}, {}};
  const auto most = static_cast<std::int32_t>(max_site_index);
  const SiteRange r = crop({{-most, -most, -most}, {most, most, most}}, node.bounds({}), lattice);
  if (r.empty()) return {};
  const std::size_t thickness =
      node.holds_mesh() ? r.depth() : std::max<std::size_t>(1, least_sites / (r.width() * r.height()));
  std::vector<SiteMask> slabs((r.depth() + thickness - 1) / thickness);
  std::vector<std::size_t> first(slabs.size() + 1, 0);
  const auto parts = static_cast<std::int64_t>(slabs.size());
  each(parts, [&](std::int64_t k) {
    SiteMask& slab = slabs[static_cast<std::size_t>(k)];
    slab.range = r;
    slab.range.lo.z = r.lo.z + static_cast<std::int32_t>(static_cast<std::size_t>(k) * thickness);
    slab.range.hi.z = std::min(r.hi.z, slab.range.lo.z + static_cast<std::int32_t>(thickness));
    slab.inside.assign(slab.range.count(), 0);
    node.fill(lattice, slab);
    for (const std::uint8_t b : slab.inside) first[static_cast<std::size_t>(k) + 1] += b;
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Vec3i> sites(first.back());
  each(parts, [&](std::int64_t k) {
    const SiteRange& s = slabs[static_cast<std::size_t>(k)].range;
    const std::uint8_t* b = slabs[static_cast<std::size_t>(k)].inside.data();
    Vec3i* to = sites.data() + first[static_cast<std::size_t>(k)];
    for (std::int32_t z = s.lo.z; z < s.hi.z; ++z)
      for (std::int32_t y = s.lo.y; y < s.hi.y; ++y)
        for (std::int32_t x = s.lo.x; x < s.hi.x; ++x)
          if (*b++ != 0) *to++ = {x, y, z};
  });
  return sites;
}

Status lattice_points(const Shape& shape, Vec3d origin, double spacing, const EachPart& each,
                      std::vector<Vec3i>& points) {
  points.clear();
  const ShapeNode* const node = ShapeAccess::node(shape);
  if (node == nullptr) return {};
  if (Status s = shape.validate(); !s) return s;
  const auto full = [] {
    return Error{ErrorCode::out_of_memory, "host memory ran out while it was sampled; use a larger spacing"};
  };
  try {
    if (Status s = check_lattice(shape.bounds(), origin, spacing); !s) return s;
    points = sites_inside(*node, origin, spacing, each);
    return {};
  } catch (const std::bad_alloc&) {
    return full();
  } catch (const std::length_error&) {
    return full();
  }
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

SiteBits trimmed(const SiteBits& bits) {
  const SiteRange& r = bits.range;
  SiteRange tight{r.hi, r.lo};
  const auto each = [&](const auto& visit) {
    std::size_t bit = 0;
    for (std::int32_t z = r.lo.z; z < r.hi.z; ++z)
      for (std::int32_t y = r.lo.y; y < r.hi.y; ++y)
        for (std::int32_t x = r.lo.x; x < r.hi.x; ++x, ++bit)
          if (((bits.inside[bit >> 5] >> (bit & 31u)) & 1u) != 0u) visit(x, y, z);
  };
  each([&](std::int32_t x, std::int32_t y, std::int32_t z) {
    tight.lo = {std::min(tight.lo.x, x), std::min(tight.lo.y, y), std::min(tight.lo.z, z)};
    tight.hi = {std::max(tight.hi.x, x + 1), std::max(tight.hi.y, y + 1), std::max(tight.hi.z, z + 1)};
  });
  SiteBits all{tight, std::vector<std::uint32_t>((tight.count() + 31) / 32, 0u)};
  each([&](std::int32_t x, std::int32_t y, std::int32_t z) {
    const std::size_t bit = (static_cast<std::size_t>(z - tight.lo.z) * tight.height() +
                             static_cast<std::size_t>(y - tight.lo.y)) *
                                tight.width() +
                            static_cast<std::size_t>(x - tight.lo.x);
    all.inside[bit >> 5] |= 1u << (bit & 31u);
  });
  return all;
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
