// SPDX-License-Identifier: Apache-2.0
// Adding to a World. Everything is checked before anything is changed.
#include <algorithm>
#include <cmath>
#include <string>

#include "core/growth_sites.hpp"
#include "core/lattice.hpp"
#include "core/shape_limits.hpp"
#include "core/text.hpp"
#include "core/validate.hpp"
#include "core/world_impl.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/heat.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using core::none;

namespace {
/// Particles closer than this share of the spacing occupy the same place.
constexpr double same_place = 0.9;
constexpr double most_points = 4e9;  // ids are 32 bits
/// Sites of the box that a body may grow in: at some 400 bytes each, 50 GB.
constexpr double most_growth_sites = 134217728.0;
}  // namespace

Result<MaterialId> WorldImpl::add_material(const MaterialDesc& m) {
  if (Status s = core::validate(m); !s) return s.error();
  if (materials.size() > tag_material_mask)
    return Error{ErrorCode::capacity,
                 core::text("material \"", m.name, "\": a World holds at most 256 materials")};
  for (const MaterialDesc& other : materials)
    if (other.name == m.name)
      return invalid("material \"", m.name, "\": a material of this name exists; choose another name");
  if (m.melts_into) {
    const std::string p = "material \"" + m.name + "\": ";
    if (!valid(m.melts_into))
      return invalid(p, "melts_into: no such material in this World; add the liquid first and pass its id");
    const MaterialDesc& liquid = materials[m.melts_into.index];
    if (liquid.melts_into)
      return invalid(p, "melts_into: \"", liquid.name, "\" melts itself (at ", liquid.melting_point,
                     "); name a liquid that does not");
  }
  if (Status s = check_freezing(m); !s) return s.error();
  fetch_state();
  materials.push_back(m);
  properties_ = material_properties();
  dirty_ = true;
  return MaterialId{static_cast<std::uint32_t>(materials.size() - 1), 1};
}

/// A liquid that can freeze has the enthalpy curve of its solid: one solid per liquid, known before there is
/// liquid that cold.
Status WorldImpl::check_freezing(const MaterialDesc& m) {
  if (!m.freezes) return {};
  const std::string p = "material \"" + m.name + "\": freezes: ";
  if (!m.melts_into) return invalid(p, "a material that freezes must name its liquid in melts_into");
  for (const MaterialDesc& other : materials)
    if (other.freezes && other.melts_into == m.melts_into)
      return invalid(p, "\"", materials[m.melts_into.index].name, "\" already freezes into \"", other.name,
                     "\"; a liquid freezes into one solid only");
  fetch_state();
  const auto rows = material_rows();
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    if (is_removed(state_.tag[i]) || material_of(state_.tag[i]) != m.melts_into.index) continue;
    const double t = physics::temperature_of(rows[m.melts_into.index], state_.enthalpy[i] / state_.mass[i]);
    if (t < m.melting_point)
      return invalid(p, "there is \"", materials[m.melts_into.index].name, "\" at ", t,
                     " degrees already, below the melting point ", m.melting_point,
                     "; add this material before that liquid");
  }
  return {};
}

void WorldImpl::fetch_state() {
  if (!state_stale_) return;
  engine->download(state_);
  state_stale_ = false;
}

void WorldImpl::round_to_precision(double& v) const {
  if (desc.precision != Precision::single_precision) return;
  const volatile float rounded =
      static_cast<float>(v);  // volatile: g++ 12 drops the rounding where it pairs two
  v = static_cast<double>(rounded);
}

/// Lattice points of a shape and their coordinates relative to the origin.
Status WorldImpl::place(const Shape& shape, const char* what, std::vector<Vec3i>& points,
                        std::vector<Vec3d>& positions) {
  if (Status s = shape.validate(); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  const Box b = shape.bounds();
  const double dx = desc.spacing;
  if (Status s = check_lattice(b, lattice_origin(), dx); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  points = shape.lattice_points(lattice_origin(), dx);
  if (points.empty())
    return invalid(what, "shape: contains no lattice point at spacing ", dx, " m (it spans ", b.min, " to ",
                   b.max, "); make it larger or lower the spacing");
  const Vec3d o = lattice_origin();
  positions.clear();
  positions.reserve(points.size());
  for (const Vec3i& p : points)
    positions.push_back({o.x + (p.x + 0.5) * dx, o.y + (p.y + 0.5) * dx, o.z + (p.z + 0.5) * dx});
  if (desc.domain.bounded) {
    const Vec3d lo = desc.domain.min, hi = desc.domain.max;
    for (const Vec3d& p : positions)
      if (!(p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x <= hi.x && p.y <= hi.y && p.z <= hi.z))
        return invalid(what, "shape: reaches outside the domain ", lo, " to ", hi, ", for example at ", p,
                       "; move or shrink it, or enlarge the domain");
  }
  return choose_origin(positions, what);
}

/// Keeps stored coordinates small enough: a unit in the last place below a thousandth of the spacing.
Status WorldImpl::choose_origin(const std::vector<Vec3d>& positions, const char* what) {
  const double epsilon = desc.precision == Precision::single_precision ? 6.0e-8 : 1.2e-16;
  const auto reach = [](Vec3d p) { return std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}); };
  Vec3d lo = positions.front(), hi = positions.front();
  for (const Vec3d& p : positions) {
    lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
    hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
  }
  if (desc.domain.bounded) {
    lo = desc.domain.min;
    hi = desc.domain.max;
  }
  Vec3d origin = origin_;
  if (!origin_set_) {
    // Zero unless that costs precision: most hosts then never need to think of an origin. Rounding at every
    // step shakes what moves: a spinning cube of 0.6 m at 100 m had 7 % more energy after 1e6 steps in single
    // precision, at 10 m 0.03 % (validation case solid.drift_long).
    const bool far = std::max(reach(lo), reach(hi)) * epsilon > 1e-5 * desc.spacing;
    const Vec3d middle = (lo + hi) * 0.5;
    origin = far ? Vec3d{std::floor(middle.x), std::floor(middle.y), std::floor(middle.z)} : Vec3d{};
  }
  const double span = std::max(reach(lo - origin), reach(hi - origin));
  if (span * epsilon > 1e-3 * desc.spacing)
    return invalid(what, "shape: at ", span, " m from the origin ", origin, " a ",
                   desc.precision == Precision::single_precision ? "single" : "double",
                   "-precision coordinate resolves only ", span * epsilon,
                   " m, more than a thousandth of the spacing (", desc.spacing,
                   " m); use double precision, a smaller domain or a larger spacing");
  origin_ = origin;
  origin_set_ = true;
  return {};
}

void WorldImpl::append(Vec3d position, Vec3d velocity, double density, double specific_enthalpy,
                       std::uint32_t tag, std::uint32_t vertex) {
  double mass = density * desc.spacing * desc.spacing * desc.spacing;
  double volume = mass / density;
  round_to_precision(mass);
  round_to_precision(volume);
  round_to_precision(position.x);
  round_to_precision(position.y);
  round_to_precision(position.z);
  round_to_precision(velocity.x);
  round_to_precision(velocity.y);
  round_to_precision(velocity.z);
  state_.position.push_back(position);
  state_.velocity.push_back(velocity);
  state_.mass.push_back(mass);
  state_.volume.push_back(volume);
  state_.enthalpy.push_back(specific_enthalpy * mass);
  state_.tag.push_back(tag);
  state_.vertex_of_id.push_back(vertex);
}

core::PointGrid WorldImpl::solids_grid() const {
  core::PointGrid grid(desc.spacing);
  for (std::size_t i = 0; i < state_.position.size(); ++i)
    if (is_solid(state_.tag[i])) grid.add(state_.position[i], static_cast<std::uint32_t>(i));
  return grid;
}

/// Removes liquid. Before the first step ids close up; later they stay and the particle is marked removed.
void WorldImpl::drop_fluid(const std::vector<std::uint8_t>& drop) {
  if (steps > 0) {
    for (std::size_t i = 0; i < drop.size(); ++i)
      if (drop[i]) {
        state_.tag[i] |= tag_removed;
        ++state_.removed;
      }
    return;
  }
  std::size_t to = 0;
  for (std::size_t i = 0; i < drop.size(); ++i) {
    if (drop[i]) continue;
    state_.position[to] = state_.position[i];
    state_.velocity[to] = state_.velocity[i];
    state_.mass[to] = state_.mass[i];
    state_.volume[to] = state_.volume[i];
    state_.enthalpy[to] = state_.enthalpy[i];
    state_.tag[to] = state_.tag[i];
    state_.vertex_of_id[to] = state_.vertex_of_id[i];
    if (state_.vertex_of_id[to] != none)
      state_.vertex_id[state_.vertex_of_id[to]] = static_cast<std::uint32_t>(to);
    ++to;
  }
  state_.position.resize(to);
  state_.velocity.resize(to);
  state_.mass.resize(to);
  state_.volume.resize(to);
  state_.enthalpy.resize(to);
  state_.tag.resize(to);
  state_.vertex_of_id.resize(to);
}

Result<std::uint64_t> WorldImpl::add_fluid(const FluidDesc& f) {
  if (!valid(f.material))
    return invalid("fluid: material: no such material in this World; pass an id from add_material");
  if (materials[f.material.index].melts_into)
    return invalid("fluid: material: \"", materials[f.material.index].name,
                   "\" is a solid (it melts); fill with the liquid it becomes");
  if (Status s = core::validate_state("fluid: ", f.temperature, f.velocity); !s) return s.error();
  std::vector<Vec3i> points;
  std::vector<Vec3d> positions;
  if (Status s = place(f.shape, "fluid: ", points, positions); !s) return s.error();
  fetch_state();
  core::PointGrid taken(desc.spacing);
  for (std::size_t i = 0; i < state_.position.size(); ++i)
    if (!is_removed(state_.tag[i])) taken.add(state_.position[i], static_cast<std::uint32_t>(i));
  const double h = physics::enthalpy_of(material_rows()[f.material.index], f.temperature);
  const double density = physics::rest_density(material_rows()[f.material.index], h);
  const std::size_t before = state_.position.size();
  for (const Vec3d& p : positions) {
    const Vec3d x = p - origin_;
    if (taken.near(x, same_place * desc.spacing) >= 0) continue;
    append(x, f.velocity, density, h, f.material.index, none);
  }
  const std::uint64_t added = state_.position.size() - before;
  if (added == 0)
    return invalid("fluid: shape: every one of its ", static_cast<std::uint64_t>(positions.size()),
                   " points is already taken; move it or leave it out");
  dirty_ = true;
  return added;
}

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
  if (!m.freezes)
    return invalid(what, "growth: ", s.growth, " steps of \"", m.name,
                   "\", which does not freeze; set `freezes` on the material or growth to 0");
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

Result<BodyId> WorldImpl::add_solid(const SolidDesc& s) {
  const std::string name = s.name.empty() ? "body" + std::to_string(bodies_.size() + 1) : s.name;
  const std::string what = "body \"" + name + "\": ";
  for (const BodyRecord& b : bodies_)
    if (b.desc.name == name) return invalid(what, "a body of this name exists; choose another name");
  if (bodies_.size() >= 65535) return Error{ErrorCode::capacity, what + "a World holds at most 65535 bodies"};
  if (!valid(s.material))
    return invalid(what, "material: no such material in this World; pass an id from add_material");
  const MaterialDesc& m = materials[s.material.index];
  if (Status st = core::validate_state(what.c_str(), s.temperature, s.velocity); !st) return st.error();
  if (!finite(s.angular_velocity))
    return invalid(what, "angular_velocity: must be finite, got ", s.angular_velocity);
  if (Status st = core::validate(s.surface, desc.heat.model, what + "surface."); !st) return st.error();
  if (!std::isfinite(s.heat_source) || (s.heat_source != 0 && desc.heat.model != HeatModel::enthalpy))
    return invalid(what, "heat_source: must be finite W/m^3 and needs heat.model enthalpy, got ",
                   s.heat_source, "; 0 is none");
  if (s.fixed && (dot(s.velocity, s.velocity) > 0 || dot(s.angular_velocity, s.angular_velocity) > 0))
    return invalid(what, "velocity: a fixed body cannot move, got ", s.velocity,
                   "; drop fixed or the velocity");
  std::vector<Vec3i> points;
  std::vector<Vec3d> positions;
  if (Status st = place(s.shape, what.c_str(), points, positions); !st) return st.error();
  std::vector<Vec3i> free;
  core::SiteBox box;
  if (Status st = place_growth(s, what, points, free, box); !st) return st.error();
  // The body's box of sites, padded so that a region look-up never leaves it.
  // A modulus may widen regions later.
  const int pad = m.youngs_modulus > 0 ? physics::most_half_width : std::max(1, m.region_half_width);
  const auto nx = static_cast<std::uint64_t>(box.extent(0) + 2 * pad),
             ny = static_cast<std::uint64_t>(box.extent(1) + 2 * pad),
             nz = static_cast<std::uint64_t>(box.extent(2) + 2 * pad);
  const std::uint64_t base = lattice_.site_vertex.size();
  if (double(base) + double(nx) * double(ny) * double(nz) >= double(none))
    return Error{ErrorCode::capacity,
                 core::text(what, "shape: its box of ", double(nx) * double(ny) * double(nz),
                            " lattice sites is more than 32 bits can number together with the ", base,
                            " of other bodies; use a larger spacing or smaller bodies")};
  fetch_state();
  const core::PointGrid solids = solids_grid();
  core::PointGrid own(desc.spacing);
  Vec3d center{};
  for (const Vec3d& p : positions) {
    const Vec3d x = p - origin_;
    const std::int64_t other = solids.near(x, same_place * desc.spacing);
    if (other >= 0)
      return invalid(what, "shape: overlaps body \"",
                     bodies_[body_of(state_.tag[static_cast<std::size_t>(other)]) - 1].desc.name, "\" at ", p,
                     "; bodies must be a spacing apart, move one of them");
    own.add(x, 0);
    center += x;
  }
  center = center * (1.0 / double(positions.size()));
  std::vector<std::uint8_t> drop(state_.position.size(), 0);
  bool any = false;
  for (std::size_t i = 0; i < drop.size(); ++i)
    if (is_fluid(state_.tag[i]) && own.near(state_.position[i], same_place * desc.spacing) >= 0) {
      if (!s.carve)
        return invalid(what, "carve: liquid occupies its place at ", state_.position[i] + origin_,
                       " and carve is off; move the body or let it carve");
      drop[i] = 1;
      any = true;
    }
  if (any) drop_fluid(drop);

  core::BodyRow row;
  row.stride_y = static_cast<std::uint32_t>(nx);
  row.stride_z = static_cast<std::uint32_t>(nx * ny);
  row.region_half_width = m.region_half_width;
  row.fixed = s.fixed ? 1u : 0u;
  lattice_.site_vertex.resize(base + nx * ny * nz, none);
  BodyRecord record;
  record.desc = s;
  record.desc.name = name;
  record.first_vertex = static_cast<std::uint32_t>(lattice_.vertex_site.size());
  record.vertices = static_cast<std::uint32_t>(points.size());
  const auto site_of = [&](Vec3i p) {
    return base + std::uint64_t(p.x - box.low[0] + pad) + std::uint64_t(p.y - box.low[1] + pad) * nx +
           std::uint64_t(p.z - box.low[2] + pad) * nx * ny;
  };
  for (std::size_t k = 0; k < points.size(); ++k)
    lattice_.site_vertex[site_of(points[k])] = record.first_vertex + static_cast<std::uint32_t>(k);
  const double h = physics::enthalpy_of(material_rows()[s.material.index], s.temperature);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec3i& p = points[k];
    const std::uint32_t site = static_cast<std::uint32_t>(site_of(p));
    int direct = 0;
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          direct += lattice_.site_vertex[core::site_at(site, row, dx, dy, dz)] != none ? 1 : 0;
    std::uint32_t tag =
        s.material.index | tag_solid | (static_cast<std::uint32_t>(bodies_.size() + 1) << tag_body_shift);
    if (direct < static_cast<int>(core::full_neighbours)) tag |= tag_surface;
    if (s.fixed) tag |= tag_fixed;
    const Vec3d x = positions[k] - origin_;
    state_.vertex_id.push_back(static_cast<std::uint32_t>(state_.position.size()));
    lattice_.vertex_site.push_back(site);
    lattice_.vertex_body.push_back(static_cast<std::uint32_t>(bodies_.size()));
    lattice_.vertex_coordinates.push_back(p);
    append(x, s.velocity + cross(s.angular_velocity, x - center), m.density, h, tag,
           record.first_vertex + static_cast<std::uint32_t>(k));
    state_.vertex_state.push_back(1u);
    state_.vertex_piece.push_back(none);
    state_.region_rotation.push_back({});
    state_.contact_slip.push_back({});
  }
  // Labels of the pieces the shape consists of: flood fill over the 26 direct neighbours.
  std::vector<std::uint32_t> stack;
  for (std::uint32_t v = record.first_vertex; v < record.first_vertex + record.vertices; ++v) {
    if (state_.vertex_piece[v] != none) continue;
    state_.vertex_piece[v] = v;
    stack.push_back(v);
    while (!stack.empty()) {
      const std::uint32_t u = stack.back();
      stack.pop_back();
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const std::uint32_t n =
                lattice_.site_vertex[core::site_at(lattice_.vertex_site[u], row, dx, dy, dz)];
            if (n == none || state_.vertex_piece[n] != none) continue;
            state_.vertex_piece[n] = v;
            stack.push_back(n);
          }
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
    state_.vertex_id.push_back(none);
    state_.vertex_state.push_back(0u);
    state_.vertex_piece.push_back(v);
    state_.region_rotation.push_back({});
    state_.contact_slip.push_back({});
  }
  solids_built_ += points.size();
  lattice_.bodies.push_back(row);
  lattice_.max_half_width = std::max(lattice_.max_half_width, m.region_half_width);
  bodies_.push_back(record);
  dirty_ = true;
  return BodyId{static_cast<std::uint32_t>(bodies_.size() - 1), 1};
}

Result<EmitterId> WorldImpl::add_emitter(const EmitterDesc& e) {
  EmitterRecord r;
  r.desc = e;
  if (r.desc.name.empty()) r.desc.name = "emitter" + std::to_string(emitters_.size() + 1);
  const std::string what = "emitter \"" + r.desc.name + "\": ";
  if (!valid(e.material))
    return invalid(what, "material: no such material in this World; pass an id from add_material");
  if (materials[e.material.index].melts_into)
    return invalid(what, "material: \"", materials[e.material.index].name, "\" is a solid; emit a liquid");
  if (Status s = core::validate(r.desc, desc.spacing); !s) return s.error();
  if (desc.domain.bounded) {
    const Vec3d lo = desc.domain.min, hi = desc.domain.max, c = e.center;
    if (!(c.x >= lo.x && c.y >= lo.y && c.z >= lo.z && c.x <= hi.x && c.y <= hi.y && c.z <= hi.z))
      return invalid(what, "center: ", c, " is outside the domain ", lo, " to ", hi, "; move the nozzle");
  }
  const Vec3d axis = e.axis * (1.0 / length(e.axis));
  const Vec3d helper = std::fabs(axis.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  Vec3d u = cross(axis, helper);
  u = u * (1.0 / length(u));
  const Vec3d v = cross(axis, u);
  std::vector<Vec3d> disc;
  const double dx = desc.spacing;
  const int n = static_cast<int>(e.radius / dx) + 1;
  // Points at half-integers: a disc of radius R then holds about pi R^2/dx^2 of them.
  for (int b = -n; b < n; ++b)
    for (int a = -n; a < n; ++a) {
      const double s = (a + 0.5) * dx, t = (b + 0.5) * dx;
      if (s * s + t * t <= e.radius * e.radius) disc.push_back(u * s + v * t);
    }
  if (Status s = choose_origin({e.center}, what.c_str()); !s) return s.error();
  r.points = static_cast<std::uint32_t>(disc.size());
  r.first_point = static_cast<std::uint32_t>(emitter_points_.size());
  const double span = (e.until - e.from) * e.speed / dx;
  r.layers = std::isfinite(span) ? static_cast<std::uint64_t>(std::ceil(span)) : ~std::uint64_t{0};
  if (e.max_particles != 0) r.layers = std::min(r.layers, e.max_particles / r.points);
  if (double(r.layers) * r.points > most_points)
    return invalid(what, "until: would emit ", double(r.layers) * r.points, " particles, more than ",
                   most_points, "; shorten it or set max_particles");
  if (r.layers == 0)
    return invalid(what, "max_particles: ", e.max_particles, " is less than one layer of the nozzle (",
                   r.points, " particles); raise it");
  // Layers that would have come before now are not owed.
  if (time > e.from) r.next_layer = static_cast<std::uint64_t>(std::ceil((time - e.from) * e.speed / dx));
  fetch_state();
  emitter_points_.insert(emitter_points_.end(), disc.begin(), disc.end());
  emitters_.push_back(r);
  dirty_ = true;
  return EmitterId{static_cast<std::uint32_t>(emitters_.size() - 1), 1};
}

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
  if (region.shape.lattice_points(lattice_origin(), desc.spacing).empty())
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
    const auto points = r.shape.lattice_points(lattice_origin(), dx);
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

namespace {

double conductivity_of(const MaterialDesc& d) {
  return d.diffusivity ? physics::conductivity_of(*d.diffusivity, d.density, d.heat_capacity)
                       : d.conductivity;
}

physics::PropertyTable<double> table(const std::vector<PropertyPoint>& points) {
  physics::PropertyTable<double> t;
  for (const PropertyPoint& p : points) {
    t.temperature[t.points] = p.temperature;
    t.value[t.points++] = p.value;
  }
  return t;
}

/// The points, or the constant as a table of one.
physics::PropertyTable<double> capacity_table(const MaterialDesc& d) {
  return d.heat_capacity_points.empty() ? table({{0, d.heat_capacity}}) : table(d.heat_capacity_points);
}

double least(const std::vector<PropertyPoint>& points, double otherwise) {
  for (const PropertyPoint& p : points)
    otherwise = &p == points.data() ? p.value : std::min(otherwise, p.value);
  return otherwise;
}

bool has_points(const MaterialDesc& d) {
  return !d.conductivity_points.empty() || !d.heat_capacity_points.empty() || !d.viscosity_points.empty() ||
         !d.density_points.empty();
}

}  // namespace

/// The solid that material i freezes into; materials.size() if there is none.
std::size_t WorldImpl::freezes_into(std::size_t i) const {
  std::size_t s = 0;
  while (s < materials.size() && !(materials[s].freezes && materials[s].melts_into.index == i)) ++s;
  return s;
}

/// One per material, or none at all when no property depends on temperature.
std::vector<physics::MaterialProperties<double>> WorldImpl::material_properties() const {
  std::vector<physics::MaterialProperties<double>> all;
  if (std::none_of(materials.begin(), materials.end(), has_points)) return all;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const bool freezes = freezes_into(i) < materials.size();
    const MaterialDesc& m = freezes ? materials[freezes_into(i)] : materials[i];  // whose curve it has
    const MaterialDesc& l = m.melts_into ? materials[m.melts_into.index] : m;
    physics::MaterialProperties<double> p;
    p.conductivity = table(m.conductivity_points);
    p.liquid_conductivity = table(l.conductivity_points);
    p.viscosity = table(materials[i].viscosity_points);
    p.density = table(materials[i].density_points);
    if (!m.heat_capacity_points.empty() || !l.heat_capacity_points.empty()) {
      const double latent = desc.heat.model == HeatModel::enthalpy ? m.latent_heat : 0.0;
      p.curve = m.melts_into ? physics::make_enthalpy_curve(capacity_table(m), capacity_table(l),
                                                            m.melting_point, latent)
                             : physics::make_enthalpy_curve(capacity_table(m));
    }
    all.push_back(p);
  }
  return all;
}

std::vector<core::MaterialRow<double>> WorldImpl::material_rows() const {
  std::vector<core::MaterialRow<double>> rows;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const MaterialDesc& own = materials[i];
    const bool freezes = freezes_into(i) < materials.size();
    const MaterialDesc& m = freezes ? materials[freezes_into(i)] : own;  // whose enthalpy curve it has
    const MaterialDesc& l = m.melts_into ? materials[m.melts_into.index] : m;
    core::MaterialRow<double> r;
    r.density = own.density;
    r.tait_stiffness = physics::tait_stiffness(own.density, sound_speed_);
    r.viscosity = own.viscosity;
    r.conductivity = conductivity_of(m);
    r.diffusivity = physics::diffusivity_of(conductivity_of(own), own.density, own.heat_capacity);
    r.liquid_conductivity = conductivity_of(l);
    r.heat_capacity = least(m.heat_capacity_points, m.heat_capacity);
    r.liquid_heat_capacity = least(l.heat_capacity_points, l.heat_capacity);
    r.melts = own.melts_into ? 1u : 0u;
    r.freezes = freezes ? 1u : 0u;
    r.plateau = r.melts | r.freezes;
    r.liquid = own.melts_into ? own.melts_into.index : static_cast<std::uint32_t>(i);
    r.solid = static_cast<std::uint32_t>(freezes ? freezes_into(i) : i);
    if (r.plateau != 0u) {
      // The models without enthalpy know no latent heat.
      r.latent_heat = desc.heat.model == HeatModel::enthalpy ? m.latent_heat : 0.0;
      r.melting_point = m.melting_point;
      r.melting_enthalpy = physics::capacity_integral(capacity_table(l), m.melting_point) - r.latent_heat;
    }
    if (!properties_.empty()) r.tables = &properties_[i];
    r.shape_stiffness = own.stiffness;
    r.modulus_rate = own.youngs_modulus / (own.density * desc.spacing * desc.spacing);
    r.shape_damping = own.damping;
    r.friction = own.friction;
    rows.push_back(r);
  }
  return rows;
}

}  // namespace v0
}  // namespace meltsim
