// SPDX-License-Identifier: Apache-2.0
// Adding to a World. Everything is checked before anything is changed.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "description/growth_sites.hpp"
#include "description/names.hpp"
#include "description/nozzle.hpp"
#include "description/validate.hpp"
#include "engine/held.hpp"
#include "engine/text.hpp"
#include "exec/threads.hpp"
#include "meltsim/physics/contact.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "shape/shape_limits.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using core::none;
using core::same_place;

namespace {
constexpr double most_points = 4e9;  // ids are 32 bits

// Particles nearer to a wall than this many spacings are squeezed: liquid by its image, a body by its support. A
// column of water that should reach 0.75 m/s within 40 ms reaches 1.2 at 0.48, 4.3 at 0.4, 11 at 0.3.
constexpr double least_wall_distance = 0.48;

bool inside_domain(const DomainDesc& d, Vec3d p) {
  return !d.bounded || (p.x >= d.min.x && p.y >= d.min.y && p.z >= d.min.z && p.x <= d.max.x &&
                        p.y <= d.max.y && p.z <= d.max.z);
}

/// Whether a particle at p is as far from walls, and from its images across periodic faces, as it can be at rest.
bool has_room(const DomainDesc& domain, Vec3d spacing, Vec3d p) {
  if (!domain.bounded) return true;
  const Vec3d below = p - domain.min, above = domain.max - p;
  const double distance[] = {below.x, above.x, below.y, above.y, below.z, above.z};
  const double least[] = {spacing.x, spacing.y, spacing.z};
  for (std::size_t face = 0; face < 6; ++face)
    if (domain.faces[face] != Face::open && distance[face] < least_wall_distance * least[face / 2])
      return false;
  return true;
}
bool has_room(const DomainDesc& domain, double spacing, Vec3d p) {
  return has_room(domain, Vec3d{spacing, spacing, spacing}, p);
}

/// A length that whole cells fill, as near to the spacing as can be; the spacing where that is not within an eighth.
double filling(double length, double spacing) {
  constexpr double most = 0.125, alike = 1e-6;
  constexpr double half =
      0.49;  // what is in the middle between two numbers has a site of the lattice on its very edge
  const double cells = std::floor(length / spacing + half), fitted = length / cells;
  const double off = std::fabs(fitted / spacing - 1);
  return cells >= 1 && off <= most && off > alike ? fitted : spacing;
}

/// Clear way ahead of a nozzle [spacings].
constexpr double nozzle_reach = 2;
/// How long a nozzle is: liquid in it moves at the nozzle's velocity whatever acts on it [spacings].
constexpr double nozzle_length = 2;
/// Memory of the host per point of a nozzle while it is laid out, at least.
constexpr double layout_bytes = 200;
}  // namespace

/// Whether a material can melt into what it names.
Status WorldImpl::check_melting(const MaterialDesc& m) const {
  if (!m.melts_into) return {};
  const std::string p = "material \"" + m.name + "\": ";
  if (!valid(m.melts_into))
    return invalid(p, "melts_into: no such material in this World; add the liquid first and pass its id");
  const MaterialDesc& liquid = materials[m.melts_into.index];
  if (liquid.dissolves_in)
    return invalid(p, "melts_into: \"", liquid.name, "\" is a species, no liquid of its own; melt into \"",
                   materials[liquid.dissolves_in.index].name, "\", which it dissolves in");
  if (liquid.melts_into)
    return invalid(p, "melts_into: \"", liquid.name, "\" melts itself (at ", liquid.melting_point,
                   "); name a liquid that does not");
  return check_expansion(m, desc.heat.time_scale);
}

void WorldImpl::push_material(const MaterialDesc& m) {
  species_.reserve(most_species);
  if (m.dissolves_in) state_.solute[species_.size()].assign(state_.position.size(), 0.0);
  materials.push_back(m);
  if (m.dissolves_in) species_.push_back(static_cast<std::uint32_t>(materials.size() - 1));
}

/// Takes the last material back.
void WorldImpl::pop_material() {
  if (materials.back().dissolves_in) {
    species_.pop_back();
    state_.solute[species_.size()].clear();
  }
  materials.pop_back();
  properties_ = material_properties();
  if (!rows_.empty()) rows_ = material_rows();  // they point to properties
}

Result<MaterialId> WorldImpl::add_material(const MaterialDesc& m) {
  if (Status s = core::validate(m); !s) return s.error();
  if (materials.size() > tag_material_mask)
    return Error{ErrorCode::capacity,
                 core::text("material \"", m.name, "\": a World holds at most 256 materials")};
  for (const MaterialDesc& other : materials)
    if (other.name == m.name)
      return invalid("material \"", m.name, "\": a material of this name exists; choose another name");
  if (Status s = check_melting(m); !s) return s.error();
  if (Status s = check_freezing(m); !s) return s.error();
  if (Status s = check_species(m); !s) return s.error();
  const bool planned = takes_new_plan() && !m.dissolves_in;
  if (!planned) fetch_state();
  push_material(m);
  try {
    properties_ = material_properties();
    if (Status s = check_curves(); !s) return pop_material(), s.error();
  } catch (...) {
    pop_material();
    throw;
  }
  if (planned) {
    liquid_there_.resize(materials.size(), 0);
    liquid_used_.resize(materials.size(), 0);
    solid_used_.resize(materials.size(), 0);
    if (Status s = adapt(); !s) {
      pop_material();
      liquid_there_.resize(materials.size());
      liquid_used_.resize(materials.size());
      solid_used_.resize(materials.size());
      return s.error();
    }
  } else {
    dirty_ = measure_ = true;
  }
  return MaterialId{static_cast<std::uint32_t>(materials.size() - 1), number_};
}

/// A particle that melts takes the room of its liquid at once. Up to four times its own, that lifts the liquid around it by no
/// more than 1.5 times the work that it takes; at six times 4.5 times, at twenty the World halts (docs/stability.md).
Status WorldImpl::check_expansion(const MaterialDesc& m, double time_scale) const {
  constexpr double most = 4;
  if (!m.melts_into || desc.heat.model == HeatModel::none || time_scale == 0) return {};
  const MaterialDesc& liquid = materials[m.melts_into.index];
  const double ratio = m.density / least_density(m.melts_into.index);
  if (ratio <= most * (1 + 1e-9)) return {};
  return invalid("material \"", m.name, "\": density: ", m.density, " kg/m^3 is ", ratio, " times the ",
                 least_density(m.melts_into.index), " kg/m^3 of \"", liquid.name,
                 "\", which it melts into: it would take so many times its room at once, and burst; use at "
                 "most ",
                 most, " times, or heat.time_scale 0 where nothing is to melt");
}

/// Checks that the enthalpy of a material at a temperature gives that temperature back, and that a melting material is no colder than 0 K on the curve of
/// the liquid that it becomes: that of another solid where the liquid freezes into one.
Status WorldImpl::check_curves() const {
  const auto rows = material_rows();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const physics::MaterialRow<double>& row = rows[i];
    const std::string p = "material \"" + materials[i].name + "\": ";
    const double end = row.melting_point + row.melting_range;
    for (const double t : {absolute_zero, 0.0, row.melting_point, end, end + 100}) {
      const double back = physics::temperature_of(row, physics::enthalpy_of(row, t));
      if (!(std::fabs(back - t) <= 0.01 + 1e-6 * std::fabs(t)))
        return invalid(p, "heat_capacity: ", row.heat_capacity, " and ", row.liquid_heat_capacity,
                       " J/(kg K) of the liquid and a latent heat of ", row.latent_heat,
                       " J/kg are so far apart that ", t, " degrees are ", back,
                       " after rounding; those of real materials differ by less than 1e6");
    }
    if (row.melts == 0u) continue;
    const double melt = row.melting_enthalpy + row.melting_heat;
    const double t = physics::temperature_of(rows[row.liquid], melt);
    if (!(t >= absolute_zero)) {
      const MaterialDesc& solid = materials[rows[row.liquid].solid];
      return invalid(p, "melting_point: melt of ", end, " degrees would be at ", t, " in \"",
                     materials[row.liquid].name, "\", which freezes into \"", solid.name, "\" at ",
                     solid.melting_point, " degrees; give it a liquid of its own");
    }
  }
  return {};
}

/// A liquid that can freeze has the enthalpy curve of its solid: one solid per liquid, known before there is
/// liquid that cold.
Status WorldImpl::check_freezing(const MaterialDesc& m) {
  if (!m.freezes) return {};
  const std::string p = "material \"" + m.name + "\": freezes: ";
  if (!m.melts_into) return invalid(p, "a material that freezes must name its liquid in melts_into");
  for (const std::uint32_t k : species_)
    if (materials[k].dissolves_in == m.melts_into)
      return invalid(p, "\"", materials[k].name, "\" dissolves in \"", materials[m.melts_into.index].name,
                     "\", and a solution cannot freeze; use another liquid, or leave one of the two out");
  for (const MaterialDesc& other : materials)
    if (other.freezes && other.melts_into == m.melts_into)
      return invalid(p, "\"", materials[m.melts_into.index].name, "\" already freezes into \"", other.name,
                     "\"; a liquid freezes into one solid only");
  fetch_state();
  const auto rows = material_rows();
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    if (is_removed(state_.tag[i]) || material_of(state_.tag[i]) != m.melts_into.index) continue;
    const double t = physics::temperature_of(rows[m.melts_into.index], state_.enthalpy[i] / state_.mass[i]);
    if (t < m.melting_point + m.melting_range)
      return invalid(p, "there is \"", materials[m.melts_into.index].name, "\" at ", t,
                     " degrees already, below the end of melting at ", m.melting_point + m.melting_range,
                     "; add this material before that liquid");
  }
  return {};
}

/// As fetch_state(), but ids of displaced liquid may still stand in `state_`, marked as removed.
void WorldImpl::update_state() {
  if (!state_stale_) return;
  const core::WorldStatus s = engine->download(state_);
  fill_contents();
  state_stale_ = false;
  places_.reset();
  // An upload begins with a clean status; the present one is kept for synchronize().
  carried_.max_speed = std::max(carried_.max_speed, s.max_speed);
  carried_.max_density_ratio = std::max(carried_.max_density_ratio, s.max_density);
  carried_.courant_exceeded = carried_.courant_exceeded || s.courant_exceeded != 0;
  carried_.heat_bound_exceeded = carried_.heat_bound_exceeded || s.heat_bound_exceeded != 0;
  carried_.viscous_bound_exceeded = carried_.viscous_bound_exceeded || s.viscous_bound_exceeded != 0;
  carried_.solute_bound_exceeded = carried_.solute_bound_exceeded || s.solute_bound_exceeded != 0;
  note_halt(s, engine->fault());
}

void WorldImpl::fetch_state() {
  update_state();
  close_up();
}

void WorldImpl::round_to_precision(double& v) const {
  if (desc.precision != Precision::single_precision) return;
  const volatile float rounded =
      static_cast<float>(v);  // volatile: g++ 12 drops the rounding where it pairs two
  v = static_cast<double>(rounded);
}

/// Cells of liquid, and of fixed bodies, that reach from wall to wall, or from period to period, fill what is between: what a whole number of spacings leaves would be a
/// gap, which liquid falls into at the start, or through which it leaks. Along other axes, and where there are no walls, cells are a spacing long.
Vec3d WorldImpl::cell_of(const Box& bounds) const {
  const double dx = desc.spacing;
  const DomainDesc& d = desc.domain;
  const auto along = [&](int axis, double low, double high, double from, double to) {
    const auto face = static_cast<std::size_t>(2 * axis);
    const bool between = d.bounded && d.faces[face] != Face::open && d.faces[face + 1] != Face::open;
    constexpr double touching = 1e-3;  // [spacings]
    return between && low < from + touching * dx && high > to - touching * dx ? filling(to - from, dx) : dx;
  };
  return {along(0, bounds.min.x, bounds.max.x, d.min.x, d.max.x),
          along(1, bounds.min.y, bounds.max.y, d.min.y, d.max.y),
          along(2, bounds.min.z, bounds.max.z, d.min.z, d.max.z)};
}

/// What walls leave of the cell around a particle of a fixed body, which may lie nearer to them than half a spacing: its image has the rest. Cells that
/// are no spacing long fill what is between walls.
Vec3d WorldImpl::cut_at_walls(Vec3d x, Vec3d cell) const {
  const double dx = desc.spacing;
  const DomainDesc& d = desc.domain;
  if (!d.bounded) return cell;
  const auto along = [&](int axis, double length, double below, double above) {
    const auto face = static_cast<std::size_t>(2 * axis);
    if (std::fabs(length / dx - 1) > 1e-6) return length;
    if (d.faces[face] == Face::wall) length -= std::max(0.5 * dx - below, 0.0);
    if (d.faces[face + 1] == Face::wall) length -= std::max(0.5 * dx - above, 0.0);
    return std::fabs(length / dx - 1) < 1e-6 ? dx : length;
  };
  return {along(0, cell.x, x.x - d.min.x, d.max.x - x.x), along(1, cell.y, x.y - d.min.y, d.max.y - x.y),
          along(2, cell.z, x.z - d.min.z, d.max.z - x.z)};
}

/// Coordinates of lattice points. Of one spacing too many for longer cells the last lies beyond the wall, and goes.
void WorldImpl::put_in_cells(Vec3d o, Vec3d cell, std::vector<Vec3i>& points,
                             std::vector<Vec3d>& positions) const {
  const double dx = desc.spacing;
  const Vec3d hi = desc.domain.max;
  const auto at = [&](const Vec3i& p) {
    return Vec3d{o.x + (p.x + 0.5) * cell.x, o.y + (p.y + 0.5) * cell.y, o.z + (p.z + 0.5) * cell.z};
  };
  // A shape that reaches beyond the domain is another matter: place() refuses it.
  const auto pushed_out = [&](double length, double x, double low, std::int64_t site, double high) {
    return length > dx && x > high && low + (static_cast<double>(site) + 0.5) * dx <= high;
  };
  const auto beyond = [&](const Vec3i& p) {
    const Vec3d x = at(p);
    return pushed_out(cell.x, x.x, o.x, p.x, hi.x) || pushed_out(cell.y, x.y, o.y, p.y, hi.y) ||
           pushed_out(cell.z, x.z, o.z, p.z, hi.z);
  };
  if (cell.x > dx || cell.y > dx || cell.z > dx)
    points.erase(std::remove_if(points.begin(), points.end(), beyond), points.end());
  const core::HostLoops shared = loops();
  positions.clear();
  shared.resize(positions, points.size());
  shared.pieces(points.size(), [&](std::size_t k, std::size_t end) {
    for (; k < end; ++k) positions[k] = at(points[k]);
  });
}

/// Leaves out points that are too near to walls.
void WorldImpl::leave_room(Vec3d cell, std::vector<Vec3i>& points, std::vector<Vec3d>& positions) const {
  const auto fits = [&](std::size_t k) { return has_room(desc.domain, cell, positions[k]); };
  if (loops().all_of(points.size(), fits)) return;
  std::size_t to = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!fits(k)) continue;
    points[to] = points[k];
    positions[to++] = positions[k];
  }
  points.resize(to);
  positions.resize(to);
}

/// Lattice points of a shape and their coordinates, in cells of this size. fixed: it stays where it is, so that nothing squeezes it.
/// origin: what stored coordinates are to be relative to once it is added.
Status WorldImpl::place(const Shape& shape, const char* what, bool fixed, Vec3d cell,
                        std::vector<Vec3i>& points, std::vector<Vec3d>& positions, Vec3d& origin) const {
  if (Status s = shape.validate(); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  const Box b = shape.bounds();
  const double dx = desc.spacing;
  if (Status s = check_lattice(b, lattice_origin(), dx); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  const core::HostLoops shared = loops();
  const auto each = [&shared](std::int64_t parts, const std::function<void(std::int64_t)>& part) {
    shared.each(parts, part);
  };
  if (Status s = lattice_points(shape, lattice_origin(), dx, each, points); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  if (points.empty())
    return invalid(what, "shape: contains no lattice point at spacing ", dx, " m (it spans ", b.min, " to ",
                   b.max, "); make it larger or lower the spacing");
  put_in_cells(lattice_origin(), cell, points, positions);
  if (desc.domain.bounded) {
    const Vec3d lo = desc.domain.min, hi = desc.domain.max;
    const auto within = [this](Vec3d p) { return inside_domain(desc.domain, p); };
    if (!shared.all_of(positions.size(), [&](std::size_t k) { return within(positions[k]); }))
      return invalid(what, "shape: reaches outside the domain ", lo, " to ", hi, ", for example at ",
                     *std::find_if_not(positions.begin(), positions.end(), within),
                     "; move or shrink it, or enlarge the domain");
  }
  const std::size_t inside = points.size();
  if (!fixed) leave_room(cell, points, positions);
  if (points.empty())
    return invalid(what, "shape: every one of its ", static_cast<std::uint64_t>(inside),
                   " points is nearer to a wall than half a spacing (", 0.5 * dx,
                   " m); make the domain a whole number of spacings wide, or the spacing smaller");
  return origin_for(positions, what, origin);
}

/// Keeps stored coordinates small enough: a unit in the last place below a thousandth of the spacing.
Status WorldImpl::origin_for(const std::vector<Vec3d>& positions, const char* what, Vec3d& origin) const {
  const double epsilon = desc.precision == Precision::single_precision ? 6.0e-8 : 1.2e-16;
  const auto reach = [](Vec3d p) { return std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}); };
  Vec3d lo = positions.front(), hi = positions.front();
  if (desc.domain.bounded) {
    lo = desc.domain.min;
    hi = desc.domain.max;
  } else {
    for (const Vec3d& p : positions) {
      lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
      hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
  }
  origin = origin_;
  if (!origin_set_) {
    // Zero unless that costs precision, so most hosts can ignore the origin. Rounding at every
    // step shakes what moves: a spinning cube of 0.6 m at 100 m had 7 % more energy after 1e6 steps in single
    // precision, at 10 m 0.03 % (validation case solid.drift_long).
    const bool far = std::max(reach(lo), reach(hi)) * epsilon > 1e-5 * desc.spacing;
    const Vec3d middle = (lo + hi) * 0.5;
    origin = far ? Vec3d{std::floor(middle.x), std::floor(middle.y), std::floor(middle.z)} : Vec3d{};
  }
  // A host passes and reads doubles relative to 0.
  const double span =
      std::max({reach(lo - origin), reach(hi - origin), 1.2e-16 / epsilon * std::max(reach(lo), reach(hi))});
  if (span * epsilon > 1e-3 * desc.spacing)
    return invalid(what, "shape: at ", span, " m from the origin ", origin, " a ",
                   desc.precision == Precision::single_precision ? "single" : "double",
                   "-precision coordinate resolves only ", span * epsilon,
                   " m, more than a thousandth of the spacing (", desc.spacing,
                   " m); use double precision, a smaller domain or a larger spacing");
  return {};
}

/// Whether coordinates relative to an origin that is not the World's own choice are as exact as those.
Status WorldImpl::check_origin(Vec3d origin) const {
  const double epsilon = desc.precision == Precision::single_precision ? 6.0e-8 : 1.2e-16;
  const auto reach = [](Vec3d p) { return std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}); };
  double span = 1e-16 * reach(origin) / epsilon;  // it is a double itself
  if (desc.domain.bounded)
    span = std::max({span, reach(desc.domain.min - origin), reach(desc.domain.max - origin)});
  if (span * epsilon <= 1e-3 * desc.spacing) return {};
  return invalid("snapshot: origin: coordinates relative to ", origin, " resolve only ", span * epsilon,
                 " m in this World, more than a thousandth of the spacing (", desc.spacing,
                 " m); restore it in a World of the same scene and precision");
}

/// Whether a particle of the material is representable in the World's precision, with all derived quantities: squares of speeds,
/// for example.
Status WorldImpl::check_numbers(const std::string& what, const MaterialDesc& m, double density,
                                double specific_enthalpy, Vec3d velocity) const {
  const bool single = desc.precision == Precision::single_precision;
  const double largest = single ? 1e37 : 1e300, smallest = single ? 1e-37 : 1e-300;
  const double volume = desc.spacing * desc.spacing * desc.spacing, mass = density * volume;
  const char* precision = single ? "single" : "double";
  if (!(mass > smallest && mass < largest && volume > smallest && volume < largest))
    return invalid(what, "material: a particle of \"", m.name, "\" has ", mass, " kg in ", volume,
                   " m^3, which ", precision, " precision cannot hold; use another spacing or density");
  if (!std::isfinite(specific_enthalpy * mass))
    return invalid(what, "temperature: the enthalpy of a particle of \"", m.name, "\" would be ",
                   specific_enthalpy * mass, " J; use another temperature or heat capacity");
  if (!(dot(velocity, velocity) < largest))
    return invalid(what, "velocity: the square of ", length(velocity), " m/s is more than ", precision,
                   " precision can hold; use a smaller velocity");
  return {};
}

/// So that adding them cannot fail halfway.
void WorldImpl::reserve(std::size_t particles, std::size_t vertices, std::size_t sites) {
  const core::HostLoops shared = loops();
  core::each_held(state_, species_.size(), [&](auto held, auto& array, const auto&) {
    shared.make_room(array, held.of_vertex ? vertices : particles);
  });
  shared.make_room(lattice_.vertex_site, vertices);
  shared.make_room(lattice_.vertex_body, vertices);
  shared.make_room(lattice_.contact_shape, vertices);
  shared.make_room(lattice_.vertex_coordinates, vertices);
  shared.make_room(lattice_.site_vertex, sites);
}

/// Entries for so many more particles, which put() fills.
void WorldImpl::extend(core::SceneState& to, std::size_t particles) const {
  const std::size_t n = to.position.size() + particles;
  core::each_held(to, species_.size(), [&](auto held, auto& array, const auto& added) {
    if (!held.of_vertex) array.resize(n, added);
  });
}

void WorldImpl::put(core::SceneState& to, std::size_t i, Vec3d position, Vec3d velocity, double density,
                    double specific_enthalpy, std::uint32_t tag, std::uint32_t vertex,
                    const Contents& fractions, Vec3d cell) const {
  double mass = density * cell.x * cell.y * cell.z;
  double volume = mass / density;
  round_to_precision(mass);
  round_to_precision(volume);
  round_to_precision(position.x);
  round_to_precision(position.y);
  round_to_precision(position.z);
  round_to_precision(velocity.x);
  round_to_precision(velocity.y);
  round_to_precision(velocity.z);
  to.position[i] = position;
  to.velocity[i] = velocity;
  to.mass[i] = mass;
  to.volume[i] = volume;
  to.enthalpy[i] = specific_enthalpy * mass;
  for (std::size_t k = 0; k < species_.size(); ++k) to.solute[k][i] = fractions[k] * mass;
  to.tag[i] = tag;
  to.vertex_of_id[i] = vertex;
}

void WorldImpl::append(core::SceneState& to, Vec3d position, Vec3d velocity, double density,
                       double specific_enthalpy, std::uint32_t tag, std::uint32_t vertex,
                       const Contents& fractions, Vec3d cell) const {
  const std::size_t i = to.position.size();
  extend(to, 1);
  put(to, i, position, velocity, density, specific_enthalpy, tag, vertex, fractions, cell);
}

/// Entries for so many more vertices, free or not there yet.
void WorldImpl::extend_vertices(std::size_t vertices) {
  const std::size_t n = state_.vertex_id.size() + vertices;
  core::each_held(state_, species_.size(), [&](auto held, auto& array, const auto& added) {
    if (held.of_vertex) array.resize(n, added);
  });
  lattice_.vertex_site.resize(n);
  lattice_.vertex_body.resize(n);
  lattice_.contact_shape.resize(n, {0, 0, 0, static_cast<float>(physics::largest_contact_radius)});
  lattice_.vertex_coordinates.resize(n);
}

void WorldImpl::put_vertex(std::size_t v, std::uint32_t id, std::uint32_t state, std::uint32_t piece) {
  state_.vertex_id[v] = id;
  state_.vertex_state[v] = state;
  state_.vertex_piece[v] = piece;
}

/// Grid of all particles, removed ones included. Only particles added since the last call are hashed, so that many
/// bodies cost as much as their particles.
const core::PointGrid& WorldImpl::places() {
  if (!places_) places_.emplace(same_place * desc.spacing);
  for (std::size_t i = places_->size(); i < state_.position.size(); ++i)
    places_->add(state_.position[i], static_cast<std::uint32_t>(i));
  return *places_;
}

/// Removes liquid. Before the first step ids close up (close_up()); later they stay and the particle is marked removed.
void WorldImpl::drop_fluid(std::uint32_t id) {
  state_.tag[id] |= tag_removed;
  if (steps > 0) ++state_.removed;
  else holes_.push_back(id);
}

/// Closes the gaps that displaced liquid left in ids, once for all bodies that displaced some.
void WorldImpl::close_up() {
  if (holes_.empty()) return;
  std::vector<std::uint8_t> drop(state_.position.size(), 0);
  for (const std::uint32_t id : holes_) drop[id] = 1;
  holes_.clear();
  leave_out(drop);
}

/// Leaves out particles, by id; the ids of others close up.
void WorldImpl::leave_out(const std::vector<std::uint8_t>& drop) {
  const auto close = [&drop](std::uint32_t& id) {
    id -= static_cast<std::uint32_t>(std::count(drop.begin(), drop.begin() + id, 1));
  };
  for (EmitterRecord& e : emitters_) close(e.first_id);
  for (LiquidFill& f : fills_) {
    close(f.first);
    close(f.end);
  }
  places_.reset();
  std::vector<std::uint32_t> id_of(drop.size(), none);
  std::uint32_t to = 0;
  for (std::size_t i = 0; i < drop.size(); ++i)
    if (drop[i] == 0u) id_of[i] = to++;
  core::each_held(state_, species_.size(), [&](auto held, auto& array, const auto&) {
    if (held.of_vertex) return;
    for (std::size_t i = 0; i < drop.size(); ++i)
      if (drop[i] == 0u) array[id_of[i]] = array[i];
    array.resize(to);
  });
  for (std::size_t v = 0; v < state_.vertex_id.size(); ++v) {
    std::uint32_t& id = state_.vertex_id[v];
    if (id == none) continue;
    id = id_of[id];
    if (id == none) state_.vertex_state[v] = core::vertex_free;  // may have melted in the last sub-step
  }
}

/// Whether there is room for a particle at x, as far as walls go.
bool WorldImpl::fits(Vec3d x) const {
  return inside_domain(desc.domain, x) && has_room(desc.domain, desc.spacing, x);
}

Error WorldImpl::all_taken(std::size_t points) {
  return invalid("fluid: shape: every one of its ", static_cast<std::uint64_t>(points),
                 " points is already taken; move it or leave it out");
}

/// Leaves out positions that particles have already, of which none is added meanwhile.
void WorldImpl::leave_out_taken(std::vector<Vec3d>& positions, Vec3d origin) {
  const core::PointGrid& there = places();
  const auto is_there = [this](std::uint32_t id) { return !is_removed(state_.tag[id]); };
  const auto taken = [&](const Vec3d& p) { return there.near(p - origin, is_there); };
  if (!loops().all_of(positions.size(), [&](std::size_t k) { return !taken(positions[k]); }))
    positions.erase(std::remove_if(positions.begin(), positions.end(), taken), positions.end());
}

Result<std::uint64_t> WorldImpl::add_fluid(const FluidDesc& f) {
  if (!valid(f.material))
    return invalid("fluid: material: no such material in this World; pass an id from add_material");
  if (materials[f.material.index].melts_into)
    return invalid("fluid: material: \"", materials[f.material.index].name,
                   "\" is a solid (it melts); fill with the liquid it becomes");
  Contents contents{};
  if (Status s = check_fractions("fluid: ", f.material, f.fractions, contents); !s) return s.error();
  if (Status s = core::validate_state("fluid: ", f.temperature, f.velocity); !s) return s.error();
  if (Status s = f.shape.validate(); !s)
    return Error{s.error().code, core::text("fluid: shape: ", s.error().message)};
  const Vec3d cell = cell_of(f.shape.bounds());
  std::vector<Vec3i> points;
  std::vector<Vec3d> positions;
  Vec3d origin;
  if (Status s = place(f.shape, "fluid: ", false, cell, points, positions, origin); !s) return s.error();
  if (const auto added = add_in_place(f, contents, positions, origin, cell)) return *added;
  update_state();
  lay_out();
  const double h = physics::enthalpy_of(material_rows()[f.material.index], f.temperature);
  const double density = mixed_density(physics::rest_density(material_rows()[f.material.index], h), contents);
  if (Status s = check_numbers("fluid: ", materials[f.material.index], density, h, f.velocity); !s)
    return s.error();
  pass_over_particles();
  const std::size_t before = state_.position.size(), points_in_shape = positions.size();
  leave_out_taken(positions, origin);
  reserve(positions.size(), 0, 0);
  extend(state_, positions.size());
  loops().pieces(positions.size(), [&](std::size_t k, std::size_t end) {
    for (; k < end; ++k)
      put(state_, before + k, positions[k] - origin, f.velocity, density, h, f.material.index, none, contents,
          cell);
  });
  if (positions.empty()) return all_taken(points_in_shape);
  if (steps == 0)
    fills_.push_back(
        {static_cast<std::uint32_t>(before), static_cast<std::uint32_t>(state_.position.size()), cell});
  settle_at(origin);
  return std::uint64_t{positions.size()};
}

/// Bytes that the host and the backend may still allocate.
double WorldImpl::free_room() const {
  return std::min(double(core::available_memory()), double(engine->free_bytes()));
}

/// What an emitter emits.
Status WorldImpl::check_liquid(const EmitterDesc& e, const std::string& what, Contents& contents) const {
  if (!valid(e.material))
    return invalid(what, "material: no such material in this World; pass an id from add_material");
  if (materials[e.material.index].melts_into)
    return invalid(what, "material: \"", materials[e.material.index].name, "\" is a solid; emit a liquid");
  return check_fractions(what, e.material, e.fractions, contents);
}

/// Whether particles of it are within what the precision holds.
Status WorldImpl::check_state_of(const EmitterDesc& e, const std::string& what, const Contents& contents,
                                 Vec3d velocity) const {
  const auto row = material_rows()[e.material.index];
  const double h = physics::enthalpy_of(row, e.temperature);
  return check_numbers(what, materials[e.material.index],
                       mixed_density(physics::rest_density(row, h), contents), h, velocity);
}

/// What a nozzle emits, and whether its place is in the domain.
Status WorldImpl::check_emitter(const EmitterDesc& e, const std::string& what, Contents& contents) const {
  if (Status s = check_liquid(e, what, contents); !s) return s;
  if (Status s = core::validate(e, desc.spacing); !s) return s;
  if (desc.domain.bounded) {
    const Vec3d lo = desc.domain.min, hi = desc.domain.max, c = e.center;
    if (!(c.x >= lo.x && c.y >= lo.y && c.z >= lo.z && c.x <= hi.x && c.y <= hi.y && c.z <= hi.z))
      return invalid(what, "center: ", c, " is outside the domain ", lo, " to ", hi, "; move the nozzle");
  }
  return check_state_of(e, what, contents, core::unit(e.axis) * e.speed);
}

/// Whether a layer of an emitter fits into memory, before anything is allocated.
Status WorldImpl::check_layer(const EmitterDesc& e, const std::string& what) const {
  const double per_layer = 1.02 * core::nozzle_area(e) / (desc.spacing * desc.spacing);
  if (per_layer <= most_points && per_layer * layout_bytes <= free_room()) return {};
  return Error{
      per_layer > most_points ? ErrorCode::invalid_argument : ErrorCode::out_of_memory,
      core::text(what, core::is_rectangle(e) ? "width: the opening of " : "radius: the opening of ",
                 core::nozzle_area(e), " m^2 makes about ", per_layer,
                 " particles a layer, more than there is memory for; narrow the nozzle or use a larger "
                 "spacing")};
}

/// The layers that an emitter will emit, and whether their particles can be numbered.
Status WorldImpl::plan_layers(EmitterRecord& r, const std::string& what) const {
  const EmitterDesc& e = r.desc;
  r.first_layer = layers_before(r, time);  // those before are not owed
  limit_layers(r);
  if (r.recycles()) return {};
  if (e.max_particles != 0 && e.max_particles < r.points)
    return invalid(what, "max_particles: ", e.max_particles, " is less than one layer of the nozzle (",
                   r.points, " particles); raise it");
  const double planned = double(r.layers - r.first_layer) * r.points;
  if (planned > most_points)
    return invalid(what, "until: would emit ", planned, " particles, more than ", most_points,
                   "; shorten it or set max_particles");
  return {};
}

Result<EmitterId> WorldImpl::add_emitter(const EmitterDesc& e) {
  if (e.level) return add_reservoir(e);
  EmitterRecord r;
  r.desc = e;
  if (r.desc.name.empty()) r.desc.name = core::numbered_name("emitter", emitters_);
  const std::string what = "emitter \"" + r.desc.name + "\": ";
  Contents contents{};
  if (Status s = check_emitter(r.desc, what, contents); !s) return s.error();
  if (Status s = check_layer(e, what); !s) return s.error();
  const core::NozzleLayer layer = core::nozzle_layer(e, desc.spacing);
  const std::vector<Vec3d>& disc = layer.points;
  r.layer_distance = layer.distance;
  r.held_layers =
      std::max(1u, static_cast<std::uint32_t>(std::lround(nozzle_length * desc.spacing / layer.distance)));
  core::WorldStatus status;
  const auto running = find_solids(e, r.held_layers * layer.distance, status);
  if (!running) return running.error();
  if (Status s = check_nozzle(e, what, disc, nullptr); !s) return s.error();
  if (Status s = check_faces(e, what, disc); !s) return s.error();
  if (room_behind(e, disc, r.held_layers * layer.distance)) r.lead = r.held_layers * layer.distance;
  Vec3d origin;
  if (Status s = origin_for({e.center}, what.c_str(), origin); !s) return s.error();
  r.contents = contents;
  r.points = static_cast<std::uint32_t>(disc.size());
  r.first_point = static_cast<std::uint32_t>(emitter_points_.size());
  if (e.recycle)
    if (Status s = plan_reserve(r, what); !s) return s.error();
  if (Status s = plan_layers(r, what); !s) return s.error();
  if (Status s = check_memory(r, what); !s) return s.error();
  take_up(r, disc, origin, *running, status);
  return EmitterId{static_cast<std::uint32_t>(emitters_.size() - 1), number_};
}

/// A nozzle and the points of its layers; running, status: of find_solids().
void WorldImpl::take_up(EmitterRecord& r, const std::vector<Vec3d>& disc, Vec3d origin, bool running,
                        const core::WorldStatus& status) {
  loops().make_room(emitter_points_, disc.size());
  emitters_.reserve(emitters_.size() + 1);
  if (r.recycles()) {
    fetch_state();
    pass_over_particles();
    put_in_reserve(r, r.desc.center - origin);
  }
  emitters_.push_back(r);
  emitters_.back().brings = emits(r);
  emitter_points_.insert(emitter_points_.end(), disc.begin(), disc.end());
  if (r.recycles()) settle_at(origin);
  else if (!running || !emitter_joins_in_place(status)) {
    fetch_state();
    pass_over_particles();
    settle_at(origin);
  }
}

/// Solid particles around a nozzle and its pipe, in found_. Whether the World runs, so that the emitter may join it as it is.
Result<bool> WorldImpl::find_solids(const EmitterDesc& e, double pipe, core::WorldStatus& status) {
  bool runs = edits_in_place();
  const double reach = core::nozzle_reach_across(e) + pipe + (nozzle_reach + 2) * desc.spacing;
  const Vec3d margin{reach, reach, reach}, center = e.center - origin_;
  const Vec3d low = center - margin, high = center + margin;
  if (runs) {
    const auto found = find(low, high, status);
    if (!found) return found.error();
    runs = *found;
  }
  if (!runs) {
    fetch_state();
    found_.clear();
    for (std::size_t i = 0; i < state_.position.size(); ++i) {
      const Vec3d x = state_.position[i];
      if (!is_solid(state_.tag[i]) || x.x < low.x || x.y < low.y || x.z < low.z || x.x > high.x ||
          x.y > high.y || x.z > high.z)
        continue;
      core::FoundParticle p;
      p.position = x;
      p.tag = state_.tag[i];
      found_.push_back(p);
    }
  }
  found_.erase(std::remove_if(found_.begin(), found_.end(),
                              [](const core::FoundParticle& p) { return !is_solid(p.tag); }),
               found_.end());
  return runs;
}

/// The emitter added last, without an upload. False: it takes one, for what it will bring there is no room.
bool WorldImpl::emitter_joins_in_place(const core::WorldStatus& status) {
  const EmitterRecord& e = emitters_.back();
  const std::uint64_t total = born_ + planned_emission();
  if (total > capacity_ || !same_search(total) || !holds_contents(e.contents)) return false;
  if (emits(e) && !comes_in_place(e.desc.temperature, status)) return false;
  const Change change(*this);
  searched_ = total;
  const auto before = derived();
  const std::size_t m = e.desc.material.index;
  if (emits(e)) note_liquid(m);
  densest_added_ = std::max(densest_added_, largest_density(m));
  const double g = length(desc.gravity);
  see(e.desc.center, g > 0 ? desc.gravity * (-1.0 / g) : Vec3d{});
  seen_.speed = std::max(seen_.speed, e.desc.speed);
  seen_emitters_ = emitters_.size();
  derive_sound_speed();
  look_now_ = true;
  mix();
  edited_in_place(before);
  plan_changed_ = true;  // its points
  return true;
}

/// Something was added, with stored coordinates relative to this origin.
void WorldImpl::settle_at(Vec3d origin) {
  origin_ = origin;
  origin_set_ = true;
  added_ = true;
  dirty_ = measure_ = true;
}

/// When a layer of a nozzle comes [s].
double WorldImpl::due(const EmitterRecord& e, std::uint64_t layer) const {
  return e.desc.from + double(layer) * e.layer_distance / e.desc.speed;
}

/// Layers whose time has come before t: a function of time alone, so that a World that halted, or was interrupted or
/// restored, owes the same layers.
std::uint64_t WorldImpl::layers_before(const EmitterRecord& e, double t) const {
  return layers_due(e, std::min(t, e.desc.until));
}

/// The same for a nozzle that never ends: afterwards it still releases layers.
std::uint64_t WorldImpl::layers_due(const EmitterRecord& e, double t) const {
  if (!(t > e.desc.from)) return 0;
  constexpr double most = 9e15;  // whole numbers are exact to there
  auto n = static_cast<std::uint64_t>(
      std::min(most, std::ceil((t - e.desc.from) * e.desc.speed / e.layer_distance)));
  // The estimate is off by one at most; due() decides.
  if (n > 0 && due(e, n - 1) >= t) --n;
  else if (due(e, n) < t && double(n) < most) ++n;
  return n;
}

/// How many layers there will be, those before the nozzle was added included.
void WorldImpl::limit_layers(EmitterRecord& e) const {
  if (e.reservoir()) return;  // it has none
  e.layers = layers_before(e, e.desc.until);
  if (e.desc.max_particles != 0 && !e.recycles())
    e.layers = std::min(e.layers, e.first_layer + e.skipped + e.desc.max_particles / e.points);
  e.layers = std::max(e.layers, e.first_layer);
}

/// Layers that have come by now.
std::uint64_t WorldImpl::next_layer(const EmitterRecord& e) const {
  return std::min(e.layers, std::max(e.first_layer, layers_before(e, time)));
}

/// Particles of new ids that it will bring.
std::uint64_t WorldImpl::to_come(const EmitterRecord& e) const {
  return e.recycles() ? 0 : (e.layers - next_layer(e)) * e.points;
}

/// Whether a nozzle can begin this far behind its centre: within the domain, off walls and bodies. Where it cannot, it ends
/// as far ahead. After find_solids().
bool WorldImpl::room_behind(const EmitterDesc& e, const std::vector<Vec3d>& disc, double distance) const {
  const double dx = desc.spacing;
  const Vec3d behind = core::unit(e.axis) * -distance;
  core::PointGrid own(same_place * dx);
  for (const Vec3d& p : disc) {
    const Vec3d x = e.center + p + behind;
    if (!inside_domain(desc.domain, x) || !has_room(desc.domain, dx, x)) return false;
    own.add(x, 0);
    own.add(x - behind * 0.5, 0);
  }
  const auto any = [](std::uint32_t) { return true; };
  for (const core::FoundParticle& p : found_)
    if (own.near(p.position + origin_, any)) return false;
  for (const EmitterRecord& other : emitters_) {
    if (other.desc.from >= e.until || e.from >= other.desc.until) continue;
    for (const Vec3d& p : places_of(other))
      if (own.near(p, any)) return false;
  }
  return true;
}

/// The pipe of a nozzle, in which particles are held: from its beginning to its centre.
std::vector<Vec3d> WorldImpl::places_of(const EmitterRecord& e) const {
  std::vector<Vec3d> places;
  const Vec3d axis = core::unit(e.desc.axis);
  const int layers = e.lead > 0 ? static_cast<int>(e.held_layers) : 0;
  for (int layer = 0; layer <= layers; ++layer)
    for (std::uint32_t k = 0; k < e.points; ++k)
      places.push_back(e.desc.center + emitter_points_[e.first_point + k] -
                       axis * (layer * e.layer_distance));
  return places;
}

/// A nozzle is a disc with thickness: its points and their outlets must be within the domain, off its walls, and off
/// bodies, after find_solids(), and other nozzles that are open at the same time. Of one that moves, `moved`, bodies are not looked
/// at: that would wait.
Status WorldImpl::check_nozzle(const EmitterDesc& e, const std::string& what, const std::vector<Vec3d>& disc,
                               const EmitterRecord* moved) const {
  const double dx = desc.spacing;
  const Vec3d ahead = core::unit(e.axis) * (nozzle_reach * dx);
  const std::string opening = core::is_rectangle(e)
                                  ? core::text("opening of ", e.width, " by ", e.height, " m")
                                  : core::text("disc of radius ", e.radius, " m");
  core::PointGrid own(same_place * dx);
  const auto any = [](std::uint32_t) { return true; };
  for (const Vec3d& p : disc) {
    const Vec3d x = e.center + p;
    // It may blow out through an open face, and where nothing bounds the domain.
    if (!inside_domain(desc.domain, x) || !has_room(desc.domain, dx, x))
      return invalid(what, "center: the nozzle's ", opening, " reaches into a wall or out of the domain at ",
                     x, "; move it or make it smaller, half a spacing (", 0.5 * dx, " m) off walls");
    if (!has_room(desc.domain, dx, x + ahead))
      return invalid(what, "center: the nozzle blows against a wall at ", x + ahead,
                     ", less than two spacings (", nozzle_reach * dx, " m) ahead; move it back or turn it");
    const Vec3d begin = x - core::unit(e.axis) * (moved != nullptr ? moved->lead : 0.0);
    if (!inside_domain(desc.domain, begin) || !has_room(desc.domain, dx, begin))
      return invalid(what, "center: the nozzle's pipe begins in a wall or out of the domain at ", begin,
                     "; keep it half a spacing (", 0.5 * dx, " m) off walls");
    own.add(x, 0);
    own.add(x + ahead * 0.5, 0);
  }
  for (std::size_t k = 0; k < found_.size() && moved == nullptr; ++k)
    if (own.near(found_[k].position + origin_, any))
      return invalid(what, "center: the nozzle's ", opening, " lies in body \"",
                     bodies_[body_of(found_[k].tag) - 1].desc.name, "\" at ", found_[k].position + origin_,
                     "; move the nozzle or the body a spacing apart");
  for (const EmitterRecord& other : emitters_) {
    if (&other == moved || other.desc.from >= e.until || e.from >= other.desc.until) continue;
    for (const Vec3d& p : places_of(other))
      if (own.near(p, any))
        return invalid(what, "center: the nozzle's opening overlaps that of emitter \"", other.desc.name,
                       "\" at ", p,
                       " while both are open; move one, or let one begin when the other has ended");
  }
  return {};
}

}  // namespace v0
}  // namespace meltsim
