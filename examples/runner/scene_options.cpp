// SPDX-License-Identifier: Apache-2.0
#include "scene_options.hpp"

#include <fmt/format.h>

#include "echo.hpp"
#include "failure.hpp"
#include "load_heat.hpp"
#include "load_parts.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

using meltsim::DomainDesc;
using meltsim::SurfaceHeatDesc;

#define OF_WORLD(path) MEMBER(world.path)

/// Per face, without those for which `of` has nothing.
template <class Of>
Json per_face(const DomainDesc& domain, const Of& of) {
  Json json;
  for (std::size_t i = 0; i < 6; ++i)
    if (Json value = of(domain, i); !value.is_null()) json[keys::one_face.at(i)] = std::move(value);
  return json;
}

Json walls_json(const DomainDesc& domain) {
  if (!domain.bounded) return "none";
  Json json;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string& face = keys::one_face.at(i);
    if (domain.faces[i] == meltsim::Face::periodic) json[face.substr(1)] = "periodic";
    else json[face] = domain.faces[i] == meltsim::Face::open ? "open" : "wall";
  }
  return json;
}

Json outlet_json(const DomainDesc& domain, std::size_t face) {
  Json json = options_json(outlet_options(), domain.outlets[face]);
  return json.empty() ? Json() : json;
}

Json velocity_json(const DomainDesc& domain, std::size_t face) {
  return domain.bounded && length(domain.velocity[face]) > 0 ? echo(domain.velocity[face]) : Json();
}

/// A factor by which something runs faster than motion.
template <class Get>
Option<Scene> time_scale(const char* key, const char* field, const Get& get, const char* otherwise,
                         const char* doc) {
  Option<Scene> option = number<Scene>(key, field, get, "a factor", at_least(0), otherwise, doc);
  option.load = [get](const Node& value, Scene& scene) {
    constexpr double most = 1e12;  // weeks of melting in a second are 1e6
    const double scale = value.number("a factor");
    if (scale < 0 || scale > most)
      value.fail(fmt::format("expected a factor from 0 to {:g}, got {}", most, value.found()));
    get(scene) = scale;
  };
  return option;
}

/// A number of the runner's own, which nothing else refuses below 0.
template <class Get>
Option<Scene> not_negative(const char* key, const Get& get, const char* otherwise, const char* doc) {
  Option<Scene> option = number<Scene>(key, "", get, "s", at_least(0), otherwise, doc);
  option.load = [get](const Node& value, Scene& scene) {
    get(scene) = value.number("s");
    if (get(scene) < 0) value.fail(fmt::format("expected 0 or more (s), got {}", value.found()));
  };
  return option;
}

/// A number, or points of temperature.
template <class Points>
Option<SceneMaterial> property(const char* key, double meltsim::MaterialDesc::*constant, Points points,
                               const char* unit, const char* otherwise, const char* doc) {
  Option<SceneMaterial> option = custom<SceneMaterial>(
      key, key, otherwise, doc, nullptr,
      [=](const Node& value, SceneMaterial& m) {
        load_property(value, key, unit, m.desc.*constant, m.desc.*points);
      },
      [=](const SceneMaterial& m) -> Json {
        if ((m.desc.*points).empty()) return m.desc.*constant;
        Json list = Json::array();
        for (const auto& p : m.desc.*points) list.push_back({p.temperature, p.value});
        return list;
      });
  option.points = std::string(key) + "_points";
  return option;
}

/// The name of another material.
Option<SceneMaterial> name_of_material(const char* key, const char* field, std::string SceneMaterial::*name,
                                       const char* doc) {
  return custom<SceneMaterial>(
      key, field, "", doc, {{"type", "string"}},
      [name](const Node& value, SceneMaterial& m) { m.*name = value.text("the name of a material"); },
      [name](const SceneMaterial& m) { return (m.*name).empty() ? Json() : Json(m.*name); });
}

/// "never" reads better in a scene than an infinite temperature.
double melting_point(const Node& node) {
  return node.is_word("never") ? meltsim::infinity : node.number_or_infinite("degrees Celsius, or never");
}

std::array<double, 3> color_of(const Node& node) {
  const meltsim::Vec3d color = node.vector("red, green, blue: 0 to 1");
  for (const double c : {color.x, color.y, color.z}) {
    if (c < 0 || c > 1) node.fail(fmt::format("expected red, green and blue from 0 to 1, got {:g}", c));
  }
  return {color.x, color.y, color.z};
}

}  // namespace

Json surface_json(const SurfaceHeatDesc& surface) {
  const Json json = options_json(surface_heat_options(), surface);
  const Json nothing = options_json(surface_heat_options(), SurfaceHeatDesc{});
  if (surface.temperature) return {{"temperature", json.at("temperature")}};
  return json == nothing ? Json() : json;
}

const Options<Scene>& domain_options() {
  static const Options<Scene> options{
      custom<Scene>(
          "walls", "faces", "`box`",
          "`box`: walls all around. `open`: liquid that leaves is removed and counted; bodies are not, they "
          "go on beyond. `none`: no bounds at all "
          "(then no `min` and `max`). Or a mapping of faces: `{x: periodic, +y: open}` with the faces `-x +x "
          "-y +y -z +z`, or `x y z` for both; each `wall`, `open` or `periodic`; faces not named are walls",
          nullptr, [](const Node& value, Scene& s) { load_walls(value, s.world.domain); },
          [](const Scene& s) { return walls_json(s.world.domain); }),
      custom<Scene>(
          "min", "min", "", "lower corner [m]; not without walls", {{"$ref", "#/$defs/vector"}},
          [](const Node& value, Scene& s) {
            if (!s.world.domain.bounded) value.fail("walls: none has no bounds; remove this or the walls");
            s.world.domain.min = value.vector("m");
          },
          [](const Scene& s) { return s.world.domain.bounded ? echo(s.world.domain.min) : Json(); }),
      custom<Scene>(
          "max", "max", "", "upper corner [m]; not without walls", {{"$ref", "#/$defs/vector"}},
          [](const Node& value, Scene& s) {
            if (!s.world.domain.bounded) value.fail("walls: none has no bounds; remove this or the walls");
            s.world.domain.max = value.vector("m");
          },
          [](const Scene& s) { return s.world.domain.bounded ? echo(s.world.domain.max) : Json(); }),
      custom<Scene>(
          "outlets", "outlets", "",
          "mapping of open faces (as in `domain.walls`) to what is beyond: `{level: 0.2}`, liquid up to that "
          "height [m, against gravity], so that a channel keeps its depth and waves leave it; or `{speed: "
          "0.5}`, liquid near the face moves out at that speed [m/s]. None: liquid falls out freely. See "
          "[open channels](design/outlets.md)",
          nullptr, [](const Node& value, Scene& s) { load_outlets(value, s.world.domain); },
          [](const Scene& s) { return per_face(s.world.domain, outlet_json); }),
      flag<Scene>("no_slip", "", OF_WORLD(domain.no_slip), "true", "liquid sticks to walls"),
      number<Scene>("friction", "friction", OF_WORLD(domain.friction), "Coulomb coefficient", at_least(0),
                    "0.3", "Coulomb coefficient of bodies against walls"),
      number<Scene>("contact_angle", "contact_angle", OF_WORLD(domain.contact_angle), "degrees",
                    between(0, 180), "90",
                    "[degrees] of liquids with surface tension at walls, 0..180: 0 wets, 180 repels"),
      custom<Scene>(
          "velocity", "velocity", "", "mapping of faces to velocities [m/s]: moving lids, along the wall",
          nullptr, [](const Node& value, Scene& s) { load_face_velocities(value, s.world.domain); },
          [](const Scene& s) { return per_face(s.world.domain, velocity_json); })};
  return options;
}

const Options<Scene>& particles_options() {
  static const Options<Scene> options{
      number<Scene>("spacing", "spacing", OF_WORLD(spacing), "m", above_zero(), "",
                    "distance of particles [m]")
          .must_be_given("the distance of particles (m)"),
      number_or_auto<Scene>("support", "support_radius", OF_WORLD(support_radius), "m",
                            "support radius [m]; `auto` = 2.5 spacings")};
  return options;
}

const Options<Scene>& time_options() {
  static const Options<Scene> options{
      custom<Scene>(
          "dt", "", "`auto`", "step [s]",
          {{"oneOf", {{{"const", "auto"}}, {{"type", "number"}, {"exclusiveMinimum", 0}}}}},
          [](const Node& value, Scene& s) {
            if (!value.is_word("auto")) s.time.dt = value.positive("s, or auto");
            s.time.dt_where = value.where();
          },
          [](const Scene& s) { return s.time.dt ? Json(*s.time.dt) : Json("auto"); }),
      word<Scene>("stepping", "", MEMBER(time.adaptive), keys::stepping, "`fixed`", "`fixed` or `adaptive`"),
      not_negative("end", MEMBER(time.end), "10", "[s]"),
      custom<Scene>(
          "end_when", "", "`time`",
          "`melted`: stop when nothing that can melt is left; `end` is then the latest end",
          {{"enum", keys::end_when}},
          [](const Node& value, Scene& s) {
            s.time.until_melted = value.choice(keys::end_when) == "melted";
            s.time.end_when_where = value.where();
          },
          [](const Scene& s) -> Json { return keys::end_when.at(s.time.until_melted ? 1 : 0); }),
      not_negative("tail", MEMBER(time.tail), "0", "[s] simulated after everything has melted"),
      number<Scene>("fps", "", MEMBER(time.fps), "frames per simulated second", above_zero(), "25",
                    "frames per simulated second")};
  return options;
}

const Options<Scene>& solver_options() {
  static const Options<Scene> options{
      custom<Scene>(
          "gravity", "gravity", "[0, -9.81, 0]", "[m/s^2]; y is up", {{"$ref", "#/$defs/vector"}},
          [](const Node& value, Scene& s) { s.world.gravity = value.vector("m/s^2"); },
          [](const Scene& s) { return echo(s.world.gravity); }),
      number_or_auto<Scene>("sound_speed", "sound_speed", OF_WORLD(sound_speed), "m/s",
                            "[m/s]; `auto`: ten times the fastest motion gravity can cause in the scene"),
      custom<Scene>(
          "density_error", "density_error", "0.005",
          "instead of a sound speed: what the derived one lets liquid at rest be compressed by at its lowest "
          "place, 1e-5 to 0.1. Sub-steps grow with its root: 0.02 halves their number",
          typed("number", between(1e-5, 0.1)),
          [](const Node& value, Scene& s) {
            s.world.density_error = value.positive("compression");
            if (s.world.sound_speed > 0) value.fail("sound_speed decides; drop one of them");
          },
          [](const Scene& s) { return s.world.density_error > 0 ? Json(s.world.density_error) : Json(); }),
      custom<Scene>(
          "follow_sound_speed", "follow_sound_speed", "false",
          "the derived sound speed falls, down to a quarter, where a scene calms down, and is back before a "
          "splash comes; compression stays within `density_error`. Liquid at rest at a quarter of its height "
          "takes half the sub-steps. [Steps](design/steps.md#a-sound-speed-that-follows)",
          {{"type", "boolean"}},
          [](const Node& value, Scene& s) {
            s.world.follow_sound_speed = value.boolean();
            if (s.world.follow_sound_speed && s.world.sound_speed > 0)
              value.fail("sound_speed stays as it is; leave it out and set density_error, or drop this key");
          },
          [](const Scene& s) { return s.world.follow_sound_speed ? Json(true) : Json(); }),
      flag<Scene>("hydrostatic_start", "hydrostatic_start", OF_WORLD(hydrostatic_start), "true",
                  "liquid that stands on walls or bodies starts with the pressure of rest, so that a tank "
                  "does not ring for seconds after its start. "
                  "[Concepts](concepts.md#a-start-at-rest)"),
      custom<Scene>(
          "settle", "", "0",
          "seconds that liquid is given to come to rest before the run, with bodies held: forces on what it "
          "touches are those of rest from then on, where they swing for a second; `auto` follows from depth "
          "and sound. [Concepts](concepts.md#a-start-at-rest-beside-bodies)",
          {{"oneOf", {{{"const", "auto"}}, {{"type", "number"}, {"minimum", 0}}}}},
          [](const Node& value, Scene& s) {
            s.settle = {true, meltsim::automatic};
            if (value.is_word("auto")) return;
            s.settle.seconds = value.number("s, or auto");
            if (s.settle.seconds < 0) value.fail("expected auto, or seconds: 0 or more");
            s.settle.on = s.settle.seconds > 0;
          },
          [](const Scene& s) {
            if (!s.settle.on) return Json(0);
            return s.settle.seconds > 0 ? Json(s.settle.seconds) : Json("auto");
          }),
      number<Scene>("artificial_viscosity", "artificial_viscosity", OF_WORLD(artificial_viscosity),
                    "Monaghan's alpha", between(0, 1), "0.05", "Monaghan's alpha"),
      flag<Scene>("tension", "", OF_WORLD(tension), "false",
                  "liquid may pull (pressure below 0). For liquid that fills its domain; at a free surface "
                  "it makes clumps"),
      automatic_flag<Scene>(
          "isotropic_pressure", "isotropic_pressure", OF_WORLD(isotropic_pressure),
          "takes out of the pressure what the arrangement of the particles adds to it, which acts as a "
          "viscosity in proportion to the pressure: for slow flow below a surface (what sinks, drifts or "
          "convects). Needs `artificial_viscosity` of 0.01 or more. `auto`: `true` where there are "
          "bodies, or liquid meets liquid of another density, has a yield stress, surface tension or "
          "contents, or "
          "expands with heat, and is damped enough. "
          "[Isotropic pressure](design/pressure.md)"),
      flag<Scene>("particle_shifting", "particle_shifting", OF_WORLD(particle_shifting), "false",
                  "moves liquid's particles slightly towards where there are fewer. For flows that strain "
                  "for long (vortices, convection), which otherwise squeeze the particles into strings. "
                  "Needs `tension`: below a free surface it stirs the liquid"),
      word<Scene>("neighbour_search", "", OF_WORLD(neighbour_search), keys::neighbour_search, "`auto`",
                  "how neighbours are found, which changes results by rounding only: `grid` (what `auto` "
                  "takes) or `tree` (boxes over a space-filling curve); `verlet`, which older scenes may ask "
                  "for, means `grid`. `docs/performance.md` has their costs"),
      word<Scene>("viscosity", "viscosity", OF_WORLD(viscosity), keys::viscosity, "`auto`",
                  "how viscosity enters a sub-step: `explicit`, as a force, which limits sub-steps; "
                  "`implicit`, in stages, which does not; `auto`: in stages where the limit would be the "
                  "smallest one. [Concepts](concepts.md#implicit-viscosity)"),
      number<Scene>("courant", "courant", OF_WORLD(courant), "Courant number", above_zero({{"maximum", 0.6}}),
                    "0.4", "up to 0.6"),
      whole_number<Scene>("max_substeps", "max_substeps", OF_WORLD(max_substeps), at_least(1), "64",
                          "a step that needs more is refused"),
      whole_number<Scene>("pieces_interval", "pieces_interval", OF_WORLD(pieces_interval), at_least(1), "16",
                          "steps between searches for pieces that came apart"),
      word<Scene>(
          "stray", "", OF_WORLD(stray), keys::stray, "`remove`",
          "of liquid that falls out of a scene without walls until it is faster than sound: `remove` it and "
          "count it (a run warns, `strayed` in `run.json` is how many particles), or `halt` the run")};
  return options;
}

const Options<Scene>& heat_options() {
  static const Options<Scene> options{
      word<Scene>("model", "", OF_WORLD(heat.model), keys::heat_model, "`enthalpy`",
                  "`none`, `paper` (two reversed pair sweeps, not conservative), `iwasaki` (explicit, for "
                  "comparison: unstable at long steps, which is flagged) or `enthalpy` (conservative, with "
                  "latent heat)"),
      time_scale("time_scale", "heat.time_scale", OF_WORLD(heat.time_scale), "1",
                 "heat runs this many times faster than motion: a time lapse"),
      custom<Scene>(
          "interval", "heat.interval", "1",
          "most sub-steps of motion that share a step of heat, within a step; `auto`: up to four where two "
          "stages are enough for them ([what it brings](trade.md#multi-rate))",
          {{"oneOf", {{{"const", "auto"}}, {{"type", "integer"}, {"minimum", 1}, {"maximum", 1000}}}}},
          [](const Node& value, Scene& s) {
            s.world.heat.interval =
                value.is_word("auto") ? 0 : value.small_integer("a whole number, or auto");
          },
          [](const Scene& s) {
            return s.world.heat.interval > 0 ? Json(s.world.heat.interval) : Json("auto");
          }),
      whole_number<Scene>("max_stages", "heat.max_stages", OF_WORLD(heat.max_stages), between(2, 1024), "64",
                          "stages of the heat integrator per super-step"),
      whole_number<Scene>(
          "max_supersteps", "heat.max_supersteps", OF_WORLD(heat.max_supersteps), between(1, 1000000), "64",
          "super-steps of heat in a sub-step, 1 to 1,000,000: a step that needs more is refused; each sweeps "
          "`max_stages` times over all neighbours, and nothing interrupts a sub-step"),
      number<Scene>("level_tolerance", "heat.level_tolerance", OF_WORLD(heat.level_tolerance), "K",
                    at_least(0), "1e-4",
                    "K: temperatures that differ by no more are level; heat then stands still, its stages "
                    "and memory go, until something is added or a heat region begins. 0: never"),
      custom<Scene>(
          "free_surface", "heat.free_surface", "none",
          "heat through the liquid's free surface, with the keys of `surface`: a pool that the air cools "
          "(`{convection: 10, ambient: 20}`) or the sun warms (`{flux: 800}`). Only what no wall, body or "
          "other liquid covers. Its area is right to 2 % on a pool (`support` 2, and 2.3 to 3.5 spacings; 4 "
          "to 8 % too small at 1.7 to 2.2, 1.5 times at 1.5); that of balls of liquid is 10 % too small",
          nullptr, [](const Node& value, Scene& s) { s.world.heat.free_surface = load_surface(value); },
          [](const Scene& s) { return surface_json(s.world.heat.free_surface); }),
      custom<Scene>(
          "walls", "domain.heat", "",
          "mapping of faces (as in `domain.walls`) to what heat does there, e.g. `{-y: {temperature: 80}, x: "
          "{convection: 10, ambient: 20}}`; keys below. A wall that is not named insulates",
          nullptr, [](const Node& value, Scene& s) { load_wall_heat(value, s.world.domain); },
          [](const Scene& s) {
            return per_face(s.world.domain,
                            [](const DomainDesc& d, std::size_t i) { return surface_json(d.heat[i]); });
          }),
      custom<Scene>(
          "regions", "", "",
          "list of parts of space, keys below: what is inside is held at a temperature or heated",
          {{"type", "array"}, {"items", {{"$ref", "#/$defs/heat_region"}}}},
          [](const Node& value, Scene& s) { load_heat_regions(value, s); },
          [](const Scene& s) { return list_json(heat_region_options(), s.heat_regions); })};
  return options;
}

const Options<Scene>& solute_options() {
  static const Options<Scene> options{
      time_scale("time_scale", "solute.time_scale", OF_WORLD(solute.time_scale), "1",
                 "[species](design/species.md) diffuse and dissolve this many times faster than motion; 0 "
                 "stops them"),
      whole_number<Scene>("max_supersteps", "solute.max_supersteps", OF_WORLD(solute.max_supersteps),
                          between(1, 1000000), "64",
                          "most sweeps over all neighbours per species in a sub-step, 1 to 1,000,000: a step "
                          "that needs more is refused")};
  return options;
}

const std::vector<Section>& scene_sections() {
  static const std::vector<Section> sections{
      {"domain", domain_options, &Scene::domain},  {"particles", particles_options, &Scene::particles},
      {"time", time_options, &Scene::time_source}, {"solver", solver_options, &Scene::solver},
      {"heat", heat_options, &Scene::heat},        {"solute", solute_options, &Scene::solute},
      {"trade", trade_options, &Scene::wishes},    {"output", output_options, &Scene::wishes}};
  return sections;
}

const std::vector<SceneList>& scene_lists() {
  static const std::vector<SceneList> lists{
      {"fluids", load_fluids, [](const Scene& s) { return list_json(fluid_options(), s.fluids); }, false},
      {"bodies", load_bodies, [](const Scene& s) { return list_json(body_options(), s.bodies); }, true},
      {"emitters", load_emitters, [](const Scene& s) { return list_json(emitter_options(), s.emitters); },
       true},
      {"force_fields", load_force_fields,
       [](const Scene& s) { return list_json(force_field_options(), s.force_fields); }, true},
      {"probes", load_probes, [](const Scene& s) { return list_json(probe_options(), s.probes); }, true}};
  return lists;
}

keys::List scene_keys() {
  keys::List list{"meltsim", "title", "materials"};
  for (const Section& section : scene_sections()) list.push_back(section.name);
  for (const SceneList& of : scene_lists()) list.push_back(of.name);
  return list;
}

void refuse_key(const Node& value, const std::string& key, const std::string& kind, const keys::List& kinds) {
  value.fail(fmt::format("kind {} has no {}; leave {} out, or write kind: {}", kind, key,
                         key == "fields" ? "them" : "it", either_of(kinds)));
}

namespace {
/// A number or points in time.
Option<SurfaceHeatDesc> timed(
    const char* key, const char* unit, const Range& range, const char* otherwise, const char* doc,
    const std::function<void(SurfaceHeatDesc&, double, std::vector<meltsim::TimedValue>)>& set,
    const std::function<Json(const SurfaceHeatDesc&)>& get) {
  const Json point{{"type", "array"}, {"minItems", 2}, {"maxItems", 2}, {"items", {{"type", "number"}}}};
  return custom<SurfaceHeatDesc>(
      key, "", otherwise, doc,
      {{"anyOf", {typed("number", range), {{"type", "array"}, {"minItems", 1}, {"items", point}}}}},
      [=](const Node& value, SurfaceHeatDesc& d) {
        double first = 0;
        std::vector<meltsim::TimedValue> points;
        load_timed(value, unit, first, points);
        set(d, first, std::move(points));
      },
      get);
}
Json points_json(const std::vector<meltsim::TimedValue>& points) {
  Json list = Json::array();
  for (const meltsim::TimedValue& p : points) list.push_back({p.time, p.value});
  return list;
}
}  // namespace

const Options<SurfaceHeatDesc>& surface_heat_options() {
  using D = SurfaceHeatDesc;
  using Points = std::vector<meltsim::TimedValue>;
  static const Options<D> options{
      timed(
          "temperature", "degrees Celsius", at_least(meltsim::absolute_zero), "",
          "held at this [degrees Celsius]; excludes the others",
          [](D& d, double first, Points points) {
            d.temperature = first;
            d.temperature_points = std::move(points);
          },
          [](const D& d) {
            if (!d.temperature) return Json();
            return d.temperature_points.empty() ? Json(*d.temperature) : points_json(d.temperature_points);
          }),
      timed(
          "flux", "W/m^2", any_number(), "0", "[W/m^2] into the material",
          [](D& d, double first, Points points) {
            d.flux = points.empty() ? first : 0;
            d.flux_points = std::move(points);
          },
          [](const D& d) { return d.flux_points.empty() ? Json(d.flux) : points_json(d.flux_points); }),
      number<D>("convection", "", MEMBER(convection), "W/(m^2 K)", at_least(0), "0",
                "[W/(m^2 K)] towards `ambient`")
          .also_called({"heat_transfer_coefficient"}),
      number<D>("emissivity", "", MEMBER(emissivity), "0 to 1", between(0, 1), "0",
                "of radiation towards surroundings at `ambient`"),
      timed(
          "ambient", "degrees Celsius", at_least(meltsim::absolute_zero), "20", "[degrees Celsius]",
          [](D& d, double first, Points points) {
            d.ambient = first;
            if (!points.empty()) d.temperature_points = std::move(points);
          },
          [](const D& d) {
            return d.temperature || d.temperature_points.empty() ? Json(d.ambient)
                                                                 : points_json(d.temperature_points);
          })};
  return options;
}

const Options<SceneMaterial>& material_options() {
  using D = SceneMaterial;
  using M = meltsim::MaterialDesc;
  static const Options<D> options{
      property("density", &M::density, &M::density_points, "kg/m^3", "1000", "[kg/m^3]"),
      property("conductivity", &M::conductivity, &M::conductivity_points, "W/(m K)", "0.6",
               "[W/(m K)], above 0")
          .also_called({"thermal_conductivity"}),
      property("heat_capacity", &M::heat_capacity, &M::heat_capacity_points, "J/(kg K)", "4186",
               "[J/(kg K)]; a species has that of its solvent, as a body too")
          .also_called({"specific_heat", "specific_heat_capacity"}),
      maybe_number<D>("diffusivity", "diffusivity", MEMBER(desc.diffusivity), "m^2/s", at_least(0), "",
                      "[m^2/s]; replaces the conductivity; 0 insulates"),
      custom<D>(
          "K", "", "", "the paper's name of `diffusivity`", typed("number", at_least(0)),
          [](const Node& value, D& m) {
            if (m.desc.diffusivity) value.fail("K is another name of diffusivity; give one of the two");
            m.desc.diffusivity = value.number("m^2/s");
          },
          [](const D&) { return Json(); }),
      property("viscosity", &M::viscosity, &M::viscosity_points, "Pa s", "0.001",
               "[Pa s]; of a liquid with one of the next two the consistency K [Pa s^n]"),
      property("yield_stress", &M::yield_stress, &M::yield_stress_points, "Pa", "0",
               "[Pa] of a liquid: below it the liquid [hardly flows](design/viscosity.md#yield-stress). "
               "Ketchup 15, mayonnaise 80, cold lava 1000. Or points of temperature"),
      number<D>("flow_index", "flow_index", MEMBER(desc.flow_index), "below 1 thins", between(0.1, 3), "1",
                "n of a liquid, 0.1..3: below 1 it thins as it is sheared, above 1 it thickens"),
      number<D>(
          "regularisation", "regularisation", MEMBER(desc.regularisation), "s",
          {{{"exclusiveMinimum", 0}}, false}, "100",
          "[s] of a liquid with one of the two: below a shear rate of 1/`regularisation` what does not yield "
          "creeps, with a viscosity of yield_stress regularisation, which stages or sub-steps have to bear"),
      custom<D>(
          "melting_point", "melting_point", "`never`", "[degrees Celsius]; needs `becomes`", nullptr,
          [](const Node& value, D& m) { m.desc.melting_point = melting_point(value); },
          [](const D& m) { return echo_number(m.desc.melting_point); }),
      number<D>(
          "melting_range", "melting_range", MEMBER(desc.melting_range), "K", at_least(0), "0",
          "[K]; it is wholly molten so much above `melting_point`, where melting begins, as alloys, fats and "
          "glass are: the share that is liquid is linear in between. It stays a body until all of it has "
          "molten"),
      number<D>("latent_heat", "latent_heat", MEMBER(desc.latent_heat), "J/kg", at_least(0), "0", "[J/kg]"),
      name_of_material("becomes", "melts_into", &D::becomes, "name of the liquid it melts into"),
      name_of_material("dissolves_in", "dissolves_in", &D::dissolves_in,
                       "name of the liquid that it dissolves in, if it is solid, or mixes with: a "
                       "[species](design/species.md), at most three in a scene"),
      property("solubility", &M::solubility, &M::solubility_points, "kg per kg of solution, 0 to 1", "1",
               "mass fraction of the saturated solution, above 0 up to 1; below 1 for bodies; 1: a liquid "
               "that mixes in any ratio. Or points of temperature, each below 1: what is too much "
               "[precipitates](design/species.md#solubility-over-temperature-and-precipitation) onto bodies"),
      number<D>("diffusivity_in", "diffusivity_in", MEMBER(desc.diffusivity_in), "m^2/s",
                {{{"exclusiveMinimum", 0}}, false}, "", "[m^2/s] in the solvent; needed with `dissolves_in`"),
      number<D>("heat_of_solution", "heat_of_solution", MEMBER(desc.heat_of_solution), "J/kg", any_number(),
                "0", "[J/kg] that dissolving takes up; negative gives heat off"),
      maybe_number<D>("transfer_coefficient", "transfer_coefficient", MEMBER(desc.transfer_coefficient),
                      "m/s", {{{"exclusiveMinimum", 0}}, false}, "",
                      "[m/s]: how fast a body dissolves where the layer of liquid at it is thinner than the "
                      "spacing; `check` says when"),
      custom<D>(
          "color", "", "",
          "`[red, green, blue]` in pictures, 0 to 1 as monitors show them; a liquid that has one is opaque, "
          "one without is clear; bodies without one take theirs from a palette",
          nullptr, [](const Node& value, D& m) { m.color = color_of(value); },
          [](const D& m) { return m.color ? Json(*m.color) : Json(); }),
      flag<D>(
          "freezes", "freezes", MEMBER(desc.freezes), "false",
          "its liquid freezes onto bodies of this material below the melting point; one solid per liquid"),
      whole_number<D>("region_half_width", "region_half_width", MEMBER(desc.region_half_width), between(0, 8),
                      "2", "0..8; larger is stiffer, 0 is loose grains"),
      number<D>("stiffness", "stiffness", MEMBER(desc.stiffness), "0 to 1",
                {{{"exclusiveMinimum", 0}, {"maximum", 1}}, false}, "1",
                "of shape matching, above 0 up to 1; the modulus then follows density and sound speed"),
      number<D>("youngs_modulus", "youngs_modulus", MEMBER(desc.youngs_modulus), "Pa", at_least(0), "0",
                "[Pa]; instead of `stiffness`: bodies keep this modulus whatever the step, see below; 0 = "
                "`stiffness` holds"),
      number<D>("damping", "damping", MEMBER(desc.damping), "0 to 1", between(0, 1), "0.1",
                "share of non-rigid motion removed per acoustic step (courant H/c), 0..1; at least 0.11 "
                "stiffness^1.5"),
      number<D>("friction", "friction", MEMBER(desc.friction), "Coulomb coefficient", at_least(0), "0.3",
                "Coulomb coefficient"),
      number<D>("surface_tension", "surface_tension", MEMBER(desc.surface_tension), "N/m", at_least(0), "0",
                "[N/m] of a liquid; 0 = none. It may shorten the sub-step ([limits](limits.md))"),
      number<D>("contact_angle", "contact_angle", MEMBER(desc.contact_angle), "degrees", between(0, 180),
                "90", "[degrees] of a solid: of liquids with surface tension that touch it, 0..180")};
  return options;
}

#undef OF_WORLD

}  // namespace runner
