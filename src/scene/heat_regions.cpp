// SPDX-License-Identifier: Apache-2.0
// Regions that heat, cool or hold, and the surfaces of bodies and walls.
#include <algorithm>
#include <new>
#include <string>

#include "description/names.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "shape/shape_limits.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

/// The part of a box that particles can reach: walls and periodic faces keep them inside, bodies may leave through open
/// faces.
Box WorldImpl::reachable(Box box) const {
  if (!desc.domain.bounded) return box;
  const auto closed = [this](std::size_t face) { return desc.domain.faces[face] != Face::open; };
  const Vec3d lo = desc.domain.min, hi = desc.domain.max;
  if (closed(0)) box.min.x = std::max(box.min.x, lo.x);
  if (closed(1)) box.max.x = std::min(box.max.x, hi.x);
  if (closed(2)) box.min.y = std::max(box.min.y, lo.y);
  if (closed(3)) box.max.y = std::min(box.max.y, hi.y);
  if (closed(4)) box.min.z = std::max(box.min.z, lo.z);
  if (closed(5)) box.max.z = std::min(box.max.z, hi.z);
  return box;
}

/// The shape, and its images behind the periodic faces that it reaches across.
Shape WorldImpl::with_images(const Shape& shape) const {
  std::vector<Shape> all{shape};
  const Box box = shape.bounds();
  const Vec3d lo = desc.domain.min, hi = desc.domain.max;
  const auto reaches = [&](std::size_t axis, double low, double high, double from, double to, Vec3d period) {
    if (!core::is_periodic(desc.domain, axis)) return;
    const double slack = 1e-9 * (to - from);
    const std::size_t n = all.size();
    for (std::size_t k = 0; k < n; ++k) {
      if (low < from - slack) all.push_back(all[k].transformed(period));
      if (high > to + slack) all.push_back(all[k].transformed(period * -1.0));
    }
  };
  reaches(0, box.min.x, box.max.x, lo.x, hi.x, {hi.x - lo.x, 0, 0});
  reaches(1, box.min.y, box.max.y, lo.y, hi.y, {0, hi.y - lo.y, 0});
  reaches(2, box.min.z, box.max.z, lo.z, hi.z, {0, 0, hi.z - lo.z});
  return all.size() == 1 ? shape : Shape::unite(std::move(all));
}

Result<HeatRegionId> WorldImpl::add_heat_region(const HeatRegionDesc& r) {
  HeatRegionDesc region = r;
  if (region.name.empty()) region.name = core::numbered_name("heat", heat_regions_);
  const std::string what = "heat region \"" + region.name + "\": ";
  for (const HeatRegionRecord& other : heat_regions_)
    if (other.desc.name == region.name)
      return invalid(what, "a heat region of this name exists; choose another name");
  if (Status s = core::validate(region, desc.heat.model); !s) return s.error();
  if (Status s = region.shape.validate(); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  HeatRegionRecord record;
  record.moves = !region.path.empty();
  Result<SiteBits> sites = region_sites(region.shape, what, record.moves);
  if (!sites) return sites.error();
  record.sites = std::move(*sites);
  record.desc = std::move(region);
  record.serial = next_region_;
  const bool planned = takes_new_plan();
  if (!planned) fetch_state();
  heat_regions_.push_back(std::move(record));
  ++next_region_;
  if (planned) plan_changed_ = regions_act(time, std::max(time, plan_until_)) || plan_changed_;
  else dirty_ = true;
  return HeatRegionId{heat_regions_.back().serial, number_};
}

/// The cells of a region. One that moves has those beyond walls, too: it may bring them into the domain.
Result<SiteBits> WorldImpl::region_sites(const Shape& shape, const std::string& what, bool moves) const {
  const Shape all = with_images(shape);
  const Box bounds = all.bounds(), within = reachable(bounds);
  const auto side = [&](std::size_t axis, double at, double inside) {
    return moves && !core::is_periodic(desc.domain, axis) ? at : inside;
  };
  const Box box{{side(0, bounds.min.x, within.min.x), side(1, bounds.min.y, within.min.y),
                 side(2, bounds.min.z, within.min.z)},
                {side(0, bounds.max.x, within.max.x), side(1, bounds.max.y, within.max.y),
                 side(2, bounds.max.z, within.max.z)}};
  SiteBits sites;
  if (!inverted(box)) {
    if (Status s = check_lattice(box, lattice_origin(), desc.spacing); !s)
      return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
    sites = sample_bits(all, lattice_origin(), desc.spacing, box);
  }
  // What moves is looked for in one period, of which a layer too many would cover another.
  if (!sites.inside.empty()) return moves ? trimmed(sites) : sites;
  return invalid(what, "shape: contains no lattice point ",
                 desc.domain.bounded ? "of the domain at spacing " : "at spacing ", desc.spacing,
                 " m; make it larger or lower the spacing",
                 desc.domain.bounded ? ", or move it into the domain" : "");
}

/// Null: there is none.
HeatRegionRecord* WorldImpl::region_of(HeatRegionId id) {
  const auto found = std::find_if(heat_regions_.begin(), heat_regions_.end(),
                                  [id](const HeatRegionRecord& r) { return r.serial == id.index; });
  return id.generation == number_ && found != heat_regions_.end() ? &*found : nullptr;
}

Status WorldImpl::no_such_region(const char* call, HeatRegionId id) {
  return invalid(call, ": region: no heat region of this World has index ", id.index, " and generation ",
                 id.generation,
                 "; pass what add_heat_region() of this World returned, and nothing that was removed");
}

Status WorldImpl::remove_heat_region(HeatRegionId id) {
  HeatRegionRecord* const region = region_of(id);
  if (region == nullptr) return no_such_region("remove", id);
  const bool planned = takes_new_plan();
  if (!planned) fetch_state();
  see_added();
  if (planned && plan_changed_ && region->acts)  // heat flows since it came, as for a host that looked
    if (Status s = adapt(); !s) return s;
  plan_changed_ = plan_changed_ || region->acts;
  heat_regions_.erase(heat_regions_.begin() + (region - heat_regions_.data()));
  dirty_ = dirty_ || !planned;
  return {};
}

/// Its row among those that act.
std::uint32_t WorldImpl::region_row(const HeatRegionRecord& region) const {
  std::uint32_t row = 0;
  for (const HeatRegionRecord* r = heat_regions_.data(); r != &region; ++r) row += r->acts ? 1u : 0u;
  return row;
}

Status WorldImpl::move_heat_region(HeatRegionId id, Vec3d displacement, Vec3d velocity) {
  HeatRegionRecord* const region = region_of(id);
  if (region == nullptr) return no_such_region("move_heat_region", id);
  const std::string what = "move_heat_region: \"" + region->desc.name + "\": ";
  if (!(length(displacement) <= core::farthest_move))
    return invalid(what, "displacement: must be finite and at most ", core::farthest_move, " m, got ",
                   displacement);
  if (!(length(velocity) <= core::farthest_move))
    return invalid(what, "velocity: must be finite and at most ", core::farthest_move, " m/s, got ",
                   velocity);
  if (!region->moves) {
    Result<SiteBits> sites = region_sites(region->desc.shape, what, true);
    if (!sites) return sites.error();
    const bool planned = takes_new_plan();
    if (!planned) fetch_state();
    region->sites = std::move(*sites);
    region->moves = true;
    if (planned) plan_changed_ = plan_changed_ || region->acts;
    else dirty_ = true;
  }
  region->steered = true;
  region->since = time;
  region->displacement = displacement;
  region->velocity = velocity;
  if (!dirty_ && region->acts) engine->move_heat_region(region_row(*region), time, displacement, velocity);
  return {};
}

/// Conditions and regions as rows: a region becomes a bit per cell of its box.
void WorldImpl::fill_heat_boundary(core::SceneConstants& c) const {
  c.surroundings = surroundings(time);
  const double dx = desc.spacing;
  const Vec3d o = lattice_origin() - origin_;
  for (const HeatRegionRecord& region : heat_regions_) {
    if (!region.acts) continue;
    const HeatRegionDesc& r = region.desc;
    const SiteRange& sites = region.sites.range;
    core::HeatRegionRow<double> row;
    row.min = o + Vec3d{sites.lo.x * dx, sites.lo.y * dx, sites.lo.z * dx};
    row.inv_cell = 1 / dx;
    row.nx = static_cast<std::int32_t>(sites.width());
    row.ny = static_cast<std::int32_t>(sites.height());
    row.nz = static_cast<std::int32_t>(sites.depth());
    row.first_word = static_cast<std::uint32_t>(c.heat_region_cells.size());
    row.held = r.temperature ? 1u : 0u;
    row.temperature = r.temperature.value_or(0);
    row.source = r.source;
    row.from = r.from;
    row.until = r.until;
    row.moves = region.steered   ? core::region_goes_on
                : r.path.empty() ? core::region_rests
                                 : core::region_on_path;
    row.first_point = static_cast<std::uint32_t>(c.heat_region_path.size());
    row.points = static_cast<std::uint32_t>(r.path.size());
    c.heat_region_path.insert(c.heat_region_path.end(), r.path.begin(), r.path.end());
    row.since = region.since;
    row.displacement = region.displacement;
    row.velocity = region.velocity;
    c.heat_region_cells.insert(c.heat_region_cells.end(), region.sites.inside.begin(),
                               region.sites.inside.end());
    c.heat_regions.push_back(row);
  }
  for (const BodyRecord& b : bodies_)
    c.body_heat.push_back({core::condition_at(b.desc.surface, time), b.desc.heat_source});
  if (!bodies_heat()) c.body_heat.clear();
}

}  // namespace v0
}  // namespace meltsim
