// SPDX-License-Identifier: Apache-2.0
#include "description/validate.hpp"

#include <cmath>
#include <utility>

#include "description/material_values.hpp"
#include "description/nozzle.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/isotropic_pressure.hpp"
#include "meltsim/physics/path.hpp"
#include "meltsim/physics/property_table.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace {

Status above(const std::string& field, double v, double low, const char* unit, const char* fix) {
  if (std::isfinite(v) && v > low) return {};
  return invalid(field, ": must be finite and > ", low, " ", unit, ", got ", v, "; ", fix);
}

Status at_least(const std::string& field, double v, double low, const char* unit, const char* fix) {
  if (std::isfinite(v) && v >= low) return {};
  return invalid(field, ": must be finite and >= ", low, *unit ? " " : "", unit, ", got ", v, "; ", fix);
}

Status within(const std::string& field, double v, double low, double high, const char* unit,
              const char* fix) {
  if (v >= low && v <= high) return {};
  return invalid(field, ": must be in ", low, "..", high, *unit ? " " : "", unit, ", got ", v, "; ", fix);
}

Status finite_vector(const std::string& field, Vec3d v) {
  if (finite(v)) return {};
  return invalid(field, ": must be finite, got ", v, "; check the computation that made it");
}

/// Largest number that single precision can square.
Status bounded_vector(const std::string& field, Vec3d v, const char* unit) {
  if (Status s = finite_vector(field, v); !s) return s;
  constexpr double most = 1e15;
  if (length(v) <= most) return {};
  return invalid(field, ": must be at most ", most, " ", unit, ", got ", v,
                 "; check the computation that made it");
}

Status positive_speed(const std::string& field, double speed, const char* advice) {
  if (Status s = above(field, speed, 0, "m/s", advice); !s) return s;
  return bounded_vector(field, {speed, 0, 0}, "m/s");
}

constexpr const char* face_names[6] = {"-x", "+x", "-y", "+y", "-z", "+z"};

double component(Vec3d v, std::size_t axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// The axis that a vector lies along; 3: none.
std::size_t axis_of(Vec3d v) {
  for (std::size_t a = 0; a < 3; ++a)
    if (component(v, a) != 0 && std::fabs(component(v, a)) > (1 - 1e-12) * length(v)) return a;
  return 3;
}

Status validate_outlet(const WorldDesc& d, std::size_t face, const std::string& p) {
  const OutletDesc& o = d.domain.outlets[face];
  if (!o.level && !o.speed) return {};
  if (!d.domain.bounded || d.domain.faces[face] != Face::open)
    return invalid(p, o.level ? "level" : "speed",
                   ": liquid leaves through open faces only; make that face open");
  if (o.level && o.speed)
    return invalid(p, "speed: liquid leaves at a speed or against a level; drop one of them");
  if (o.speed) return positive_speed(p + "speed", *o.speed, "a wall lets nothing out");
  if (!std::isfinite(*o.level))
    return invalid(p, "level: must be finite, got ", *o.level, " m; without one liquid falls out freely");
  const std::size_t down = axis_of(d.gravity);
  if (down == 3 || down == face / 2)
    return invalid(p, "level: needs gravity along an axis of the domain that lies in the face, got ",
                   d.gravity, "; set gravity so, or a speed");
  const std::size_t floor = 2 * down + (component(d.gravity, down) > 0 ? 1 : 0);
  if (d.domain.faces[floor] != Face::wall)
    return invalid(p, "level: needs a wall below as its floor; make that face a wall, or set a speed");
  if (const double head = outlet_head(d, face); !(head > 0))
    return invalid(p, "level: must be above the floor, got ", *o.level, " m, ", -head, " m below it");
  const double room = component(d.domain.max - d.domain.min, down);
  if (const double head = outlet_head(d, face); head > room * (1 + 1e-9))
    return invalid(p, "level: liquid stands up to the top of the domain at most, ", room,
                   " m above the floor, got ", *o.level, " m, ", head,
                   " m above it: nothing would leave; lower it, or make the domain higher");
  return {};
}

/// Walls slide; what has a part across its wall was meant to push.
Status validate_wall_velocity(const DomainDesc& d, std::size_t face) {
  const Vec3d v = d.velocity[face];
  if (!d.bounded || length(v) == 0) return {};
  const std::string p = std::string("domain.velocity[") + face_names[face] + "]";
  if (d.faces[face] != Face::wall)
    return invalid(p, ": is of a wall, and there is none at ", face_names[face], ", got ", v,
                   " m/s; make that face a wall, or leave the velocity out");
  const double across = component(v, face / 2);
  if (std::fabs(across) > 1e-6 * length(v))
    return invalid(p, ": walls slide along themselves, got ", v, " m/s, of which ", across,
                   " m/s lead across the wall; set that part to 0, or move a kinematic body");
  return {};
}

Status validate_domain(const DomainDesc& d, double support) {
  if (!d.bounded) return {};
  if (Status s = finite_vector("domain.min", d.min); !s) return s;
  if (Status s = finite_vector("domain.max", d.max); !s) return s;
  const double extent[3] = {d.max.x - d.min.x, d.max.y - d.min.y, d.max.z - d.min.z};
  const char* names[3] = {"x", "y", "z"};
  for (int a = 0; a < 3; ++a) {
    const Face low = d.faces[static_cast<std::size_t>(2 * a)],
               high = d.faces[static_cast<std::size_t>(2 * a + 1)];
    if (!(extent[a] > 0))
      return invalid("domain.max: must be above domain.min along ", names[a], ", got extent ", extent[a],
                     " m; swap or enlarge the corners");
    if ((low == Face::periodic) != (high == Face::periodic))
      return invalid("domain.faces: ", names[a], " is periodic on one side only; set both faces of the axis");
    if (low == Face::periodic && extent[a] < 3 * support)
      return invalid("domain.max: a periodic axis must span at least 3 support radii (", 3 * support,
                     " m), got ", extent[a], " m along ", names[a],
                     "; enlarge the domain or lower the spacing");
    if ((low == Face::wall && high == Face::wall) && extent[a] < 2 * support)
      return invalid("domain.max: walls must be at least 2 support radii (", 2 * support, " m) apart, got ",
                     extent[a], " m along ", names[a], "; enlarge the domain or lower the spacing");
    if (extent[a] / support > 1 << 20)
      return invalid("domain.max: more than 2^20 cells along ", names[a],
                     "; use an unbounded domain or a larger spacing");
  }
  if (Status s = at_least("domain.friction", d.friction, 0, "", "0 is frictionless"); !s) return s;
  if (Status s = within("domain.contact_angle", d.contact_angle, 0, 180, "degrees",
                        "0 wets, 90 is neutral, 180 repels");
      !s)
    return s;
  for (const Vec3d& v : d.velocity)
    if (Status s = bounded_vector("domain.velocity", v, "m/s"); !s) return s;
  return {};
}

Status validate_points(const std::string& field, const std::vector<PropertyPoint>& points, bool zero,
                       const char* unit) {
  if (points.empty()) return {};
  if (points.size() < 2 || points.size() > static_cast<std::size_t>(physics::property_points))
    return invalid(field, ": must be 2..", physics::property_points, " points, got ",
                   static_cast<std::uint64_t>(points.size()), "; a constant is one number, without points");
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!(std::isfinite(points[k].temperature) && points[k].temperature >= absolute_zero))
      return invalid(field, ": temperatures must be >= ", absolute_zero, " degrees Celsius, got ",
                     points[k].temperature, "; temperatures are in Celsius");
    if (k > 0 && !(points[k].temperature > points[k - 1].temperature))
      return invalid(field, ": temperatures must ascend, got ", points[k].temperature, " after ",
                     points[k - 1].temperature, "; sort the points");
    if (!(std::isfinite(points[k].value) && (points[k].value > 0 || (zero && points[k].value == 0))))
      return invalid(field, ": values must be finite and ", zero ? ">= 0" : "> 0", ", got ", points[k].value,
                     " at ", points[k].temperature, " degrees; correct that point");
    if (Status s = measurable(field, points[k].value, unit); !s) return s;
  }
  return {};
}

/// When something acts.
Status validate_times(const std::string& p, double from, double until) {
  if (!(std::isfinite(from) && from >= 0))
    return invalid(p, "from: must be finite and >= 0 s, got ", from, "; 0 starts at once");
  if (!(until > from))
    return invalid(p, "until: must be after from (", from, " s), got ", until, "; infinity never stops");
  return {};
}

Status validate_celsius(const std::string& field, double t) {
  if (!(std::isfinite(t) && t >= absolute_zero))
    return invalid(field, ": must be >= ", absolute_zero, " degrees Celsius, got ", t,
                   "; temperatures are in Celsius");
  constexpr double hottest = 1e15;  // what single precision can raise to the second power
  if (t > hottest)
    return invalid(field, ": must be at most ", hottest, " degrees Celsius, got ", t,
                   "; check the computation that made it");
  return {};
}

/// The flow curve of a liquid.
Status validate_flow(const MaterialDesc& m, const std::string& p) {
  if (Status s = at_least(p + "yield_stress", m.yield_stress, 0, "Pa", "ketchup is 15, 0 is none"); !s)
    return s;
  if (Status s = measurable(p + "yield_stress", m.yield_stress, "Pa"); !s) return s;
  if (Status s = within(p + "flow_index", m.flow_index, 0.1, 3, "",
                        "1 is a viscosity that does not depend on the shear rate, below 1 thins");
      !s)
    return s;
  if (Status s = validate_points(p + "yield_stress_points", m.yield_stress_points, true, "Pa"); !s) return s;
  if (!shears(m)) return {};
  const char* given = !m.yield_stress_points.empty() ? "yield_stress_points"
                      : m.yield_stress > 0           ? "yield_stress"
                                                     : "flow_index";
  if (!(std::isfinite(m.regularisation) && m.regularisation > 0))
    return invalid(p, "regularisation: must be finite and > 0 s where ", given, " is given, got ",
                   m.regularisation,
                   "; below a shear rate of 1/regularisation the liquid creeps, 100 is usual");
  if (Status s = measurable(p + "regularisation", m.regularisation, "s"); !s) return s;
  const double mu = largest_yield_stress(m) * m.regularisation;
  if (Status s = measurable(p + "yield_stress times regularisation", mu, "Pa s"); !s) return s;
  if (m.melts_into)
    return invalid(p, given, ": a solid's lattice does not flow; give it to the liquid it melts into");
  if (m.dissolves_in)
    return invalid(p, given,
                   ": of a species (dissolves_in) the viscosity is a constant; give it to the solvent");
  return {};
}

/// A material that is no species has nothing of one.
Status validate_no_species(const MaterialDesc& m, const std::string& p) {
  if (m.diffusivity_in != 0)
    return invalid(p, "dissolves_in: diffusivity_in (", m.diffusivity_in,
                   " m^2/s) is given, but no liquid; name the solvent, or leave diffusivity_in out");
  if (!m.solubility_points.empty())
    return invalid(
        p,
        "solubility_points: points are given, but no liquid (dissolves_in); name the solvent, or leave "
        "them out");
  if (m.transfer_coefficient)
    return invalid(p, "dissolves_in: transfer_coefficient (", *m.transfer_coefficient,
                   " m/s) is given, but no liquid; name the solvent, or leave transfer_coefficient out");
  return {};
}

Status validate_solubility(const MaterialDesc& m, const std::string& p) {
  if (!m.solubility_points.empty()) {
    if (Status s = validate_points(p + "solubility_points", m.solubility_points, false, "kg/kg"); !s)
      return s;
    for (const PropertyPoint& point : m.solubility_points)
      if (!(point.value < 1))
        return invalid(p, "solubility_points: must be in (0, 1) kg per kg of solution, got ", point.value,
                       " at ", point.temperature,
                       " degrees; give solubility 1 alone for liquids that mix in any ratio");
  } else if (!(m.solubility > 0 && m.solubility <= 1))
    return invalid(p, "solubility: must be in (0, 1] kg per kg of solution, got ", m.solubility,
                   "; sugar is 0.67, 1 mixes in any ratio");
  return {};
}

/// How fast a species spreads, and what heat that takes.
Status validate_dissolving(const MaterialDesc& m, const std::string& p) {
  if (!(std::isfinite(m.diffusivity_in) && m.diffusivity_in > 0))
    return invalid(p, "diffusivity_in: must be finite and > 0 m^2/s, got ", m.diffusivity_in,
                   m.diffusivity_in == 0 ? ", as where it is left out" : "",
                   "; salt in water is 1.6e-9, sugar 5e-10");
  if (Status s = measurable(p + "diffusivity_in", m.diffusivity_in, "m^2/s"); !s) return s;
  if (!std::isfinite(m.heat_of_solution))
    return invalid(p, "heat_of_solution: must be finite J/kg, got ", m.heat_of_solution,
                   "; salt is 6.7e4, 0 is none");
  if (Status s = measurable(p + "heat_of_solution", m.heat_of_solution, "J/kg"); !s) return s;
  if (m.transfer_coefficient) {
    if (Status s = above(p + "transfer_coefficient", *m.transfer_coefficient, 0, "m/s",
                         "leave it out for diffusion over one spacing");
        !s)
      return s;
    if (Status s = measurable(p + "transfer_coefficient", *m.transfer_coefficient, "m/s"); !s) return s;
  }
  return {};
}

/// Checks of a species that need no other species.
Status validate_species(const MaterialDesc& m, const std::string& p) {
  if (!m.dissolves_in) return validate_no_species(m, p);
  if (m.melts_into)
    return invalid(p, "dissolves_in: it melts (melts_into) already; a material does one of the two");
  if (Status s = validate_solubility(m, p); !s) return s;
  if (Status s = validate_dissolving(m, p); !s) return s;
  for (const auto& [name, points] :
       {std::pair{"viscosity_points", &m.viscosity_points}, std::pair{"density_points", &m.density_points},
        std::pair{"heat_capacity_points", &m.heat_capacity_points}})
    if (!points->empty())
      return invalid(p, name, ": of a species (dissolves_in) this is a constant; leave the points out");
  return {};
}

}  // namespace

double support_of(const WorldDesc& d) { return d.support_radius == 0 ? 2.5 * d.spacing : d.support_radius; }

Status measurable(const std::string& field, double v, const char* unit) {
  constexpr double most = 1e15, least = 1e-15;
  if (v == 0 || (std::fabs(v) >= least && std::fabs(v) <= most)) return {};
  return invalid(field, ": must be 0 or in ", least, "..", most, " ", unit, ", got ", v, "; check its unit");
}

Status summable(const std::string& field, double v, const char* unit) {
  constexpr double most = 1e100;
  if (std::fabs(v) <= most) return {};
  return invalid(field, ": must be in ", -most, "..", most, " ", unit, ", got ", v, "; check its unit");
}

namespace {

/// Spacing and support.
Status validate_lengths(const WorldDesc& d) {
  if (Status s = above("spacing", d.spacing, 0, "m", "typical 0.005..0.5"); !s) return s;
  if (!(std::isfinite(d.support_radius) && d.support_radius >= 0))
    return invalid("support_radius: must be finite and >= 0 m, got ", d.support_radius,
                   "; 0 means 2.5 spacings");
  // Squares of volumes and eighth powers of lengths are computed.
  const bool single_spacing = d.precision == Precision::single_precision;
  const double smallest = single_spacing ? 1e-6 : 1e-9, largest = single_spacing ? 1e4 : 1e9;
  if (!(d.spacing >= smallest * (1 - 1e-9) && d.spacing <= largest * (1 + 1e-9)))
    return invalid("spacing: must be in ", smallest, "..", largest, " m in ",
                   single_spacing ? "single" : "double", " precision, got ", d.spacing,
                   "; use another unit of length",
                   single_spacing ? ", or precision double for 1e-9..1e9 m" : "");
  const double ratio = support_of(d) / d.spacing;
  if (!(ratio >= 1.5 * (1 - 1e-9) && ratio <= 6 * (1 + 1e-9)))  // 6 x 0.2 m is above 6 spacings of 0.2 m
    return invalid("support_radius: must be 1.5..6 spacings, got ", ratio,
                   "; below 1.5 a particle has too few neighbours, 2..2.5 is usual");
  return {};
}

Status validate_sound(const WorldDesc& d) {
  if (d.sound_speed > 0 && !(d.sound_speed >= 1e-15 && d.sound_speed <= 1e15))
    return invalid("sound_speed: must be 0 or 1e-15..1e15 m/s, got ", d.sound_speed,
                   "; 0 derives it from the scene");
  // Pressure is c^2 times what densities differ by, and rounding makes them differ: by 6e-8 or 1e-16.
  const bool single = d.precision == Precision::single_precision;
  const double fastest_sound = single ? 1e5 : 1e13;
  if (d.sound_speed > fastest_sound)
    return invalid("sound_speed: rounding in ", single ? "single" : "double",
                   " precision would shake still liquid at ", d.sound_speed, " m/s; set at most ",
                   fastest_sound, " (water has 1480)", single ? ", or precision to double" : "");
  if (!(std::isfinite(d.sound_speed) && d.sound_speed >= 0))
    return invalid("sound_speed: must be finite and >= 0 m/s, got ", d.sound_speed,
                   "; 0 derives it from the scene");
  return {};
}

/// What is one of a few.
Status validate_choices(const WorldDesc& d) {
  if (Status s = known("backend", d.backend, Backend::cuda, "Backend", "automatic is the default"); !s)
    return s;
  if (Status s = known("precision", d.precision, Precision::double_precision, "Precision",
                       "single_precision is the default");
      !s)
    return s;
  if (Status s = known("neighbour_search", d.neighbour_search, NeighbourSearch::tree, "NeighbourSearch",
                       "automatic is the default");
      !s)
    return s;
  if (Status s =
          known("heat.model", d.heat.model, HeatModel::enthalpy, "HeatModel", "enthalpy is the default");
      !s)
    return s;
  for (const Face face : d.domain.faces)
    if (Status s = known("domain.faces", face, Face::periodic, "Face", "use wall, open or periodic"); !s)
      return s;
  if (Status s =
          known("viscosity", d.viscosity, Viscosity::implicit, "Viscosity", "automatic is the default");
      !s)
    return s;
  return known("stray", d.stray, Stray::halt, "Stray", "remove is the default");
}

/// What sets the length of a sub-step, and how far liquid may be compressed in it.
Status validate_steps(const WorldDesc& d) {
  // One and a half times the default is more by a rounding.
  const double courant = std::abs(d.courant - 0.6) < 1e-12 ? 0.6 : d.courant;
  if (Status s = within("courant", courant, 1e-3, 0.6, "", "0.4 is the default, larger ones make energy"); !s)
    return s;
  if (d.max_substeps < 1)
    return invalid("max_substeps: must be >= 1, got ", d.max_substeps, "; the default is 64");
  if (d.follow_sound_speed && d.sound_speed != 0)
    return invalid("follow_sound_speed: a sound_speed of ", d.sound_speed,
                   " m/s stays as it is; leave sound_speed 0 and set density_error, or follow_sound_speed to "
                   "false");
  if (d.density_error != 0) {
    if (Status s = within("density_error", d.density_error, 1e-5, 0.1, "", "left out it is 0.005"); !s)
      return s;
    if (d.sound_speed != 0)
      return invalid("density_error: a sound_speed of ", d.sound_speed,
                     " m/s is set, which decides; drop one of them");
  }
  return {};
}

Status validate_counts(const WorldDesc& d) {
  if (d.heat.interval < 0 || d.heat.interval > 1000)
    return invalid("heat.interval: must be in 0..1000 sub-steps, got ", d.heat.interval, "; 0 chooses");
  constexpr std::uint64_t most_ids = 0xffffffffu;
  if (d.reserved_particles >= most_ids)
    return invalid("reserved_particles: ", d.reserved_particles, " are more than 32-bit ids can number (",
                   most_ids, "); reserve what the host will add");
  if (d.pieces_interval < 1)
    return invalid("pieces_interval: must be >= 1, got ", d.pieces_interval, "; the default is 16");
  if (d.threads < 0) return invalid("threads: must be >= 0, got ", d.threads, "; 0 uses all processors");
  return {};
}

/// How heat and species are stepped.
Status validate_diffusion(const WorldDesc& d) {
  if (Status s = at_least("heat.time_scale", d.heat.time_scale, 0, "", "1 is real time, 0 freezes heat"); !s)
    return s;
  if (d.heat.max_stages < 2 || d.heat.max_stages > 1024)
    return invalid("heat.max_stages: must be in 2..1024, got ", d.heat.max_stages, "; the default is 64");
  if (d.heat.max_supersteps < 1 || d.heat.max_supersteps > 1000000)
    return invalid("heat.max_supersteps: must be in 1..1000000, got ", d.heat.max_supersteps,
                   "; the default is 64");
  if (Status s = at_least("solute.time_scale", d.solute.time_scale, 0, "", "1 is real time, 0 stops species");
      !s)
    return s;
  if (d.solute.max_supersteps < 1 || d.solute.max_supersteps > 1000000)
    return invalid("solute.max_supersteps: must be in 1..1000000, got ", d.solute.max_supersteps,
                   "; the default is 64");
  return at_least("heat.level_tolerance", d.heat.level_tolerance, 0, "K",
                  "0 lets heat flow however small differences are");
}

/// Heat, velocity and outlet of a face of the domain.
Status validate_face(const WorldDesc& d, std::size_t f) {
  const std::string p = std::string("domain.heat[") + face_names[f] + "].";
  if (Status s = validate(d.domain.heat[f], d.heat.model, p); !s) return s;
  const bool wall = d.domain.bounded && d.domain.faces[f] == Face::wall;
  if (!wall && condition_of(d.domain.heat[f]).kind != physics::SurfaceHeat::insulated)
    return invalid(p, "temperature, flux, convection and emissivity are for walls, and there is none at ",
                   face_names[f], "; make that face a wall");
  if (Status s = validate_wall_velocity(d.domain, f); !s) return s;
  return validate_outlet(d, f, std::string("domain.outlets[") + face_names[f] + "].");
}

/// Properties that are one number.
Status validate_constants(const MaterialDesc& m, const std::string& p) {
  if (Status s = above(p + "density", m.density, 0, "kg/m^3", "water is 1000"); !s) return s;
  if (Status s = at_least(p + "viscosity", m.viscosity, 0, "Pa s", "water is 0.001"); !s) return s;
  if (Status s =
          above(p + "conductivity", m.conductivity, 0, "W/(m K)", "water is 0.6; diffusivity 0 insulates");
      !s)
    return s;
  if (Status s = above(p + "heat_capacity", m.heat_capacity, 0, "J/(kg K)", "water is 4186"); !s) return s;
  if (m.diffusivity)
    if (Status s =
            at_least(p + "diffusivity", *m.diffusivity, 0, "m^2/s", "leave it out to use the conductivity");
        !s)
      return s;
  const struct {
    const char *name, *unit;
    double value;
  } numbers[] = {
      {"density", "kg/m^3", m.density},
      {"viscosity", "Pa s", m.viscosity},
      {"conductivity", "W/(m K)", m.conductivity},
      {"heat_capacity", "J/(kg K)", m.heat_capacity},
      {"latent_heat", "J/kg", std::isfinite(m.latent_heat) && m.latent_heat > 0 ? m.latent_heat : 0},
      {"diffusivity", "m^2/s", m.diffusivity ? *m.diffusivity : 0}};
  for (const auto& n : numbers)
    if (Status s = measurable(p + n.name, n.value, n.unit); !s) return s;
  return {};
}

/// Properties over temperature.
Status validate_tables(const MaterialDesc& m, const std::string& p) {
  if (m.diffusivity && !m.conductivity_points.empty())
    return invalid(p, "conductivity_points: diffusivity is given too; give one of the two");
  const struct {
    const char* name;
    const std::vector<PropertyPoint>& points;
    bool zero;  ///< a value of 0 makes sense
    const char* unit;
  } tables[] = {{"conductivity_points", m.conductivity_points, false, "W/(m K)"},
                {"heat_capacity_points", m.heat_capacity_points, false, "J/(kg K)"},
                {"viscosity_points", m.viscosity_points, true, "Pa s"},
                {"density_points", m.density_points, false, "kg/m^3"}};
  for (const auto& t : tables) {
    if (Status s = validate_points(p + t.name, t.points, t.zero, t.unit); !s) return s;
  }
  return {};
}

Status validate_melting(const MaterialDesc& m, const std::string& p) {
  if (Status s = at_least(p + "latent_heat", m.latent_heat, 0, "J/kg", "ice is 3.34e5"); !s) return s;
  if (std::isnan(m.melting_point) || m.melting_point < absolute_zero)
    return invalid(p, "melting_point: must be >= ", absolute_zero, " degrees Celsius, got ", m.melting_point,
                   "; temperatures are in Celsius, infinity means it never melts");
  // Enthalpies count from the melting point: farther away single precision would round off whole degrees.
  constexpr double highest_melting_point = 1e6;
  if (std::isfinite(m.melting_point) && m.melting_point > highest_melting_point)
    return invalid(p, "melting_point: must be at most ", highest_melting_point, " degrees Celsius, got ",
                   m.melting_point, "; leave it out for a solid that does not melt");
  if (std::isfinite(m.melting_point) && !m.melts_into)
    return invalid(
        p, "melts_into: a material with a melting point (", m.melting_point,
        " degrees Celsius) needs a liquid to become; add that liquid first, or leave melting_point out");
  if (Status s = at_least(p + "melting_range", m.melting_range, 0, "K", "chocolate melts over 5"); !s)
    return s;
  if (m.melting_range > highest_melting_point)
    return invalid(p, "melting_range: must be at most ", highest_melting_point, " K, got ", m.melting_range);
  if (m.melting_range > 0 && !m.melts_into)
    return invalid(p, "melting_range: a material that melts over ", m.melting_range,
                   " K needs a liquid to become; name it in melts_into, or leave melting_range out");
  if (!std::isfinite(m.melting_point) && m.melts_into)
    return invalid(p, "melting_point: a material that melts_into a liquid needs a finite melting point, got ",
                   m.melting_point, "; ice is 0");
  return {};
}

/// What holds a body together.
Status validate_lattice(const MaterialDesc& m, const std::string& p) {
  if (m.region_half_width < 0 || m.region_half_width > 8)
    return invalid(p, "region_half_width: must be in 0..8, got ", m.region_half_width, "; 2 is the default");
  if (!(m.stiffness > 0 && m.stiffness <= 1))
    return invalid(p, "stiffness: must be in (0, 1], got ", m.stiffness, "; 1 is stiffest");
  if (Status s = at_least(p + "youngs_modulus", m.youngs_modulus, 0, "Pa", "0 uses stiffness"); !s) return s;
  if (m.youngs_modulus > 0 && m.region_half_width == 0)
    return invalid(p, "region_half_width: loose particles (0) have no youngs_modulus, got ", m.youngs_modulus,
                   " Pa; set region_half_width to 1 or more, or youngs_modulus to 0");
  return within(p + "damping", m.damping, 0, 1, "", "0.1 is the default");
}

/// Surface and contacts.
Status validate_surface(const MaterialDesc& m, const std::string& p) {
  if (Status s = at_least(p + "surface_tension", m.surface_tension, 0, "N/m", "water is 0.072, 0 is none");
      !s)
    return s;
  if (Status s = measurable(p + "surface_tension", m.surface_tension, "N/m"); !s) return s;
  if (Status s = within(p + "contact_angle", m.contact_angle, 0, 180, "degrees",
                        "0 wets, 90 is neutral, 180 repels");
      !s)
    return s;
  return at_least(p + "friction", m.friction, 0, "", "0.3 is the default");
}

}  // namespace

Status validate(const WorldDesc& d) {
  if (Status s = validate_choices(d); !s) return s;
  if (Status s = validate_lengths(d); !s) return s;
  if (Status s = bounded_vector("gravity", d.gravity, "m/s^2"); !s) return s;
  if (Status s = validate_sound(d); !s) return s;
  if (Status s = within("artificial_viscosity", d.artificial_viscosity, 0, 1, "", "0.01..0.1 is usual"); !s)
    return s;
  if (d.particle_shifting && !d.tension)
    return invalid(
        "particle_shifting: needs tension, since it is for liquid that fills its domain and stirs a ",
        "free surface; set tension, or leave particle_shifting off");
  if (Status s = validate_steps(d); !s) return s;
  if (Status s = validate_counts(d); !s) return s;
  if (Status s = validate_diffusion(d); !s) return s;
  if (Status s = validate(d.heat.free_surface, d.heat.model, "heat.free_surface."); !s) return s;
  if (Status s = validate_domain(d.domain, support_of(d)); !s) return s;
  for (std::size_t f = 0; f < 6; ++f)
    if (Status s = validate_face(d, f); !s) return s;
  return {};
}

Status validate(const MaterialDesc& m) {
  const std::string p = "material \"" + m.name + "\": ";
  if (m.name.empty()) return invalid("material: name is empty; give it one, errors refer to it");
  if (Status s = validate_constants(m, p); !s) return s;
  if (Status s = validate_tables(m, p); !s) return s;
  if (Status s = validate_flow(m, p); !s) return s;
  if (m.melts_into && !(m.viscosity_points.empty() && m.density_points.empty()))
    return invalid(p, m.viscosity_points.empty() ? "density_points" : "viscosity_points",
                   ": a solid's lattice neither flows nor expands; give them to the liquid it melts into");
  if (Status s = validate_melting(m, p); !s) return s;
  if (Status s = validate_species(m, p); !s) return s;
  if (Status s = validate_lattice(m, p); !s) return s;
  return validate_surface(m, p);
}

Status validate_state(const char* what, double temperature, Vec3d velocity) {
  if (Status s = validate_celsius(std::string(what) + "temperature", temperature); !s) return s;
  return bounded_vector(std::string(what) + "velocity", velocity, "m/s");
}

physics::SurfaceCondition<double> condition_of(const SurfaceHeatDesc& s) {
  physics::SurfaceCondition<double> c;
  c.temperature = s.temperature ? *s.temperature : s.ambient;
  c.flux = s.flux;
  c.convection = s.convection;
  c.emissivity = s.emissivity;
  if (s.temperature) c.kind = physics::SurfaceHeat::held;
  else if (s.flux != 0 || !s.flux_points.empty() || s.convection > 0 || s.emissivity > 0)
    c.kind = physics::SurfaceHeat::exchange;
  return c;
}

bool is_timed(const SurfaceHeatDesc& s) { return !s.temperature_points.empty() || !s.flux_points.empty(); }

physics::SurfaceCondition<double> condition_at(const SurfaceHeatDesc& s, double time) {
  const auto at = [time](const std::vector<TimedValue>& values, double otherwise) {
    return values.empty() ? otherwise
                          : physics::value_at(values.data(), static_cast<std::uint32_t>(values.size()), time);
  };
  physics::SurfaceCondition<double> c = condition_of(s);
  c.temperature = at(s.temperature_points, c.temperature);
  c.flux = at(s.flux_points, c.flux);
  return c;
}

namespace {
Status validate_timed(const std::vector<TimedValue>& values, const std::string& what) {
  constexpr std::size_t most = 1u << 16;
  if (values.size() > most) return invalid(what, "at most ", most, " points, got ", values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k].time) || !std::isfinite(values[k].value))
      return invalid(what, "point ", k, ", ", values[k].value, " at ", values[k].time, " s, must be finite");
    if (k > 0 && !(values[k].time > values[k - 1].time))
      return invalid(what, "point ", k, " is at ", values[k].time, " s, not after the one before it, at ",
                     values[k - 1].time, " s; times must ascend");
  }
  return {};
}
}  // namespace

Status validate(const SurfaceHeatDesc& s, HeatModel model, const std::string& what) {
  if (Status st = validate_timed(s.temperature_points, what + "temperature_points: "); !st) return st;
  if (Status st = validate_timed(s.flux_points, what + "flux_points: "); !st) return st;
  for (const TimedValue& p : s.temperature_points)
    if (Status st = validate_celsius(what + "temperature_points", p.value); !st) return st;
  for (const TimedValue& p : s.flux_points)
    if (Status st = summable(what + "flux_points", p.value, "W/m^2"); !st) return st;
  if (s.temperature && !s.flux_points.empty())
    return invalid(what, "flux_points: a held surface takes no flux; drop temperature or them");
  const auto kind = condition_of(s).kind;
  if (!std::isfinite(s.flux))
    return invalid(what, "flux: must be finite W/m^2, got ", s.flux, "; positive heats, 0 is none");
  if (Status st = summable(what + "flux", s.flux, "W/m^2"); !st) return st;
  if (Status st = at_least(what + "convection", s.convection, 0, "W/(m^2 K)", "5..25 is still air"); !st)
    return st;
  if (!(s.emissivity >= 0 && s.emissivity <= 1))
    return invalid(what, "emissivity: must be in 0..1, got ", s.emissivity, "; 1 is a black body");
  for (const double t : {s.ambient, s.temperature.value_or(s.ambient)})
    if (Status st = validate_celsius(what + (s.temperature ? "temperature" : "ambient"), t); !st) return st;
  if (s.temperature && (s.flux != 0 || s.convection != 0 || s.emissivity != 0))
    return invalid(what, "temperature: a held surface (", *s.temperature,
                   " degrees) takes neither flux nor convection nor emissivity; drop one of them");
  if (kind != physics::SurfaceHeat::insulated && model != HeatModel::enthalpy)
    return invalid(
        what,
        "temperature, flux, convection and emissivity need heat.model enthalpy; the others know no "
        "heat, only temperatures of pairs");
  return {};
}

namespace {
Status validate_path(const std::string& p, const std::vector<PathPoint>& path) {
  constexpr std::size_t most = 1u << 20;
  if (path.size() > most)
    return invalid(p, "path: at most ", most, " points, got ", path.size(),
                   "; move the region with move_heat_region instead");
  for (std::size_t k = 0; k < path.size(); ++k) {
    const PathPoint& point = path[k];
    if (!std::isfinite(point.time) || !(length(point.displacement) <= farthest_move))
      return invalid(p, "path: point ", k, ", ", point.displacement, " m at ", point.time,
                     " s, must be finite, and at most ", farthest_move, " m away");
    if (k > 0 && !(point.time > path[k - 1].time))
      return invalid(p, "path: point ", k, " is at ", point.time, " s, not after the one before it, at ",
                     path[k - 1].time, " s; times must ascend");
  }
  return {};
}
}  // namespace

Status validate(const HeatRegionDesc& r, HeatModel model) {
  const std::string p = "heat region \"" + r.name + "\": ";
  if (!std::isfinite(r.source))
    return invalid(p, "source: must be finite W/m^3, got ", r.source, "; negative cools");
  if (Status st = summable(p + "source", r.source, "W/m^3"); !st) return st;
  if (r.temperature)
    if (Status st = validate_celsius(p + "temperature", *r.temperature); !st) return st;
  if (r.temperature && r.source != 0)
    return invalid(p, "source: what is held at ", *r.temperature, " degrees takes no source, got ", r.source,
                   "; drop one of them");
  if (!r.temperature && r.source == 0)
    return invalid(p, "source: is 0 and no temperature is given, so it does nothing; set one of them");
  if (Status st = validate_times(p, r.from, r.until); !st) return st;
  if (Status st = validate_path(p, r.path); !st) return st;
  if (model != HeatModel::enthalpy) return invalid(p, "regions need heat.model enthalpy");
  return {};
}

namespace {
Status validate_hydrostatic(const std::string& p, const ForceFieldDesc& f) {
  if (f.kind != ForceFieldKind::hydrostatic) return {};
  if (Status s = within(p + "density", f.density, 1e-3, 1e6, "kg/m^3",
                        "that of the liquid below the level, 1000 of water");
      !s)
    return s;
  if (!f.center && !f.shape)
    return invalid(p,
                   "center: is not given; a hydrostatic field takes a point of its level, below which all "
                   "stays full of liquid");
  if (f.liquid && f.bodies) return {};
  return invalid(p, f.liquid ? "bodies" : "liquid",
                 ": is false; a hydrostatic field acts on all that is below its level, or what floats would "
                 "not");
}
}  // namespace

Status validate(const ForceFieldDesc& f) {
  const std::string p = "force field \"" + f.name + "\": ";
  if (f.kind > ForceFieldKind::hydrostatic)
    return invalid(p, "kind: there is no kind ", static_cast<std::uint32_t>(f.kind),
                   "; use uniform, radial, vortex, drag or hydrostatic");
  const std::pair<const char*, Vec3d> vectors[] = {{"acceleration", f.acceleration},
                                                   {"center", f.center.value_or(Vec3d{})},
                                                   {"axis", f.axis},
                                                   {"velocity", f.velocity},
                                                   {"angular_velocity", f.angular_velocity}};
  const char* units[] = {"m/s^2", "m", "", "m/s", "rad/s"};
  for (std::size_t k = 0; k < 5; ++k)
    if (Status s = bounded_vector(p + vectors[k].first, vectors[k].second, units[k]); !s) return s;
  const bool falls_off = f.kind == ForceFieldKind::radial || f.kind == ForceFieldKind::vortex;
  if (f.kind == ForceFieldKind::vortex && !(length(f.axis) > 1e-15))
    return invalid(p, "axis: must have a length, got ", f.axis, "; {0, 1, 0} is upright");
  if (!(std::fabs(f.strength) <= 1e15))
    return invalid(p, "strength: must be finite m/s^2, at most 1e15, got ", f.strength,
                   "; negative attracts, or turns the other way");
  if (!(f.radius >= 0 && f.radius <= 1e15))
    return invalid(p, "radius: must be finite and >= 0 m, got ", f.radius,
                   "; 0 is the same acceleration at every distance");
  if (falls_off && (f.power < -2 || f.power > 1))
    return invalid(p, "power: must be 1, 0, -1 or -2, got ", f.power, "; 0 does not fall off, -2 is gravity");
  if (falls_off && f.power != 0 && !(f.radius > 1e-15))
    return invalid(p, "radius: must be > 0 m where power is ", f.power, ", got ", f.radius,
                   "; it is the distance at which the acceleration is `strength`");
  if (Status s = at_least(p + "rate", f.rate, 0, "1/s", "1/rate is the time in which a difference decays");
      !s)
    return s;
  if (Status s = measurable(p + "rate", f.rate, "1/s"); !s) return s;
  if (Status s = validate_hydrostatic(p, f); !s) return s;
  if (!f.liquid && !f.bodies)
    return invalid(p, "liquid: is false and so is bodies: it acts on nothing; set one of them");
  if (Status st = validate_times(p, f.from, f.until); !st) return st;
  return {};
}

double height_above_floor(const WorldDesc& d, double height) {
  const std::size_t down = axis_of(d.gravity);
  const bool up = component(d.gravity, down) < 0;
  return height - (up ? component(d.domain.min, down) : -component(d.domain.max, down));
}

double outlet_head(const WorldDesc& d, std::size_t face) {
  if (!d.domain.outlets[face].level || axis_of(d.gravity) == 3) return 0;
  return height_above_floor(d, *d.domain.outlets[face].level);
}

int face_behind(Vec3d axis) {
  const std::size_t a = axis_of(axis);
  return a == 3 ? -1 : static_cast<int>(2 * a) + (component(axis, a) > 0 ? 0 : 1);
}

Status validate_level(const std::string& p, double level, const WorldDesc& d) {
  if (!std::isfinite(level))
    return invalid(p, "level: must be finite, got ", level,
                   " m; it is measured against gravity from the origin");
  const double head = height_above_floor(d, level);
  if (head >= 2 * d.spacing) return {};
  return invalid(p, "level: must be at least two spacings (", 2 * d.spacing, " m) above the floor, got ",
                 level, " m, ", head,
                 " m above it; raise it, or turn the emitter off (set_emitter) to let nothing in");
}

/// What a level leaves to say of an emitter.
Status validate_reservoir_fields(const EmitterDesc& e, const std::string& p) {
  const EmitterDesc plain;
  if (e.radius != 0 || e.width != 0)
    return invalid(p, e.radius != 0 ? "radius" : "width", ": got ", e.radius != 0 ? e.radius : e.width,
                   " m beside a level, whose opening is a face of the domain; leave it out");
  if (length(e.center) != 0)
    return invalid(p, "center: got ", e.center, " beside a level; the axis says which face; leave it out");
  if (e.speed != plain.speed)
    return invalid(p, "speed: got ", e.speed, " m/s beside a level, from which it follows; leave it out");
  if (e.recycle)
    return invalid(
        p, "recycle: is for nozzles; what leaves an emitter with a level comes again anyway; leave it out");
  if (e.from != 0 || std::isfinite(e.until))
    return invalid(p, e.from != 0 ? "from" : "until", ": got ", e.from != 0 ? e.from : e.until,
                   " s beside a level, which is there all the time; leave it out, or turn the emitter on and "
                   "off (set_emitter)");
  return validate_state(p.c_str(), e.temperature, Vec3d{});
}

Status validate_reservoir(const EmitterDesc& e, const WorldDesc& d) {
  const std::string p = "emitter \"" + e.name + "\": ";
  if (Status s = validate_reservoir_fields(e, p); !s) return s;
  const int face = face_behind(e.axis);
  if (!finite(e.axis) || face < 0)
    return invalid(p, "axis: must lie along x, y or z, inwards from an open face, got ", e.axis,
                   "; 1, 0, 0 is for the face -x");
  const auto f = static_cast<std::size_t>(face);
  if (!d.domain.bounded || d.domain.faces[f] != Face::open)
    return invalid(p, "level: liquid comes in through open faces only, and ", face_names[f],
                   !d.domain.bounded                     ? " of a domain without bounds is none"
                   : d.domain.faces[f] == Face::periodic ? " is periodic"
                                                         : " is a wall",
                   "; make that face open");
  if (d.domain.outlets[f].level || d.domain.outlets[f].speed)
    return invalid(p, "level: that face has an outlet (domain.outlets) already; drop that one");
  const std::size_t down = axis_of(d.gravity);
  if (down == 3 || down == f / 2)
    return invalid(p, "level: needs gravity along an axis of the domain that lies in the face, got ",
                   d.gravity, "; set gravity so");
  if (d.domain.faces[2 * down + (component(d.gravity, down) > 0 ? 1 : 0)] != Face::wall)
    return invalid(p, "level: needs a wall below as its floor; make that face a wall");
  if (Status s = validate_level(p, *e.level, d); !s) return s;
  const Vec3d size = d.domain.max - d.domain.min;
  const double head = height_above_floor(d, *e.level), room = component(size, down);
  if (!(e.height == 0 || (e.height >= head * (1 - 1e-9) && std::isfinite(e.height))) ||
      std::max(head, e.height) > room * (1 + 1e-9))
    return invalid(p, e.height == 0 ? "level" : "height", ": the opening must reach the level, ", head,
                   " m above the floor, and end within the domain, ", room, " m high, got ",
                   e.height == 0 ? head : e.height, " m; lower one or make the domain higher");
  if (component(size, f / 2) < 4 * support_of(d))
    return invalid(p, "level: the domain must reach four support radii (", 4 * support_of(d),
                   " m) from that face, got ", component(size, f / 2), " m; make it longer");
  return {};
}

Status validate(const EmitterDesc& e, double spacing) {
  const std::string p = "emitter \"" + e.name + "\": ";
  if (Status s = finite_vector(p + "center", e.center); !s) return s;
  if (!finite(e.axis) || (e.axis.x == 0 && e.axis.y == 0 && e.axis.z == 0))
    return invalid(p, "axis: must be a finite vector that is not zero, got ", e.axis,
                   "; it need not be normalised");
  if (is_rectangle(e)) {
    for (const auto& [name, side] : {std::pair{"width", e.width}, std::pair{"height", e.height}})
      if (!(std::isfinite(side) && side >= 2 * spacing))
        return invalid(p, name, ": must be at least two spacings (", 2 * spacing, " m), got ", side,
                       "; a rectangle has both sides");
    if (e.radius != 0)
      return invalid(p, "radius: an opening is a disc or a rectangle, got a radius of ", e.radius,
                     " m beside a width; drop one of them");
    if (!finite(e.up) || !(length(cross(unit(e.axis), e.up)) > 1e-6 * length(e.up)))
      return invalid(p, "up: must be a finite vector that is not along the axis ", e.axis, ", got ", e.up,
                     "; it says which way the height lies");
  } else if (!(std::isfinite(e.radius) && e.radius >= spacing))
    return invalid(p, "radius: must be at least one spacing (", spacing, " m), got ", e.radius,
                   "; widen the nozzle");
  if (Status s = positive_speed(p + "speed", e.speed, "a nozzle at rest emits nothing"); !s) return s;
  if (Status st = validate_times(p, e.from, e.until); !st) return st;
  if (!std::isfinite(e.until) && e.max_particles == 0 && !e.recycle)
    return invalid(
        p,
        "max_particles: an emitter that never stops needs a limit, got 0; set max_particles or until, or "
        "recycle");
  return validate_state((p).c_str(), e.temperature, Vec3d{});
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
