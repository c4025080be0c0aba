// SPDX-License-Identifier: Apache-2.0
#include "scene_json.hpp"

#include <algorithm>

#include "echo.hpp"
#include "scene_options.hpp"

namespace runner {

namespace {

/// The scene with derived values in place of `auto`.
Scene with_derived(const Scene& scene, const meltsim::Resolved& resolved) {
  Scene said = scene;
  if (scene.world.sound_speed > 0) said.world.density_error = 0;
  said.world.sound_speed = resolved.sound_speed;
  said.world.support_radius = resolved.support_radius;
  said.world.neighbour_search = resolved.neighbour_search;
  return said;
}

/// Null where nothing is dissolved.
Json fractions_json(const SceneFractions& fractions) {
  Json json;
  for (const auto& [name, value] : fractions) json[name] = value;
  return json;
}

/// Without what says nothing: of a material that has no solvent, of a stiffness that youngs_modulus replaces.
Json material_json(const SceneMaterial& material) {
  Json json = options_json(material_options(), material);
  json.erase(material.desc.youngs_modulus > 0 ? "stiffness" : "youngs_modulus");
  if (material.dissolves_in.empty())
    for (const char* key : {"solubility", "diffusivity_in", "heat_of_solution", "transfer_coefficient"})
      json.erase(key);
  return json;
}

Json body_json(const SceneBody& body) {
  Json json;
  json["name"] = body.desc.name;
  json["shape"] = body.shape.echo;
  json["material"] = body.material;
  if (body.density) json["density"] = *body.density;
  json["temperature"] = body.desc.temperature;
  json["velocity"] = echo(body.desc.velocity);
  json["angular_velocity"] = echo(body.desc.angular_velocity);
  const Json surface = surface_json(body.desc.surface);
  if (!surface.is_null()) json["surface"] = surface;
  if (body.desc.heat_source != 0) json["heat_source"] = body.desc.heat_source;
  json["fixed"] = body.desc.fixed;
  if (body.desc.held_until > 0) json["held_until"] = echo_number(body.desc.held_until);
  if (body.desc.motion != meltsim::Motion::free)
    json["motion"] = keys::motion.at(static_cast<std::size_t>(body.desc.motion));
  if (body.desc.pivot) json["pivot"] = echo(*body.desc.pivot);
  if (body.desc.max_speed != 0) json["max_speed"] = body.desc.max_speed;
  json["carve"] = body.desc.carve;
  if (body.desc.growth != 0) json["growth"] = body.desc.growth;
  return json;
}

/// What its kind uses.
Json field_json(const SceneForceField& field) {
  const meltsim::ForceFieldDesc& desc = field.desc;
  Json json = {{"name", desc.name}, {"kind", keys::field_kind.at(static_cast<std::size_t>(desc.kind))}};
  if (field.shape) json["shape"] = field.shape->echo;
  if (desc.center) json["center"] = echo(*desc.center);
  switch (desc.kind) {
    case meltsim::ForceFieldKind::uniform:
      json["acceleration"] = echo(desc.acceleration);
      break;
    case meltsim::ForceFieldKind::drag:
      json["velocity"] = echo(desc.velocity);
      json["angular_velocity"] = echo(desc.angular_velocity);
      json["rate"] = desc.rate;
      break;
    case meltsim::ForceFieldKind::vortex:
      json["axis"] = echo(desc.axis);
      [[fallthrough]];
    case meltsim::ForceFieldKind::radial:
      json["strength"] = desc.strength;
      json["radius"] = desc.radius;
      json["power"] = desc.power;
  }
  json["liquid"] = desc.liquid;
  json["bodies"] = desc.bodies;
  json["from"] = desc.from;
  json["until"] = echo_number(desc.until);
  return json;
}

Json emitter_json(const SceneEmitter& emitter) {
  const meltsim::EmitterDesc& desc = emitter.desc;
  Json json;
  json["name"] = desc.name;
  json["nozzle"] = {{"center", echo(desc.center)}, {"axis", echo(desc.axis)}};
  if (desc.width > 0) {
    json["nozzle"]["width"] = desc.width;
    json["nozzle"]["height"] = desc.height;
    json["nozzle"]["up"] = echo(desc.up);
  } else {
    json["nozzle"]["radius"] = desc.radius;
  }
  json["speed"] = desc.speed;
  json["material"] = emitter.material;
  json["temperature"] = desc.temperature;
  json["from"] = desc.from;
  json["until"] = echo_number(desc.until);
  if (desc.max_particles > 0) json["max_particles"] = desc.max_particles;
  if (const Json fractions = fractions_json(emitter.fractions); !fractions.is_null())
    json["fractions"] = fractions;
  return json;
}

Json probe_json(const SceneProbe& probe) {
  const meltsim::ProbeDesc& desc = probe.desc;
  Json json{{"name", desc.name}, {"kind", keys::probe_kind.at(static_cast<std::size_t>(desc.kind))}};
  if (!probe.body.empty()) json["body"] = probe.body;
  if (desc.wall) json["wall"] = keys::one_face.at(static_cast<std::size_t>(*desc.wall));
  if (!desc.points.empty())
    json[desc.kind == meltsim::ProbeKind::force ? "about" : "at"] = echo(desc.points.front());
  if (desc.kind == meltsim::ProbeKind::flux) {
    json["normal"] = echo(desc.normal);
    if (desc.radius > 0) {
      json["radius"] = desc.radius;
    } else {
      json["size"] = {desc.size[0], desc.size[1]};
      json["along"] = echo(desc.along);
    }
  }
  if (!desc.fields.empty()) json["fields"] = desc.fields;
  if (desc.every > 0) json["every"] = desc.every;
  else json["every"] = "step";
  return json;
}

Json trade_json(const SceneTrade& trade) {
  Json json = Json::object();
  if (!trade.observe.empty()) json["observe"] = trade.observe;
  if (trade.max_error) json["max_error"] = *trade.max_error;
  for (const auto& [name, points] : trade.exact) {
    if (points.size() == 1) json["exact"][name] = points.front().value;
    else
      for (const ExactPoint& point : points) json["exact"][name].push_back({point.time, point.value});
  }
  return json;
}

}  // namespace

Json scene_json(const Scene& scene, const meltsim::Resolved& resolved) {
  Json json;
  json["meltsim"] = 1;
  if (!scene.title.empty()) json["title"] = scene.title;
  const Scene said = with_derived(scene, resolved);
  const bool solutes = std::any_of(scene.materials.begin(), scene.materials.end(),
                                   [](const SceneMaterial& m) { return !m.dissolves_in.empty(); });
  for (const Section& section : scene_sections())
    if (section.options != solute_options || solutes)
      json[section.name] = options_json(section.options(), said);
  for (const SceneMaterial& material : scene.materials)
    json["materials"][material.desc.name] = material_json(material);
  for (const SceneFluid& fluid : scene.fluids) {
    json["fluids"].push_back({{"shape", fluid.shape.echo},
                              {"material", fluid.material},
                              {"temperature", fluid.desc.temperature},
                              {"velocity", echo(fluid.desc.velocity)}});
    if (const Json fractions = fractions_json(fluid.fractions); !fractions.is_null())
      json["fluids"].back()["fractions"] = fractions;
  }
  for (const SceneBody& body : scene.bodies) json["bodies"].push_back(body_json(body));
  for (const SceneEmitter& emitter : scene.emitters) json["emitters"].push_back(emitter_json(emitter));
  for (const SceneForceField& field : scene.force_fields) json["force_fields"].push_back(field_json(field));
  for (const SceneProbe& probe : scene.probes) json["probes"].push_back(probe_json(probe));
  const Json trade = trade_json(scene.trade);
  if (!trade.empty()) json["trade"] = trade;
  json["output"]["export"] = scene.output.formats;
  if (!scene.output.surface.is_null()) json["output"]["surface"] = scene.output.surface;
  if (!scene.output.camera.is_null()) json["output"]["camera"] = scene.output.camera;
  if (!scene.output.picture.is_null()) json["output"]["picture"] = scene.output.picture;
  return json;
}

}  // namespace runner
