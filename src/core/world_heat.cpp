// SPDX-License-Identifier: Apache-2.0
// Regions that heat, cool or hold, and the surfaces of bodies and walls.
#include <algorithm>
#include <new>
#include <string>

#include "core/shape_limits.hpp"
#include "core/text.hpp"
#include "core/validate.hpp"
#include "core/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

Result<HeatRegionId> WorldImpl::add_heat_region(const HeatRegionDesc& r) {
  HeatRegionDesc region = r;
  if (region.name.empty()) region.name = "heat" + std::to_string(heat_regions_.size() + 1);
  const std::string what = "heat region \"" + region.name + "\": ";
  for (const HeatRegionDesc& other : heat_regions_)
    if (other.name == region.name)
      return invalid(what, "a heat region of this name exists; choose another name");
  if (Status s = core::validate(region, desc.heat.model); !s) return s.error();
  if (Status s = region.shape.validate(); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  if (Status s = check_lattice(region.shape.bounds(), lattice_origin(), desc.spacing); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  std::vector<Vec3i> points;
  if (Status s = region.shape.lattice_points(lattice_origin(), desc.spacing, points); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  if (points.empty())
    return invalid(what, "shape: contains no lattice point at spacing ", desc.spacing,
                   " m; make it larger or lower the spacing");
  fetch_state();
  heat_regions_.push_back(region);
  dirty_ = true;
  return HeatRegionId{static_cast<std::uint32_t>(heat_regions_.size() - 1), 1};
}

/// Conditions and regions as rows: a region becomes a bit per cell of its box.
void WorldImpl::fill_heat_boundary(core::SceneConstants& c) const {
  for (std::size_t f = 0; f < 6; ++f)
    if (desc.domain.bounded) c.wall_heat[f] = core::condition_of(desc.domain.heat[f]);
  const double dx = desc.spacing;
  const Vec3d o = lattice_origin() - origin_;
  for (const HeatRegionDesc& r : heat_regions_) {
    std::vector<Vec3i> points;  // there are some, unless memory ran out
    if (!r.shape.lattice_points(lattice_origin(), dx, points)) throw std::bad_alloc();
    Vec3i lo = points.front(), hi = points.front();
    for (const Vec3i& p : points) {
      lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
      hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
    core::HeatRegionRow<double> row;
    row.min = o + Vec3d{lo.x * dx, lo.y * dx, lo.z * dx};
    row.inv_cell = 1 / dx;
    row.nx = hi.x - lo.x + 1;
    row.ny = hi.y - lo.y + 1;
    row.nz = hi.z - lo.z + 1;
    row.first_word = static_cast<std::uint32_t>(c.heat_region_cells.size());
    row.held = r.temperature ? 1u : 0u;
    row.temperature = r.temperature.value_or(0);
    row.source = r.source;
    row.from = r.from;
    row.until = r.until;
    const std::uint64_t cells = std::uint64_t(row.nx) * std::uint64_t(row.ny) * std::uint64_t(row.nz);
    c.heat_region_cells.resize(row.first_word + (cells + 31) / 32, 0u);
    for (const Vec3i& p : points) {
      const std::uint64_t bit =
          (std::uint64_t(p.z - lo.z) * std::uint64_t(row.ny) + std::uint64_t(p.y - lo.y)) *
              std::uint64_t(row.nx) +
          std::uint64_t(p.x - lo.x);
      c.heat_region_cells[row.first_word + (bit >> 5)] |= 1u << (bit & 31u);
    }
    c.heat_regions.push_back(row);
  }
  for (const BodyRecord& b : bodies_)
    c.body_heat.push_back({core::condition_of(b.desc.surface), b.desc.heat_source});
  const bool any = std::any_of(c.body_heat.begin(), c.body_heat.end(), [](const auto& b) {
    return b.source != 0 || b.surface.kind != physics::SurfaceHeat::insulated;
  });
  if (!any) c.body_heat.clear();
}

}  // namespace v0
}  // namespace meltsim
