// SPDX-License-Identifier: Apache-2.0
// Rows of what a scene lists, of its outputs and wishes; see scene_options.hpp.
#include <fmt/format.h>

#include "echo.hpp"
#include "load_heat.hpp"
#include "load_parts.hpp"
#include "load_shape.hpp"
#include "numbers.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

using meltsim::EmitterDesc;
using meltsim::ProbeKind;

/// Where names stand in CSV files, they have neither commas nor quotes nor line breaks.
template <class D>
Option<D> name_of(bool in_tables, const char* otherwise) {
  return custom<D>(
      "name", "", otherwise,
      in_tables ? "without commas, quotes or line breaks; no other has it" : "no other has it",
      {{"type", "string"}},
      [in_tables](const Node& value, D& d) {
        d.desc.name = value.text("a name");
        const bool plain = !d.desc.name.empty() && d.desc.name.find_first_of(",\"\n\r") == std::string::npos;
        if (in_tables && !plain)
          value.fail(
              fmt::format("expected a name without commas, quotes or line breaks, got {}", value.found()));
      },
      [](const D& d) { return d.desc.name; });
}

Json shape_echo(const SceneShape& shape) { return shape.echo; }
Json shape_echo(const std::optional<SceneShape>& shape) { return shape ? shape->echo : Json(); }

template <class D>
Option<D> shape_of(const char* doc) {
  return custom<D>(
      "shape", "shape", "", doc, {{"$ref", "#/$defs/shape"}},
      [](const Node& value, D& d) {
        const SceneShape shape = load_shape(value);
        d.desc.shape = shape.shape;
        d.shape = shape;
      },
      [](const D& d) { return shape_echo(d.shape); });
}
constexpr const char* a_shape = "e.g. {box: [[0,0,0],[1,1,1]]} (m)";

template <class D>
Option<D> material_of(const char* doc) {
  return custom<D>(
             "material", "material", "", doc, {{"type", "string"}},
             [](const Node& value, D& d) { d.material = value.text("the name of a material"); },
             [](const D& d) { return d.material; })
      .must_be_given("the name of a material");
}

template <class D>
Option<D> temperature_of(const char* doc) {
  Option<D> option = number<D>("temperature", "temperature", MEMBER(desc.temperature), "degrees Celsius",
                               at_least(meltsim::absolute_zero), "20", doc);
  option.load = [](const Node& value, D& d) {
    d.desc.temperature = value.number("degrees Celsius");
    if (d.desc.temperature < meltsim::absolute_zero)
      value.fail(fmt::format("expected at least {} (degrees Celsius, absolute zero), got {}",
                             meltsim::absolute_zero, value.found()));
  };
  return option;
}

template <class D>
Option<D> fractions_of() {
  return custom<D>(
      "fractions", "fractions", "",
      "mapping of [species](design/species.md) to what is dissolved of each, kg per kg of mixture, 0 to 1",
      {{"type", "object"}, {"additionalProperties", typed("number", between(0, 1))}},
      [](const Node& value, D& d) {
        for (const auto& [name, part] : value.entries())
          d.fractions.emplace_back(name, part.number("kg per kg of mixture, 0 to 1"));
      },
      [](const D& d) {
        Json json;
        for (const auto& [name, value] : d.fractions) json[name] = value;
        return json;
      });
}

template <class D>
Option<D> from_of() {
  return number<D>("from", "from", MEMBER(desc.from), "s", at_least(0), "0", "begins to act [s]");
}
template <class D>
Option<D> until_of() {
  return time_or_never<D>("until", "until", MEMBER(desc.until), "`inf`", "ceases to act [s]");
}

/// A whole number of a picture or a mesh; what is not given is left out.
Option<Json> pixels(const char* key, int least, int most, const char* unit, const char* otherwise,
                    const char* doc) {
  return custom<Json>(
      key, "", otherwise, doc, typed("integer", between(least, most)),
      [=](const Node& value, Json& to) {
        const int number = value.small_integer();
        if (number < least || number > most)
          value.fail(fmt::format("expected {} to {} {}, got {}", least, most, unit, number));
        to[key] = number;
      },
      [=](const Json& from) { return from.value(key, Json()); });
}

Option<Json> word_of(const char* key, const keys::List& words, const char* otherwise, const char* doc) {
  return custom<Json>(
      key, "", otherwise, doc, {{"enum", words}},
      [=](const Node& value, Json& to) { to[key] = value.choice(words); },
      [=](const Json& from) { return from.value(key, Json()); });
}

Option<Json> place_of(const char* key, const char* otherwise, const char* doc) {
  return custom<Json>(
      key, "", otherwise, doc, {{"$ref", "#/$defs/vector"}},
      [=](const Node& value, Json& to) { to[key] = echo(value.vector("m")); },
      [=](const Json& from) { return from.value(key, Json()); });
}

/// One word of a list, for a message: the fields of a kind of probe.
const keys::List& fields_of(ProbeKind kind) {
  return kind == ProbeKind::force  ? keys::force_field
         : kind == ProbeKind::flux ? keys::flux_field
                                   : keys::probe_field;
}

Json all_fields() {
  keys::List fields = keys::probe_field;
  for (const keys::List& more : {keys::force_field, keys::flux_field})
    fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

/// What one observable is called: a word, some with @ and a name.
std::string observable_pattern() {
  std::string words;
  for (const std::string& word : keys::observables) words += (words.empty() ? "" : "|") + word;
  return "^(" + words + ")(@.+)?$";
}

}  // namespace

const Options<meltsim::OutletDesc>& outlet_options() {
  using D = meltsim::OutletDesc;
  static const Options<D> options{
      maybe_number<D>("level", "", MEMBER(level), "m", any_number(), "",
                      "height of the liquid beyond [m], against gravity"),
      maybe_number<D>("speed", "", MEMBER(speed), "m/s", above_zero(), "", "[m/s] at which liquid leaves")};
  return options;
}

const Options<SceneHeatRegion>& heat_region_options() {
  using D = SceneHeatRegion;
  static const Options<D> options{
      name_of<D>(false, "`heat1`, ..."),
      shape_of<D>("the volume").must_be_given(a_shape),
      maybe_number<D>("temperature", "temperature", MEMBER(desc.temperature), "degrees Celsius",
                      at_least(meltsim::absolute_zero), "",
                      "what is inside is held at this [degrees Celsius]; excludes `source`"),
      custom<D>(
          "source", "source", "0", "heat released [W/m^3]; negative cools", {{"type", "number"}},
          [](const Node& value, D& d) { d.desc.source = value.number("W/m^3"); },
          [](const D& d) { return d.desc.temperature ? Json() : Json(d.desc.source); }),
      from_of<D>(),
      until_of<D>(),
      custom<D>(
          "path", "path", "",
          "where it is at what time: points `[[time, x, y, z], ...]` [s, m], from where `shape` is; it moves "
          "in straight lines, at constant speed from "
          "one point to the next, before the first and after the last it is at rest",
          {{"type", "array"},
           {"minItems", 1},
           {"items", {{"type", "array"}, {"minItems", 4}, {"maxItems", 4}, {"items", {{"type", "number"}}}}}},
          [](const Node& value, D& d) { d.desc.path = load_path(value); },
          [](const D& d) {
            Json json;
            for (const meltsim::PathPoint& p : d.desc.path)
              json.push_back({p.time, p.displacement.x, p.displacement.y, p.displacement.z});
            return json;
          })};
  return options;
}

const Options<SceneFluid>& fluid_options() {
  using D = SceneFluid;
  static const Options<D> options{
      shape_of<D>(
          "the volume. Where it reaches from wall to wall, it fills what is between, though that is no whole "
          "number of spacings; other points nearer to a wall than half a spacing are left out")
          .must_be_given(a_shape),
      material_of<D>("of the liquid"), temperature_of<D>("[degrees Celsius]"),
      vector<D>("velocity", "velocity", MEMBER(desc.velocity), "m/s", "[0, 0, 0]", "[m/s]"),
      fractions_of<D>()};
  return options;
}

const Options<SceneBody>& body_options() {
  using D = SceneBody;
  static const Options<D> options{
      name_of<D>(true, "`body1`, ..."),
      shape_of<D>("the volume").must_be_given(a_shape),
      material_of<D>("of the body"),
      maybe_number<D>("density", "density", MEMBER(density), "kg/m^3", above_zero(), "",
                      "[kg/m^3], instead of the material's; not of a material that freezes"),
      temperature_of<D>("[degrees Celsius]"),
      vector<D>("velocity", "velocity", MEMBER(desc.velocity), "m/s", "[0, 0, 0]", "[m/s]"),
      vector<D>("angular_velocity", "angular_velocity", MEMBER(desc.angular_velocity), "rad/s", "[0, 0, 0]",
                "[rad/s]"),
      flag<D>("fixed", "fixed", MEMBER(desc.fixed), "false", "never moves: short for `motion: fixed`"),
      time_or_never<D>(
          "held_until", "held_until", MEMBER(desc.held_until), "0",
          "a free or rigid body stays where it is until the first step that begins then [s], and "
          "is let go at its `velocity`; `inf`: for good")
          .echoed_if_set(),
      word<D>(
          "motion", "motion", MEMBER(desc.motion), keys::motion, "`free`",
          "`kinematic`: the body goes on at `velocity` and `angular_velocity` about its `pivot`, whatever "
          "acts on it, such as a stirrer; `rigid`: forces move it and nothing deforms it, at less cost "
          "([concepts](concepts.md#rigid-or-free)). There is no `proxy`: a proxy is a body of a host's "
          "physics engine, which a scene file does not have; without one it moves as `rigid`")
          .echoed_if_set(),
      vector<D>("pivot", "pivot", MEMBER(desc.pivot), "m", "its centre",
                "of a kinematic body: what it turns about [m]"),
      custom<D>(
          "path", "path", "",
          "of a kinematic body, in place of velocities: where it is at what time, points `[[time, x, y, z], "
          "...]` or, where it turns, `[[time, x, y, z, "
          "angle], ...]` [s, m, degrees], from where it is built, which the first point is; straight and at "
          "constant rates from one point to the "
          "next, before the first and after the last at rest",
          {{"type", "array"},
           {"minItems", 1},
           {"items", {{"type", "array"}, {"minItems", 4}, {"maxItems", 5}, {"items", {{"type", "number"}}}}}},
          [](const Node& value, D& d) { d.desc.path = load_poses(value); },
          [](const D& d) {
            Json json;
            for (const meltsim::PosePoint& p : d.desc.path)
              json.push_back(
                  {p.time, p.displacement.x, p.displacement.y, p.displacement.z, p.angle * degrees});
            return json;
          }),
      vector<D>("path_axis", "path_axis", MEMBER(desc.path_axis), "", "[0, 0, 1]",
                "through the pivot, that angles of `path` turn about")
          .echoed_if_set(),
      number<D>("max_speed", "max_speed", MEMBER(desc.max_speed), "m/s", at_least(0), "0",
                "largest speed that any point of the body will have [m/s], where that is more than what it "
                "starts with and falls makes it: sound is ten times as fast")
          .echoed_if_set(),
      flag<D>("carve", "carve", MEMBER(desc.carve), "true",
              "liquid inside the body is carved away; `false`: it is refused"),
      flag<D>("visible", "visible", MEMBER(visible), "true",
              "`false`: pictures, the movie and the page leave the body out, such as a vessel that hides "
              "what is in it; files of frames and tables have it all the same, and the liquid's surface "
              "covers its face to it")
          .echoed_if_set(),
      custom<D>(
          "surface", "surface", "",
          "what heat does at the dry part of its surface, keys below. What has melted and stays on it covers "
          "it: "
          "`heat.free_surface` heats through that",
          {{"$ref", "#/$defs/surface_heat"}},
          [](const Node& value, D& d) { d.desc.surface = load_surface(value); },
          [](const D& d) { return surface_json(d.desc.surface); }),
      number<D>("heat_source", "heat_source", MEMBER(desc.heat_source), "W/m^3", any_number(), "0",
                "heat released in the body [W/m^3]")
          .echoed_if_set(),
      whole_number<D>(
          "growth", "growth", MEMBER(desc.growth), at_least(0), "0",
          "how many lattice steps around its shape liquid may freeze onto it; 0: only where it was "
          "solid before")
          .echoed_if_set()};
  return options;
}

const Options<EmitterDesc>& nozzle_options() {
  using D = EmitterDesc;
  // Keys of a rectangle are echoed where there is one, that of a disc otherwise.
  const auto of = [](Option<D> option, bool rectangle) {
    option.echo = [echo = std::move(option.echo), rectangle](const D& d) {
      return (d.width > 0) == rectangle ? echo(d) : Json();
    };
    return option;
  };
  static const Options<D> options{
      vector<D>("center", "center", MEMBER(center), "m", "",
                "[m]: where the pipe ends, or begins where a wall or body is right behind")
          .must_be_given("3 numbers [x, y, z] (m)"),
      vector<D>("axis", "axis", MEMBER(axis), "any length", "[0, -1, 0]", "direction of the stream"),
      of(number<D>("radius", "radius", MEMBER(radius), "m", above_zero(), "", "of a disc [m]"), false),
      of(number<D>("width", "width", MEMBER(width), "m", above_zero(), "", "of a rectangle, across [m]"),
         true),
      of(number<D>("height", "height", MEMBER(height), "m", above_zero(), "",
                   "of a rectangle, along `up` [m]"),
         true),
      of(vector<D>("up", "up", MEMBER(up), "any length", "[0, 1, 0]",
                   "direction of the height of a rectangle"),
         true)};
  return options;
}

namespace {
/// A face of the domain that a value names, in the order of keys::one_face.
std::size_t face_of(const Node& value) {
  const std::string name = value.choice(keys::one_face);
  const auto at = std::find(keys::one_face.begin(), keys::one_face.end(), name);
  return static_cast<std::size_t>(at - keys::one_face.begin());
}

/// Inwards from such a face.
meltsim::Vec3d inwards_from(std::size_t face) {
  const double sign = face % 2 == 0 ? 1 : -1;
  return {face / 2 == 0 ? sign : 0, face / 2 == 1 ? sign : 0, face / 2 == 2 ? sign : 0};
}
}  // namespace

const Options<EmitterDesc>& reservoir_options() {
  using D = EmitterDesc;
  static const Options<D> options{
      custom<D>(
          "face", "axis", "", "an open face of the domain", {{"enum", keys::one_face}},
          [](const Node& value, D& d) { d.axis = inwards_from(face_of(value)); },
          [](const D& d) {
            for (std::size_t f = 0; f < keys::one_face.size(); ++f)
              if (dot(d.axis, inwards_from(f)) > 0) return Json(keys::one_face[f]);
            return Json();
          })
          .must_be_given("-x, +x, -y, +y, -z or +z"),
      maybe_number<D>("level", "level", MEMBER(level), "m", any_number(), "",
                      "height of the liquid beyond [m], against gravity")
          .must_be_given("a number (m)"),
      number<D>("height", "height", MEMBER(height), "m", above_zero(), "up to the level",
                "how far above the floor the level may rise while the scene runs [m]")
          .echoed_if_set()};
  return options;
}

const Options<SceneEmitter>& emitter_options() {
  using D = SceneEmitter;
  static const Options<D> options{
      name_of<D>(true, "`emitter1`, ..."),
      custom<D>(
          "nozzle", "", "",
          "a pipe about two spacings long, keys below: `radius`, or `width` and `height`. It works under "
          "water, too. The upstream end of a channel is a rectangle at a wall, half a spacing off it",
          nullptr, [](const Node& value, D& d) { load_nozzle(value, d.desc); },
          [](const D& d) { return d.desc.level ? Json() : options_json(nozzle_options(), d.desc); }),
      custom<D>(
          "reservoir", "", "",
          "instead of a nozzle: liquid beyond an open face of the domain, keys below. It comes in where it "
          "is "
          "lower inside and leaves where it is higher, and so do waves; see "
          "[open channels](design/outlets.md)",
          nullptr, [](const Node& value, D& d) { load_options(value, reservoir_options(), d.desc); },
          [](const D& d) { return d.desc.level ? options_json(reservoir_options(), d.desc) : Json(); }),
      number<D>("speed", "speed", MEMBER(desc.speed), "m/s", above_zero(), "1",
                "[m/s]: density × area × speed is the mass per second"),
      material_of<D>("of the liquid"),
      temperature_of<D>("[degrees Celsius]"),
      fractions_of<D>(),
      from_of<D>(),
      until_of<D>(),
      custom<D>(
          "max_particles", "max_particles", "",
          "most that it emits; of a reservoir, and where it recycles, that are there at a time; needed by a "
          "nozzle that never stops and "
          "does not recycle",
          typed("integer", at_least(0)),
          [](const Node& value, D& d) {
            const std::int64_t most = value.integer();
            if (most < 0) value.fail(fmt::format("expected 0 or more, got {}", value.found()));
            d.desc.max_particles = static_cast<std::uint64_t>(most);
          },
          [](const D& d) { return d.desc.max_particles > 0 ? Json(d.desc.max_particles) : Json(); }),
      flag<D>("recycle", "recycle", MEMBER(desc.recycle), "false",
              "of a nozzle: particles of it that have left the domain come again, so that it goes on for "
              "ever in the memory of "
              "`max_particles`; without that, of as many as fill the domain")
          .echoed_if_set()};
  return options;
}

const Options<SceneForceField>& force_field_options() {
  using D = SceneForceField;
  const keys::List around{"radial", "vortex"};
  static const Options<D> options{
      name_of<D>(false, "`field1`, ..."),
      word<D>("kind", "kind", MEMBER(desc.kind), keys::field_kind, "",
              "`uniform`; `radial`: away from `center`, or towards it; `vortex`: around `axis` through "
              "`center`; `drag`: towards a wind; `hydrostatic`: counts pressure below a level from that of a "
              "liquid at rest, for bodies deep in liquid")
          .must_be_given("uniform, radial, vortex, drag or hydrostatic"),
      shape_of<D>("a box, a sphere or a cylinder, also transformed; without one: everywhere"),
      vector<D>("acceleration", "acceleration", MEMBER(desc.acceleration), "m/s^2", "[0, 0, 0]", "[m/s^2]")
          .of_kinds({"uniform"}),
      vector<D>("center", "center", MEMBER(desc.center), "m", "that of the shape",
                "[m]; what the field is about, or the wind turns about; a point of a hydrostatic level")
          .of_kinds({"radial", "vortex", "drag", "hydrostatic"}),
      vector<D>("axis", "axis", MEMBER(desc.axis), "any length", "[0, 1, 0]", "of any length")
          .of_kinds({"vortex"}),
      number<D>("strength", "strength", MEMBER(desc.strength), "m/s^2", any_number(), "0",
                "[m/s^2] at the radius; negative attracts")
          .of_kinds(around),
      number<D>("radius", "radius", MEMBER(desc.radius), "m", at_least(0), "0",
                "[m]: within it the field grows linearly from the centre; of a hydrostatic one down from the "
                "level, 0: a support")
          .of_kinds({"radial", "vortex", "hydrostatic"}),
      number<D>("density", "density", MEMBER(desc.density), "kg/m^3", at_least(0), "0",
                "[kg/m^3] of the liquid whose pressure at rest is taken out")
          .of_kinds({"hydrostatic"}),
      custom<D>(
          "power", "power", "0", "1, 0, -1 or -2: beyond the radius it goes as the distance to this power",
          {{"enum", {1, 0, -1, -2}}}, [](const Node& value, D& d) { d.desc.power = value.small_integer(); },
          [](const D& d) { return d.desc.power; })
          .of_kinds(around),
      vector<D>("velocity", "velocity", MEMBER(desc.velocity), "m/s", "[0, 0, 0]", "of the wind [m/s]")
          .of_kinds({"drag"}),
      vector<D>("angular_velocity", "angular_velocity", MEMBER(desc.angular_velocity), "rad/s", "[0, 0, 0]",
                "of the wind about `center` [rad/s]")
          .of_kinds({"drag"}),
      number<D>("rate", "rate", MEMBER(desc.rate), "1/s", at_least(0), "0",
                "[1/s] at which a difference from the wind decays")
          .of_kinds({"drag"}),
      flag<D>("liquid", "liquid", MEMBER(desc.liquid), "true", "acts on liquid"),
      flag<D>("bodies", "bodies", MEMBER(desc.bodies), "true", "acts on bodies that can move"),
      from_of<D>(),
      until_of<D>()};
  return options;
}

std::string kind_of(const SceneForceField& field) {
  return keys::field_kind.at(static_cast<std::size_t>(field.desc.kind));
}

const Options<SceneProbe>& probe_options() {
  using D = SceneProbe;
  const auto point = [](const char* key, const char* otherwise, const char* doc) {
    return custom<D>(
        key, "", otherwise, doc, {{"$ref", "#/$defs/vector"}},
        [](const Node& value, D& d) { d.desc.points = {value.vector("m")}; },
        [](const D& d) { return d.desc.points.empty() ? Json() : echo(d.desc.points.front()); });
  };
  const keys::List sides{"force", "heat"};
  static const Options<D> options{
      name_of<D>(true, "`probe1`, ..."),
      word<D>("kind", "", MEMBER(desc.kind), keys::probe_kind, "`point`",
              "`point`: averages of fields; `level`: height of the liquid's surface along the line through "
              "the point against gravity; `force`: on a body or wall; `heat`: into a body or through a wall; "
              "`flux`: of liquid through a disc or rectangle"),
      point("at", "", "[m]; of a flux the middle of the opening")
          .of_kinds({"point", "level", "flux"})
          .must_be_given("3 numbers [x, y, z] (m)"),
      custom<D>(
          "body", "", "", "name of a body", {{"type", "string"}},
          [](const Node& value, D& d) { d.body = value.text("the name of a body"); },
          [](const D& d) { return d.body.empty() ? Json() : Json(d.body); })
          .of_kinds(sides),
      custom<D>(
          "wall", "", "", "face of the domain, instead of a body", {{"enum", keys::one_face}},
          [](const Node& value, D& d) { d.desc.wall = static_cast<int>(face_of(value)); },
          [](const D& d) {
            return d.desc.wall ? Json(keys::one_face.at(static_cast<std::size_t>(*d.desc.wall))) : Json();
          })
          .of_kinds(sides),
      point("about", "the body's centre of mass, the wall's middle", "[m]: the point that moments are about")
          .of_kinds({"force"}),
      vector<D>("normal", "normal", MEMBER(desc.normal), "any length", "",
                "direction that counts as positive")
          .of_kinds({"flux"})
          .must_be_given("the direction that counts as positive, [x, y, z]"),
      custom<D>(
          "radius", "radius", "", "of a disc [m]", typed("number", above_zero()),
          [](const Node& value, D& d) { d.desc.radius = value.positive("m"); },
          [](const D& d) { return d.desc.radius > 0 ? Json(d.desc.radius) : Json(); })
          .of_kinds({"flux"}),
      custom<D>(
          "size", "size", "", "`[a, b]`, sides of a rectangle [m]",
          {{"type", "array"}, {"minItems", 2}, {"maxItems", 2}, {"items", typed("number", above_zero())}},
          [](const Node& value, D& d) {
            const std::vector<Node> sides_of = value.items("2 numbers (m)");
            if (sides_of.size() != 2)
              value.fail(fmt::format("expected 2 numbers (m), got {}", value.found()));
            for (std::size_t k = 0; k < 2; ++k) d.desc.size[k] = sides_of[k].positive("m");
          },
          [](const D& d) {
            return d.desc.radius > 0 ? Json() : Json{d.desc.size[0], d.desc.size[1]};
          })
          .of_kinds({"flux"}),
      custom<D>(
          "along", "along", "", "direction of the first side of a rectangle", {{"$ref", "#/$defs/vector"}},
          [](const Node& value, D& d) { d.desc.along = value.vector("any length"); },
          [](const D& d) { return d.desc.radius > 0 ? Json() : echo(d.desc.along); })
          .of_kinds({"flux"}),
      custom<D>(
          "fields", "fields", "", "list of what to sample, see below",
          {{"type", "array"}, {"items", {{"enum", all_fields()}}}},
          [](const Node& value, D& d) {
            for (const Node& field : value.items("fields"))
              d.desc.fields.push_back(field.choice(fields_of(d.desc.kind)));
          },
          [](const D& d) { return d.desc.fields.empty() ? Json() : Json(d.desc.fields); })
          .of_kinds({"point", "force", "flux"}),
      custom<D>(
          "every", "every", "a frame", "[s], or `step`: in each sub-step",
          {{"anyOf", {typed("number", above_zero()), {{"const", "step"}}}}},
          [](const Node& value, D& d) {
            d.desc.every = value.is_word("step") ? 0 : value.positive("s, or step");
          },
          [](const D& d) { return d.desc.every > 0 ? Json(d.desc.every) : Json("step"); })};
  return options;
}

std::string kind_of(const SceneProbe& probe) {
  return keys::probe_kind.at(static_cast<std::size_t>(probe.desc.kind));
}

void take_default_fields(const Node& item, SceneProbe& probe) {
  const ProbeKind kind = probe.desc.kind;
  if (kind == ProbeKind::level || kind == ProbeKind::heat || item.find("fields")) return;
  const keys::List& known = fields_of(kind);
  if (kind == ProbeKind::point) item.require("fields", "a list of " + either_of(known));
  probe.desc.fields = {known.front()};
}

const Options<Json>& surface_options() {
  static const Options<Json> options{
      custom<Json>(
          "cell", "", "half a spacing",
          "edge of the cells that surfaces are made of [m]; a third of a spacing by default where there are "
          "fewer than 10,000 particles",
          typed("number", above_zero()),
          [](const Node& value, Json& to) { to["cell"] = value.positive("m"); },
          [](const Json& from) { return from.value("cell", Json()); }),
      word_of("kernel", keys::surface_kernel, "`isotropic`",
              "`isotropic`, or `anisotropic`, which is flatter, smoother and slower"),
      pixels("smoothing", 0, 100, "passes", "4", "passes that take out bumps, 0 to 100"),
      custom<Json>(
          "closed_at_solids", "", "false",
          "the liquid's mesh also covers what touches solids, so that it is closed everywhere. Renderers "
          "want that for light that is "
          "absorbed on its way through the liquid. Both sheets then lie on each other at solids, which "
          "renderers show as specks "
          "where both are opaque or refract",
          {{"type", "boolean"}},
          [](const Node& value, Json& to) { to["closed_at_solids"] = value.boolean(); },
          [](const Json& from) { return from.value("closed_at_solids", Json()); })};
  return options;
}

const Options<Json>& camera_options() {
  static const Options<Json> options{
      place_of("eye", "", "[m]; what is left out follows from what there is to see"),
      place_of("look_at", "", "[m]"), place_of("up", "against gravity", "of any length"),
      custom<Json>(
          "fov", "", "40", "[degrees] from top to bottom, below 170",
          {{"type", "number"}, {"exclusiveMinimum", 0}, {"exclusiveMaximum", 170}},
          [](const Node& value, Json& to) {
            const double fov = value.positive("degrees");
            if (fov >= 170)
              value.fail(fmt::format("expected an angle below 170 degrees, got {}", value.found()));
            to["fov"] = fov;
          },
          [](const Json& from) { return from.value("fov", Json()); })};
  return options;
}

const Options<Json>& picture_options() {
  static const Options<Json> options{pixels("width", 16, 8192, "pixels", "960", "pixels"),
                                     pixels("height", 16, 8192, "pixels", "540", "pixels"),
                                     pixels("samples", 1, 8, "samples along a side of a pixel", "3",
                                            "along each side of a pixel (built-in renderer)"),
                                     word_of("look", keys::look, "`natural`", "`natural` or `temperature`")};
  return options;
}

const Options<Scene>& output_options() {
  static const Options<Scene> options{
      custom<Scene>(
          "export", "", "[ply]",
          "list of `ply`, `vtp`, `surface`, `obj`, `glb`, `usd`, `pov`, `png`, `html`; empty for none",
          {{"type", "array"}, {"items", {{"enum", keys::formats}}}},
          [](const Node& value, Scene& s) {
            s.output.formats.clear();
            for (const Node& item : value.items("formats"))
              s.output.formats.push_back(item.choice(keys::formats));
          },
          [](const Scene& s) { return Json(s.output.formats); }),
      custom<Scene>("surface", "", "", "of the meshes of surfaces, keys below", nullptr, load_surface_wish,
                    [](const Scene& s) { return s.output.surface; }),
      custom<Scene>(
          "camera", "", "", "of pictures, keys below", nullptr,
          [](const Node& value, Scene& s) { load_camera(value, s.output.camera); },
          [](const Scene& s) { return s.output.camera; }),
      custom<Scene>(
          "picture", "", "", "keys below", nullptr,
          [](const Node& value, Scene& s) { load_wish(value, picture_options(), s.output.picture); },
          [](const Scene& s) { return s.output.picture; })};
  return options;
}

const Options<Scene>& trade_options() {
  const Json name{{"type", "string"}, {"pattern", observable_pattern()}};
  const Json pair{{"type", "array"}, {"minItems", 2}, {"maxItems", 2}, {"items", {{"type", "number"}}}};
  static const Options<Scene> options{
      custom<Scene>(
          "observe", "", "",
          "list of observables, the first of which `--max-error` means: `melted`, `melt_time_50`, "
          "`melt_time_90`, `front`, `height`, `energy`, `volume`, and with `@` and a name `draught`, `path` "
          "(of a body), `pressure`, `temperature`, `level` (at a probe). By default they follow from what is "
          "in the scene; see [trade.md](trade.md)",
          {{"type", "array"}, {"minItems", 1}, {"items", name}}, load_observe,
          [](const Scene& s) { return s.trade.observe.empty() ? Json() : Json(s.trade.observe); }),
      custom<Scene>(
          "max_error", "", "",
          "error of the first observable, above 0 up to 1, or like `3%`: runs choose their settings for it, "
          "as with `--max-error`",
          {{"anyOf",
            {{{"type", "number"}, {"exclusiveMinimum", 0}, {"maximum", 1}},
             {{"type", "string"}, {"pattern", "^ *[0-9.eE+-]+ *% *$"}}}}},
          [](const Node& value, Scene& s) {
            s.trade.max_error_where = value.where();
            s.trade.max_error = parse_share(value.text("a share"));
            if (!s.trade.max_error)
              value.fail(fmt::format("expected a share above 0 and up to 1, like 0.03 or 3%, got {}",
                                     value.found()));
          },
          [](const Scene& s) { return s.trade.max_error ? Json(*s.trade.max_error) : Json(); }),
      custom<Scene>(
          "exact", "", "",
          "mapping of observables to their exact answers: a number, or a list of `[time, value]`, linear in "
          "between. Errors are then differences to it",
          {{"type", "object"},
           {"additionalProperties",
            {{"anyOf", {{{"type", "number"}}, {{"type", "array"}, {"minItems", 1}, {"items", pair}}}}}}},
          load_exact, exact_json)};
  return options;
}

}  // namespace runner
