// SPDX-License-Identifier: Apache-2.0
// Adding to a World. Everything is checked before anything is changed.
#include <algorithm>
#include <cmath>
#include <string>

#include "core/growth_sites.hpp"
#include "core/shape_limits.hpp"
#include "core/text.hpp"
#include "core/validate.hpp"
#include "core/world_impl.hpp"
#include "meltsim/physics/heat.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using core::none;
using core::same_place;

namespace {
constexpr double most_points = 4e9;  // ids are 32 bits

// What is nearer to a wall than this many spacings is squeezed there, liquid by its image, a body by what it leans on. A
// column of water that should reach 0.75 m/s within 40 ms reaches 1.2 at 0.48, 4.3 at 0.4, 11 at 0.3.
constexpr double least_wall_distance = 0.48;

/// Whether a particle at p is as far from walls, and from its images across periodic faces, as it can be at rest.
bool has_room(const DomainDesc& domain, double spacing, Vec3d p) {
  if (!domain.bounded) return true;
  const Vec3d below = p - domain.min, above = domain.max - p;
  const double distance[] = {below.x, above.x, below.y, above.y, below.z, above.z};
  for (std::size_t face = 0; face < 6; ++face)
    if (domain.faces[face] != Face::open && distance[face] < least_wall_distance * spacing) return false;
  return true;
}
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

/// Lattice points of a shape and their coordinates. fixed: it stays where it is, so that nothing squeezes it.
Status WorldImpl::place(const Shape& shape, const char* what, bool fixed, std::vector<Vec3i>& points,
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
  const std::size_t inside = points.size();
  std::size_t to = 0;
  for (std::size_t k = 0; k < inside; ++k) {
    if (!fixed && !has_room(desc.domain, dx, positions[k])) continue;
    points[to] = points[k];
    positions[to++] = positions[k];
  }
  points.resize(to);
  positions.resize(to);
  if (to == 0)
    return invalid(what, "shape: every one of its ", static_cast<std::uint64_t>(inside),
                   " points is nearer to a wall than half a spacing (", 0.5 * dx,
                   " m); make the domain a whole number of spacings wide, or the spacing smaller");
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
  if (Status s = place(f.shape, "fluid: ", false, points, positions); !s) return s.error();
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

}  // namespace v0
}  // namespace meltsim
