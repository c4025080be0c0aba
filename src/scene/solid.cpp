// SPDX-License-Identifier: Apache-2.0
// Adding a body: its lattice, what it may grow into, what stands in its way.
#include <algorithm>
#include <cmath>
#include <string>

#include "description/growth_sites.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "frame/lattice.hpp"
#include "meltsim/physics/heat.hpp"
#include "shape/shape_limits.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using core::none;
using core::same_place;

namespace {
/// Sites of the box that a body may grow in: at some 400 bytes each, 50 GB.
constexpr double most_growth_sites = 134217728.0;
}  // namespace

/// The free sites a body may grow into, and the box of all of its sites. Occupied neighbours are not left
/// out: what stands there may move or melt, so topology.freeze looks when the time comes.
Status WorldImpl::place_growth(const SolidDesc& s, const std::string& what, const std::vector<Vec3i>& points,
                               std::vector<Vec3i>& free, core::SiteBox& box) const {
  box = core::box_of(points);
  const MaterialDesc& m = materials[s.material.index];
  if (s.growth < 0)
    return invalid(what, "growth: must be >= 0 lattice steps, got ", s.growth,
                   "; 0 lets liquid freeze only where the body was solid before");
  if (s.growth == 0) return {};
  if (!m.freezes && m.solubility_points.empty())
    return invalid(what, "growth: ", s.growth, " steps of \"", m.name,
                   "\", which does not freeze; set `freezes` on the material, or its solubility_points if it "
                   "is a species, or growth to 0");
  const double low[3] = {desc.domain.min.x, desc.domain.min.y, desc.domain.min.z};
  const double high[3] = {desc.domain.max.x, desc.domain.max.y, desc.domain.max.z};
  const Vec3d o = lattice_origin();
  const double origin[3] = {o.x, o.y, o.z};
  for (int a = 0; a < 3; ++a) {
    std::int64_t lo = box.low[a] - s.growth, hi = box.high[a] + s.growth;
    if (desc.domain.bounded) {  // sites whose centre lies inside
      lo = std::max(lo, static_cast<std::int64_t>(std::ceil((low[a] - origin[a]) / desc.spacing - 0.5)));
      hi = std::min(hi, static_cast<std::int64_t>(std::floor((high[a] - origin[a]) / desc.spacing - 0.5)));
    }
    box.low[a] = std::min(lo, box.low[a]);  // never less than the shape
    box.high[a] = std::max(hi, box.high[a]);
  }
  if (box.sites() > most_growth_sites)
    return invalid(what, "growth: ", s.growth, " steps make a box of ", box.sites(), " sites, more than ",
                   most_growth_sites, "; grow less, or bound the domain");
  free = core::growth_sites(points, s.growth, box);
  return {};
}

Result<BodyId> WorldImpl::add_solid(const SolidDesc& given) {
  SolidDesc s = given;
  const std::string name = s.name.empty() ? "body" + std::to_string(bodies_.size() + 1) : s.name;
  const std::string what = "body \"" + name + "\": ";
  const bool proxy = s.motion == Motion::proxy;
  if (s.fixed && (s.motion == Motion::kinematic || s.motion == Motion::rigid || proxy))
    return invalid(what, "fixed: a ",
                   proxy                       ? "proxy"
                   : s.motion == Motion::rigid ? "rigid body"
                                               : "kinematic body",
                   " moves; drop fixed, or use motion fixed");
  if (s.fixed) s.motion = Motion::fixed;
  s.fixed = s.motion == Motion::fixed || s.motion == Motion::kinematic;
  if (!(s.held_until >= 0))
    return invalid(what, "held_until: must be >= 0 s, got ", s.held_until,
                   "; 0 lets it go from the start, infinity holds it until World::hold(body, false)");
  const bool held = s.held_until > time;
  if (s.held_until > 0 && (s.fixed || proxy))
    return invalid(what, "held_until: only a free or rigid body can be let go; set motion to one of these");
  const bool kinematic = s.motion == Motion::kinematic, rigid = s.motion == Motion::rigid || proxy;
  if (!kinematic && !proxy && (s.pivot || s.max_speed != 0))
    return invalid(what, s.pivot ? "pivot" : "max_speed",
                   ": only of kinematic bodies and proxies; set motion to kinematic or proxy");
  if (!(std::isfinite(s.max_speed) && s.max_speed >= 0))
    return invalid(what, "max_speed: must be finite and >= 0 m/s, got ", s.max_speed);
  if (s.pivot && !finite(*s.pivot)) return invalid(what, "pivot: must be finite, got ", *s.pivot);
  if (body_names_.count(name) != 0) return invalid(what, "a body of this name exists; choose another name");
  if (bodies_.size() >= 65535) return Error{ErrorCode::capacity, what + "a World holds at most 65535 bodies"};
  if (!valid(s.material))
    return invalid(what, "material: no such material in this World; pass an id from add_material");
  const MaterialDesc& m = materials[s.material.index];
  if (Status st = core::validate_state(what.c_str(), s.temperature, s.velocity); !st) return st.error();
  if (m.dissolves_in && !(largest_solubility(m) < 1))
    return invalid(what, "material: \"", m.name, "\" mixes with \"", materials[m.dissolves_in.index].name,
                   "\" in any ratio (solubility 1), so that nothing holds a body of it together; fill with "
                   "fluid, or set "
                   "solubility below 1");
  if (!finite(s.angular_velocity))
    return invalid(what, "angular_velocity: must be finite, got ", s.angular_velocity);
  if (Status st = core::validate(s.surface, desc.heat.model, what + "surface."); !st) return st.error();
  if (Status st = check_proxy(s, what); !st) return st.error();
  const int wide = materials[s.material.index].region_half_width, most = most_half_width();
  if (s.motion == Motion::free && wide > most)
    return invalid(what, "material: \"", materials[s.material.index].name, "\" has a region_half_width of ",
                   wide, ", and its regions would reach across half of a periodic axis; use at most ", most,
                   " here, or a longer domain");
  if (!std::isfinite(s.heat_source) || (s.heat_source != 0 && desc.heat.model != HeatModel::enthalpy))
    return invalid(what, "heat_source: must be finite W/m^3 and needs heat.model enthalpy, got ",
                   s.heat_source, "; 0 is none");
  if (Status st = core::summable(what + "heat_source", s.heat_source, "W/m^3"); !st) return st.error();
  if (s.motion == Motion::fixed &&
      (dot(s.velocity, s.velocity) > 0 || dot(s.angular_velocity, s.angular_velocity) > 0))
    return invalid(what, "velocity: a fixed body cannot move, got ", s.velocity,
                   "; drop fixed or the velocity");
  std::vector<Vec3i> points;
  std::vector<Vec3d> positions;
  Vec3d origin;
  if (Status st = place(s.shape, what.c_str(), s.fixed, points, positions, origin); !st) return st.error();
  std::vector<Vec3i> free;
  core::SiteBox box;
  if (Status st = place_growth(s, what, points, free, box); !st) return st.error();
  // The body's box of sites, padded so that a region look-up never leaves it.
  // A modulus, and liquid, may widen regions later.
  const int pad = widest_half_width(m);
  const auto nx = static_cast<std::uint64_t>(box.extent(0) + 2 * pad),
             ny = static_cast<std::uint64_t>(box.extent(1) + 2 * pad),
             nz = static_cast<std::uint64_t>(box.extent(2) + 2 * pad);
  const std::uint64_t base = lattice_.site_vertex.size();
  if (double(base) + double(nx) * double(ny) * double(nz) >= double(none))
    return Error{ErrorCode::capacity,
                 core::text(what, "shape: its box of ", double(nx) * double(ny) * double(nz),
                            " lattice sites is more than 32 bits can number together with the ", base,
                            " of other bodies; use a larger spacing or smaller bodies")};
  update_state();
  const core::PointGrid& there = places();
  Vec3d center{};
  std::vector<std::uint32_t> displaced;
  for (const Vec3d& p : positions) {
    const Vec3d x = p - origin;
    std::uint32_t other = none;
    const auto look = [&](std::uint32_t id) {
      if (is_fluid(state_.tag[id])) displaced.push_back(id);
      if (is_solid(state_.tag[id])) other = id;
      return other != none;
    };
    if (there.near(x, look))
      return invalid(what, "shape: overlaps body \"", bodies_[body_of(state_.tag[other]) - 1].desc.name,
                     "\" at ", p, "; bodies must be a spacing apart, move one of them");
    center += x;
  }
  center = center * (1.0 / double(positions.size()));
  if (!displaced.empty() && !s.carve)
    return invalid(what, "carve: liquid occupies its place at ",
                   state_.position[*std::min_element(displaced.begin(), displaced.end())] + origin_,
                   " and carve is off; move the body or let it carve");
  core::PointGrid own(same_place * desc.spacing);
  if (!emitters_.empty())
    for (const Vec3d& p : positions) own.add(p - origin, 0);
  for (const EmitterRecord& e : emitters_) {
    if (!(time < e.desc.until)) continue;
    for (const Vec3d& p : places_of(e))
      if (own.near(p - origin, [](std::uint32_t) { return true; }))
        return invalid(what, "shape: lies on the nozzle of emitter \"", e.desc.name, "\" at ", p,
                       "; move one of them");
  }
  const double h = physics::enthalpy_of(material_rows()[s.material.index], s.temperature);
  if (s.pivot) center = *s.pivot - origin;
  if (proxy)
    if (Status st = make_proxy(what, points, positions, center + origin, s); !st) return st.error();
  const double density =
      proxy ? s.mass / (double(positions.size()) * desc.spacing * desc.spacing * desc.spacing) : m.density;
  double fastest = length(s.velocity);
  for (const Vec3d& p : positions)
    fastest = std::max(fastest, length(s.velocity + cross(s.angular_velocity, p - origin - center)));
  if (Status st = check_numbers(what, m, density, h, {fastest, 0, 0}); !st) return st.error();
  if (kinematic || proxy || held) s.max_speed = std::max(s.max_speed, fastest);
  if (event_watch_)
    if (Status st = check_touching(event_watch_->kinds, bodies_.size() + 1, "add_solid"); !st)
      return st.error();
  Contents pure{};
  if (m.dissolves_in) pure[species_of(s.material.index)] = 1;
  // From here on nothing fails.
  if (state_.motion.capacity() == bodies_.size()) state_.motion.reserve(2 * bodies_.size() + 1);
  if (lattice_.rests.capacity() == bodies_.size()) lattice_.rests.reserve(2 * bodies_.size() + 1);
  if (motions_.capacity() == bodies_.size()) motions_.reserve(2 * bodies_.size() + 1);
  if (meshes_.capacity() == bodies_.size()) meshes_.reserve(2 * bodies_.size() + 1);
  if (proxies_.capacity() == bodies_.size()) proxies_.reserve(2 * bodies_.size() + 1);
  if (state_.forces.capacity() == bodies_.size()) state_.forces.reserve(2 * bodies_.size() + 1);
  reserve(points.size(), points.size() + free.size(), nx * ny * nz);
  if (lattice_.bodies.size() == lattice_.bodies.capacity()) lattice_.bodies.reserve(2 * bodies_.size() + 1);
  if (bodies_.size() == bodies_.capacity()) bodies_.reserve(2 * bodies_.size() + 1);
  std::vector<std::uint32_t> stack;
  stack.reserve(points.size());
  BodyRecord record;
  record.desc = s;
  record.desc.name = name;
  record.density = density;
  record.watched = proxy;
  record.held = held;
  record.desc.fixed = s.fixed || held;
  if (holes_.capacity() - holes_.size() < displaced.size())
    holes_.reserve(2 * holes_.size() + displaced.size());
  body_names_.insert(name);
  for (const std::uint32_t id : displaced)
    if (is_fluid(state_.tag[id])) drop_fluid(id);  // several points may have met it

  core::BodyRow row;
  row.stride_y = static_cast<std::uint32_t>(nx);
  row.stride_z = static_cast<std::uint32_t>(nx * ny);
  row.region_half_width = rigid ? 0 : std::min(m.region_half_width, most_half_width());
  row.motion = motion_of(record, held);
  row.watched = proxy ? 1u : 0u;
  lattice_.site_vertex.resize(base + nx * ny * nz, none);
  record.first_vertex = static_cast<std::uint32_t>(lattice_.vertex_site.size());
  record.vertices = static_cast<std::uint32_t>(points.size());
  const auto site_of = [&](Vec3i p) {
    return base + std::uint64_t(p.x - box.low[0] + pad) + std::uint64_t(p.y - box.low[1] + pad) * nx +
           std::uint64_t(p.z - box.low[2] + pad) * nx * ny;
  };
  for (std::size_t k = 0; k < points.size(); ++k)
    lattice_.site_vertex[site_of(points[k])] = record.first_vertex + static_cast<std::uint32_t>(k);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec3i& p = points[k];
    const std::uint32_t site = static_cast<std::uint32_t>(site_of(p));
    int direct = 0;
    core::each_direct([&](int dx, int dy, int dz) {
      direct += lattice_.site_vertex[core::site_at(site, row, dx, dy, dz)] != none ? 1 : 0;
    });
    std::uint32_t tag =
        s.material.index | tag_solid | (static_cast<std::uint32_t>(bodies_.size() + 1) << tag_body_shift);
    if (direct < static_cast<int>(core::full_neighbours)) tag |= tag_surface;
    if (record.desc.fixed) tag |= tag_fixed;
    if (kinematic) tag |= tag_kinematic;
    const Vec3d x = positions[k] - origin;
    append_vertex(static_cast<std::uint32_t>(state_.position.size()), core::vertex_live, none);
    lattice_.vertex_site.push_back(site);
    lattice_.vertex_body.push_back(static_cast<std::uint32_t>(bodies_.size()));
    lattice_.vertex_coordinates.push_back(p);
    append(x, held ? Vec3d{} : s.velocity + cross(s.angular_velocity, x - center), density, h, tag,
           record.first_vertex + static_cast<std::uint32_t>(k), pure);
  }
  // Labels of the pieces the shape consists of: flood fill over the 26 direct neighbours.
  for (std::uint32_t v = record.first_vertex; v < record.first_vertex + record.vertices; ++v) {
    if (state_.vertex_piece[v] != none) continue;
    state_.vertex_piece[v] = v;
    stack.push_back(v);
    while (!stack.empty()) {
      const std::uint32_t u = stack.back();
      stack.pop_back();
      core::each_direct([&](int dx, int dy, int dz) {
        const std::uint32_t n = lattice_.site_vertex[core::site_at(lattice_.vertex_site[u], row, dx, dy, dz)];
        if (n == none || state_.vertex_piece[n] != none) return;
        state_.vertex_piece[n] = v;
        stack.push_back(n);
      });
    }
  }
  // Free sites come after all that are occupied; each is the label of nothing but itself.
  for (const Vec3i& p : free) {
    const auto v = static_cast<std::uint32_t>(lattice_.vertex_site.size());
    const std::uint64_t site = site_of(p);
    lattice_.site_vertex[site] = v;
    lattice_.vertex_site.push_back(static_cast<std::uint32_t>(site));
    lattice_.vertex_body.push_back(static_cast<std::uint32_t>(bodies_.size()));
    lattice_.vertex_coordinates.push_back(p);
    append_vertex(none, core::vertex_free, v);
  }
  core::BodyMotionRow rest;
  physics::RigidMotion motion;
  for (const Vec3d& p : positions) record.reach = std::max(record.reach, length(p - origin - center));
  rest.first_site = static_cast<std::uint32_t>(base);
  rest.first_vertex = record.first_vertex;
  record.pivot = center + origin;
  rest.spacing = desc.spacing;
  rest.mass = s.mass;
  rest.inertia = s.inertia;
  if (kinematic || proxy) {
    const Vec3d o = lattice_origin() - origin;
    const double dx = desc.spacing;
    rest.low = Vec3d{o.x + (box.low[0] - pad + 0.5) * dx, o.y + (box.low[1] - pad + 0.5) * dx,
                     o.z + (box.low[2] - pad + 0.5) * dx} -
               center;
    motion.from = motion.until = time;
    motion.first = motion.then = {center, {}, s.velocity, s.angular_velocity};
    record.rest_low = record.rest_high = positions.front() - origin - center;
    for (const Vec3d& p : positions) {
      const Vec3d r = p - origin - center;
      record.rest_low = {std::min(record.rest_low.x, r.x), std::min(record.rest_low.y, r.y),
                         std::min(record.rest_low.z, r.z)};
      record.rest_high = {std::max(record.rest_high.x, r.x), std::max(record.rest_high.y, r.y),
                          std::max(record.rest_high.z, r.z)};
    }
  }
  if (proxy) motion.then = {};  // no gap to close, no acceleration by the host
  lattice_.rests.push_back(rest);
  state_.motion.push_back(motion);
  motions_.push_back({});
  meshes_.push_back({});
  proxies_.push_back({});
  state_.forces.push_back({});
  solids_built_ += points.size();
  lattice_.bodies.push_back(row);
  lattice_.max_half_width = std::max(lattice_.max_half_width, row.region_half_width);
  bodies_.push_back(std::move(record));
  settle_at(origin);
  return BodyId{static_cast<std::uint32_t>(bodies_.size() - 1), number_};
}

}  // namespace v0
}  // namespace meltsim
