// SPDX-License-Identifier: Apache-2.0
#include "check_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "failure.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

constexpr double zero_celsius = 273.15;  // K
// So far above where it melts or boils nothing of a scene is meant to be.
constexpr double far_above = 100;
// kg/m^3: light foams and osmium; below them lies what most substances have in g/cm^3, water with 1 among them.
constexpr double least_density = 10, most_density = 25000;
constexpr double most_frames = 1e7;
constexpr double most_rounding = 0.01;  // of places in files, in spacings
// Heavy metals have 116 J/(kg K) and more, mercury melts with 1.2e4 J/kg: what lies far below was meant in kJ.
constexpr double least_capacity = 20, least_latent_heat = 1500;
// kg/m^3, Pa: what is as dense and solid has 1e9 and more, and less where one makes it softer for longer steps; in MPa 5e5 at most.
constexpr double least_of_metals = 2500, most_in_megapascals = 1e6;
constexpr double most_tension = 5;  // N/m; liquid rhenium has 2.7
// What changes no temperature of a solution in water by a tenth of a degree nobody gives: in kJ/kg sugar has 16, salt 66.
constexpr double least_heat_of_solution = 400;
// Below three times the largest speed the density of the liquid varies by more than a tenth.
constexpr double least_mach = 3;
// A mesh in millimetres is a thousand times too large; one of that many domains is no obstacle anybody meant.
constexpr double far_too_large = 30;

std::string where_of(const Source& source, const std::string& key) {
  const auto found = source.keys.find(key);
  return found == source.keys.end() ? source.where : found->second;
}

double largest(const meltsim::Vec3d& size) { return std::max({size.x, size.y, size.z}); }

class Units {
 public:
  Units(const Node& root, Scene& scene) : root_(root), scene_(scene) {}

  void check() {
    check_domain();
    for (const SceneMaterial& material : scene_.materials) check_material(material);
    for (const SceneFluid& fluid : scene_.fluids) {
      check_size(fluid.shape, fluid.source);
      check_temperature(fluid.material, fluid.desc.temperature, fluid.source);
    }
    for (const SceneBody& body : scene_.bodies) {
      check_size(body.shape, body.source);
      check_temperature(body.material, body.desc.temperature, body.source);
      if (body.density) check_density(*body.density, body.source);
    }
    for (const SceneEmitter& emitter : scene_.emitters)
      check_temperature(emitter.material, emitter.desc.temperature, emitter.source);
    check_surroundings();
    check_whole_kelvin();
    check_tables();
    check_starts();
    check_filling();
    // Of another shape than a mesh, a region may be as large as one likes: it heats what there is.
    for (const SceneHeatRegion& region : scene_.heat_regions)
      if (region.shape.mesh) check_size(region.shape, region.source);
    for (const SceneForceField& field : scene_.force_fields) check_force(field);
    check_probes();
    check_sound_speed();
    check_distance();
    check_frames(scene_);
  }

 private:
  void warn(const Source& source, const std::string& key, const std::string& text) {
    scene_.warnings.push_back(fmt::format("{}: {}.{}: {}", where_of(source, key), source.path, key, text));
  }

  /// First of all: outside a domain turned inside out there is everything, which is no fault of what is in it.
  void check_domain() {
    const meltsim::DomainDesc& domain = scene_.world.domain;
    if (!domain.bounded) return;
    const meltsim::Vec3d size = domain.max - domain.min;
    const double extents[] = {size.x, size.y, size.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (extents[axis] > 0) continue;
      throw Failure(
          ExitCode::scene,
          fmt::format("{}: domain.max: must be above domain.min along {}, got extent {:g} m; swap or "
                      "enlarge the corners",
                      where_of(scene_.domain, "max"), "xyz"[axis], extents[axis]));
    }
    const auto moves = [](const meltsim::Vec3d& v) { return length(v) > 0; };
    if (!domain.no_slip && std::any_of(domain.velocity.begin(), domain.velocity.end(), moves))
      warn(scene_.domain, "velocity",
           "liquid does not stick to walls, no_slip is false: that they move does nothing");
  }

  void check_density(double density, const Source& source) {
    if (density >= least_density && density <= most_density) return;
    warn(source, "density",
         fmt::format("{:g} kg/m^3 is no density of a liquid or solid ({:g} to {:g}); 1 g/cm^3 is 1000",
                     density, least_density, most_density));
  }

  void check_material(const SceneMaterial& material) {
    check_density(material.desc.density, material.source);
    check_kilojoules(material.desc.heat_capacity, least_capacity, "heat_capacity", "J/(kg K)",
                     material.source);
    check_kilojoules(material.desc.latent_heat, least_latent_heat, "latent_heat", "J/kg", material.source);
    check_solution(material);
    if (material.desc.surface_tension > most_tension)
      warn(material.source, "surface_tension",
           fmt::format("{:g} N/m is more than any liquid has; mN/m? Then write {:g}",
                       material.desc.surface_tension, material.desc.surface_tension / 1000));
    if (const double modulus = material.desc.youngs_modulus;
        material.desc.density >= least_of_metals && modulus > 0 && modulus < most_in_megapascals)
      warn(material.source, "youngs_modulus",
           fmt::format("{:g} Pa is that of jelly, at {:g} kg/m^3; MPa? Then write {:g}", modulus,
                       material.desc.density, modulus * 1e6));
    const double melts = material.desc.melting_point;
    if (std::abs(melts - zero_celsius) < 0.2 || is_converted(melts)) {
      warn(material.source, "melting_point",
           fmt::format("{:g} degrees Celsius; Kelvin? Then write {:.4g}", melts, melts - zero_celsius));
    }
    if (std::isfinite(melts) && material.desc.latent_heat == 0 &&
        material.source.keys.count("latent_heat") == 0)
      warn(material.source, "melting_point",
           "melting takes no heat: there is no latent_heat [J/kg]; ice has 3.34e5, paraffin 2e5, aluminium "
           "4e5; write "
           "latent_heat: 0 where that is meant");
    if (material.desc.latent_heat > 0 && !std::isfinite(melts)) {
      warn(material.source, "latent_heat",
           "is of no use: it is of melting, and the material has no melting_point; give it one and "
           "`becomes`, or give latent_heat to the solid that becomes it");
    }
  }

  /// The heat of solution of a species, and a heat capacity that it does not have.
  void check_solution(const SceneMaterial& species) {
    if (species.dissolves_in.empty()) return;
    const double heat = species.desc.heat_of_solution;
    if (heat != 0 && std::abs(heat) < least_heat_of_solution)
      warn(species.source, "heat_of_solution",
           fmt::format("{:g} J/kg changes next to nothing; kilojoules? Then write {:g}", heat, 1000 * heat));
    const double own = species.desc.heat_capacity, solvent = material(species.dissolves_in).heat_capacity;
    if (species.source.keys.count("heat_capacity") > 0 && std::abs(own - solvent) > 1e-3 * solvent)
      warn(species.source, "heat_capacity",
           fmt::format(
               "{:g} J/(kg K) is not used: as a body and dissolved it has {:g}, the heat capacity of \"{}\"",
               own, solvent, species.dissolves_in));
  }

  /// 253.15, 1373.15: whole degrees Celsius that were converted to Kelvin.
  static bool is_converted(double temperature) {
    const double celsius = temperature - zero_celsius;
    return temperature > 200 && std::isfinite(celsius) && std::abs(celsius - std::round(celsius)) < 1e-3;
  }

  void check_kilojoules(double value, double least, const char* key, const char* unit, const Source& source) {
    if (!(value > 0) || value >= least) return;
    warn(source, key,
         fmt::format("{:g} {} is less than any material has; kilojoules? Then write {:g}", value, unit,
                     1000 * value));
  }

  const meltsim::MaterialDesc& material(const std::string& name) const {
    const auto found = std::find_if(scene_.materials.begin(), scene_.materials.end(),
                                    [&](const SceneMaterial& m) { return m.desc.name == name; });
    return found->desc;
  }

  /// Where a solid melts and water boils.
  static double limit_of(const meltsim::MaterialDesc& desc) {
    const bool watery =
        desc.density > 900 && desc.density < 1100 && desc.heat_capacity > 4000 && desc.heat_capacity < 4400;
    return std::isfinite(desc.melting_point) ? desc.melting_point : watery ? 100 : meltsim::infinity;
  }

  /// Water far above its boiling point, or a solid far above its melting point, that would be neither in Kelvin.
  void check_temperature(const std::string& name, double temperature, const Source& source) {
    const double limit = limit_of(material(name));
    const double celsius = temperature - zero_celsius;
    if ((temperature < limit + far_above || celsius > limit) && !is_converted(temperature)) return;
    warn(source, "temperature",
         fmt::format("{} at {:g} degrees Celsius; Kelvin? Then write {:.4g}", name, temperature, celsius));
  }

  /// What lies around a scene is far above all that melts or boils in it, as hot as nothing else, and would not be in Kelvin. Heaters have
  /// such temperatures too, but as multiples of 5 degrees, which Kelvin of everyday temperatures (253, 273, 293) are not.
  void check_surroundings() {
    double limit = -meltsim::infinity, hottest = -meltsim::infinity;
    for (const SceneMaterial& m : scene_.materials)
      if (std::isfinite(limit_of(m.desc))) limit = std::max(limit, limit_of(m.desc));
    for (const SceneFluid& fluid : scene_.fluids) hottest = std::max(hottest, fluid.desc.temperature);
    for (const SceneBody& body : scene_.bodies) hottest = std::max(hottest, body.desc.temperature);
    for (const SceneEmitter& e : scene_.emitters) hottest = std::max(hottest, e.desc.temperature);
    for (const Node& place : surroundings())
      for (const char* key : {"temperature", "ambient"})
        if (const auto given = place.find(key))
          for (const Node& value : values_of(*given)) check_surrounding(value, limit, hottest);
  }

  /// A number, or those of points in time.
  static std::vector<Node> values_of(const Node& given) {
    if (!given.is_list()) return {given};
    std::vector<Node> all;
    for (const Node& point : given.items("points")) all.push_back(point.items("a point").at(1));
    return all;
  }

  void check_surrounding(const Node& given, double limit, double hottest) {
    const double temperature = given.number("degrees Celsius"), celsius = temperature - zero_celsius;
    const bool heater = std::abs(std::remainder(temperature, 5)) < 1e-9;
    const bool far = std::isfinite(limit) && temperature >= limit + far_above && celsius <= limit;
    if (!(far && !heater && temperature > hottest + far_above) && !is_converted(temperature)) return;
    scene_.warnings.push_back(fmt::format("{}: {}: {:g} degrees Celsius; Kelvin? Then write {:.4g}",
                                          given.where(), given.path(), temperature, celsius));
  }

  /// All that a scene names, but for points of tables.
  std::vector<double> temperatures() const {
    std::vector<double> all;
    for (const SceneMaterial& m : scene_.materials)
      if (std::isfinite(m.desc.melting_point)) all.push_back(m.desc.melting_point);
    for (const SceneFluid& fluid : scene_.fluids) all.push_back(fluid.desc.temperature);
    for (const SceneBody& body : scene_.bodies) all.push_back(body.desc.temperature);
    for (const SceneEmitter& e : scene_.emitters) all.push_back(e.desc.temperature);
    for (const Node& place : surroundings())
      for (const char* key : {"temperature", "ambient"})
        if (const auto given = place.find(key))
          for (const Node& value : values_of(*given)) all.push_back(value.number("degrees Celsius"));
    return all;
  }

  /// Scenes of a cold world that is all warm: nothing is below a temperature that only Kelvin has for the coldest thing of a scene.
  void check_whole_kelvin() {
    const std::vector<double> all = temperatures();
    if (all.empty() || std::any_of(all.begin(), all.end(), is_converted)) return;
    const double coldest = *std::min_element(all.begin(), all.end());
    const auto is_round = [](double t) { return std::abs(std::remainder(t, 10)) < 1e-9; };
    // Room temperature and that of ice: 253 to 313. A preheated part is at 250 or 300 degrees, beside others that are as round.
    if (coldest < 250 || coldest > 315 ||
        (is_round(coldest) && std::all_of(all.begin(), all.end(), is_round)))
      return;
    scene_.warnings.push_back(
        fmt::format("{}: nothing is colder than {:g} degrees Celsius; Kelvin? Temperatures are in degrees "
                    "Celsius: {:g} K are {:.4g}",
                    scene_.file, coldest, coldest, coldest - zero_celsius));
  }

  /// Tables that begin above all temperatures of a scene, and would begin among them if they were in Kelvin.
  void check_tables() {
    const std::vector<double> all = temperatures();
    if (all.empty()) return;
    const auto [coldest, hottest] = std::minmax_element(all.begin(), all.end());
    for (const SceneMaterial& m : scene_.materials) {
      const std::pair<const char*, const std::vector<meltsim::PropertyPoint>*> tables[] = {
          {"viscosity", &m.desc.viscosity_points},         {"conductivity", &m.desc.conductivity_points},
          {"heat_capacity", &m.desc.heat_capacity_points}, {"density", &m.desc.density_points},
          {"yield_stress", &m.desc.yield_stress_points},   {"solubility", &m.desc.solubility_points}};
      for (const auto& [key, points] : tables) {
        if (points->size() < 2) continue;
        const double first = points->front().temperature, celsius = first - zero_celsius;
        if (!(first > *hottest) || celsius < *coldest || celsius > *hottest) continue;
        warn(m.source, key,
             fmt::format(
                 "its points begin at {:g} degrees Celsius, above all temperatures of the scene ({:g} to "
                 "{:g}), so that only the first one counts; Kelvin? Then write {:.4g} for {:g}",
                 first, *coldest, *hottest, celsius, first));
      }
    }
  }

  /// Walls, surfaces and heat regions.
  std::vector<Node> surroundings() const {
    std::vector<Node> all;
    const auto add = [&all](const std::optional<Node>& place) {
      if (place && place->is_mapping()) all.push_back(*place);
    };
    if (const auto heat = root_.find("heat")) {
      add(heat->find("free_surface"));
      if (const auto walls = heat->find("walls"))
        for (const auto& entry : walls->entries()) add(entry.second);
      if (const auto regions = heat->find("regions"))
        for (const Node& region : regions->items("regions")) add(region);
    }
    if (const auto bodies = root_.find("bodies"))
      for (const Node& body : bodies->items("bodies")) add(body.find("surface"));
    return all;
  }

  /// A solid that is liquid in the first frame, liquid that is to freeze in it.
  void check_starts() {
    const meltsim::HeatDesc& heat = scene_.world.heat;
    if (heat.model == meltsim::HeatModel::none || !(heat.time_scale > 0)) return;
    for (const SceneMaterial& m : scene_.materials) {
      if (m.becomes.empty() || !std::isfinite(m.desc.melting_point)) continue;
      for (const SceneBody& body : scene_.bodies)
        if (body.material == m.desc.name) check_solid(m, body);
      if (!m.desc.freezes) continue;
      for (const SceneFluid& fluid : scene_.fluids)
        if (fluid.material == m.becomes) check_liquid(m, fluid.desc.temperature, fluid.source);
      for (const SceneEmitter& emitter : scene_.emitters)
        if (emitter.material == m.becomes) check_liquid(m, emitter.desc.temperature, emitter.source);
    }
  }

  void check_solid(const SceneMaterial& m, const SceneBody& body) {
    const double starts = body.desc.temperature, melts = m.desc.melting_point + m.desc.melting_range;
    if (!(starts > melts) || starts - zero_celsius > melts - 100) return;  // Kelvin was said
    warn(body.source, "temperature",
         fmt::format("{} starts at {:g} C{}, above its melting point of {:g} C, and begins to melt at once; "
                     "give it a temperature of at most {:g}",
                     m.desc.name, starts, body.source.keys.count("temperature") > 0 ? "" : ", the default",
                     melts, melts));
  }

  void check_liquid(const SceneMaterial& m, double starts, const Source& source) {
    const double melts = m.desc.melting_point;
    if (!(starts < melts)) return;
    warn(source, "temperature",
         fmt::format(
             "{} starts at {:g} C, below the melting point of {}, {:g} C, and freezes at once where it "
             "touches it; give it a temperature of at least {:g}",
             m.becomes, starts, m.desc.name, melts, melts));
  }

  /// A field may be given for a run with --set, so that one that does nothing is let be.
  void check_force(const SceneForceField& field) {
    const meltsim::ForceFieldDesc& desc = field.desc;
    const std::string fix = ": the field moves nothing; give it a value, or remove the field";
    switch (desc.kind) {
      case meltsim::ForceFieldKind::uniform:
        if (length(desc.acceleration) == 0) warn(field.source, "acceleration", "is 0 m/s^2" + fix);
        break;
      case meltsim::ForceFieldKind::radial:
      case meltsim::ForceFieldKind::vortex:
        if (desc.strength == 0) warn(field.source, "strength", "is 0 m/s^2" + fix);
        break;
      case meltsim::ForceFieldKind::drag:
        if (desc.rate == 0) warn(field.source, "rate", "is 0 per second" + fix);
        break;
      case meltsim::ForceFieldKind::hydrostatic:  // without a density it is refused
        break;
    }
  }

  void check_size(const SceneShape& shape, const Source& source) {
    for (const std::string& text : shape.warnings) scene_.warnings.push_back(text);
    const meltsim::DomainDesc& domain = scene_.world.domain;
    if (!domain.bounded) return;
    const meltsim::Box box = shape.shape.bounds();
    const double size = largest(box.max - box.min), room = largest(domain.max - domain.min);
    if (size <= far_too_large * room) return;
    throw Failure(ExitCode::scene, fmt::format("{}: {}.shape: is {:.3g} m large, the domain {:.3g} m{}",
                                               where_of(source, "shape"), source.path, size, room,
                                               millimetre_hint(shape, size, room, scene_.world.spacing)));
  }

  /// Liquid between two walls is stretched or squeezed to fill what is between them, bodies are not.
  void check_filling() {
    const meltsim::DomainDesc& domain = scene_.world.domain;
    if (!domain.bounded) return;
    constexpr double uneven = 1e-3;  // [of a spacing] per cell: no more than rounding
    const double dx = scene_.world.spacing;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = part(domain.min, axis), high = part(domain.max, axis), cells = (high - low) / dx;
      const double whole = std::max(1.0, std::round(cells));
      if (std::fabs(cells / whole - 1) < uneven || !fills_beside_a_body(axis, low, high)) continue;
      warn(scene_.domain, "max",
           fmt::format(
               "{:g} m along {} are {:.4g} spacings of {:g} m: liquid from wall to wall is {} to fit, the "
               "bodies in it are not, and gaps between them close with a jolt at the start; use a "
               "spacing of {:.6g} m, or make it {:g} m",
               high - low, "xyz"[axis], cells, dx, cells > whole ? "stretched" : "squeezed",
               (high - low) / whole, whole * dx));
      return;
    }
  }
  static double part(const meltsim::Vec3d& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
  /// Whether a liquid reaches from one end to the other and there is a body in it.
  bool fills_beside_a_body(int axis, double low, double high) const {
    const double slack = 1e-3 * scene_.world.spacing;
    const auto meet = [](const meltsim::Box& a, const meltsim::Box& b) {
      return a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y &&
             a.min.z < b.max.z && b.min.z < a.max.z;
    };
    const auto inside = [&](const meltsim::Box& b) {
      return part(b.min, axis) > low + slack || part(b.max, axis) < high - slack;
    };
    return std::any_of(scene_.fluids.begin(), scene_.fluids.end(), [&](const SceneFluid& fluid) {
      const meltsim::Box liquid = fluid.desc.shape.bounds();
      return part(liquid.min, axis) <= low + slack && part(liquid.max, axis) >= high - slack &&
             std::any_of(scene_.bodies.begin(), scene_.bodies.end(), [&](const SceneBody& body) {
               const meltsim::Box box = body.desc.shape.bounds();
               return meet(liquid, box) && inside(box);
             });
    });
  }

  void check_probes() {
    const meltsim::DomainDesc& domain = scene_.world.domain;
    const auto probes = root_.find("probes");
    if (!domain.bounded || !probes) return;
    const std::vector<Node> items = probes->items("probes");
    for (std::size_t i = 0; i < items.size() && i < scene_.probes.size(); ++i) {
      if (!items[i].find("at")) continue;
      const meltsim::Vec3d at = scene_.probes[i].desc.points.front();
      const bool inside = at.x >= domain.min.x && at.y >= domain.min.y && at.z >= domain.min.z &&
                          at.x <= domain.max.x && at.y <= domain.max.y && at.z <= domain.max.z;
      if (inside) continue;
      items[i].find("at")->fail(
          fmt::format("[{:g}, {:g}, {:g}] is outside the domain, [{:g}, {:g}, {:g}] to [{:g}, {:g}, {:g}] m: "
                      "nothing is ever there",
                      at.x, at.y, at.z, domain.min.x, domain.min.y, domain.min.z, domain.max.x, domain.max.y,
                      domain.max.z));
    }
  }

  void check_sound_speed() {
    const double sound = scene_.world.sound_speed;
    if (sound <= 0 || (scene_.fluids.empty() && scene_.emitters.empty())) return;
    const double speed = speed_of(scene_, false);
    if (sound >= least_mach * speed) return;
    warn(scene_.solver, "sound_speed",
         fmt::format(
             "{:g} m/s, where things reach {:.3g} m/s by falling or from the start: the liquid would be "
             "squeezed; use ten times that speed, or auto",
             sound, speed));
  }

  /// Files of frames hold places in single precision, counted from the origin of the scene.
  void check_distance() {
    const meltsim::DomainDesc& domain = scene_.world.domain;
    const auto in_file = [](const std::string& format) { return format != "png" && format != "html"; };
    const std::vector<std::string>& formats = scene_.output.formats;
    if (!domain.bounded || !std::any_of(formats.begin(), formats.end(), in_file)) return;
    double far = 0;
    for (const meltsim::Vec3d& corner : {domain.min, domain.max})
      far = std::max({far, std::fabs(corner.x), std::fabs(corner.y), std::fabs(corner.z)});
    const float place = static_cast<float>(far);
    const double step = static_cast<double>(std::nextafter(place, std::numeric_limits<float>::infinity())) -
                        static_cast<double>(place);
    if (!(step > most_rounding * scene_.world.spacing) || !std::isfinite(step)) return;
    warn(
        scene_.domain, "max",
        fmt::format(
            "{:g} m from the origin files of frames hold places to {:.2g} m, {:.2g} spacings: move the scene "
            "near the origin, and the frames back where they are used",
            far, step, step / scene_.world.spacing));
  }

  const Node& root_;
  Scene& scene_;
};

}  // namespace

namespace {
/// As it starts, or on its path [m/s].
double fastest_of(const meltsim::SolidDesc& body) {
  double speed = length(body.velocity);
  for (std::size_t k = 1; k < body.path.size(); ++k)
    speed = std::max(speed, length(body.path[k].displacement - body.path[k - 1].displacement) /
                                (body.path[k].time - body.path[k - 1].time));
  return speed;
}
}  // namespace

double speed_of(const Scene& scene, bool to_floor) {
  const meltsim::Vec3d g = scene.world.gravity;
  const double pull = length(g);
  double speed = 0, top = -meltsim::infinity, bottom = meltsim::infinity;
  const auto heights = [&](const meltsim::Box& box, auto see) {
    if (!(pull > 0) || !(box.min.x <= box.max.x)) return;
    for (int corner = 0; corner < 8; ++corner)
      see(-dot({corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                corner & 4 ? box.max.z : box.min.z},
               g) /
          pull);
  };
  const auto see = [&](const meltsim::Box& box, double v) {
    speed = std::max(speed, v);
    heights(box, [&](double up) {
      top = std::max(top, up);
      bottom = std::min(bottom, up);
    });
  };
  for (const SceneFluid& fluid : scene.fluids) see(fluid.desc.shape.bounds(), length(fluid.desc.velocity));
  for (const SceneBody& body : scene.bodies) see(body.desc.shape.bounds(), fastest_of(body.desc));
  for (const SceneEmitter& emitter : scene.emitters) {
    const meltsim::EmitterDesc& e = emitter.desc;
    const meltsim::Vec3d at = e.level && pull > 0 ? g * (-*e.level / pull) : e.center;
    see({at, at}, e.level ? 0.0 : e.speed);
  }
  const meltsim::DomainDesc& domain = scene.world.domain;
  if (to_floor && domain.bounded)
    heights({domain.min, domain.max}, [&](double up) { bottom = std::min(bottom, up); });
  const double fall = std::max(0.0, top - bottom);
  return std::sqrt(speed * speed + (std::isfinite(fall) ? 2 * pull * fall : 0.0));
}

std::string millimetre_hint(const SceneShape& shape, double size, double room, double spacing) {
  if (size / 1000 > room || size / 1000 < 2 * spacing) return "";
  return fmt::format("; if {} in millimetres, add transform: {{scale: 0.001}} to the shape",
                     shape.mesh ? "the file is" : "its lengths are");
}

void check_frames(const Scene& scene) {
  const double frames = scene.time.end * scene.time.fps;
  if (frames <= most_frames) return;
  throw Failure(
      ExitCode::scene,
      fmt::format(
          "{}: time.end: {:g} s at {:g} frames per second are {:.3g} frames, at most {:g} are "
          "written; lower time.end or time.fps",
          where_of(scene.time_source, "end").empty() ? scene.where : where_of(scene.time_source, "end"),
          scene.time.end, scene.time.fps, frames, most_frames));
}

void check_units(const Node& root, Scene& scene) { Units(root, scene).check(); }

}  // namespace runner
