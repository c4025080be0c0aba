// SPDX-License-Identifier: Apache-2.0
#include "scene_json.hpp"

#include <algorithm>

#include "echo.hpp"
#include "scene_keys.hpp"

namespace runner {

namespace {

using meltsim::Face;

const char* const face_keys[6] = {"-x", "+x", "-y", "+y", "-z", "+z"};

Json domain_json(const meltsim::DomainDesc& domain) {
  Json json;
  if (domain.bounded) {
    json["min"] = echo(domain.min);
    json["max"] = echo(domain.max);
  }
  json["walls"] = domain.bounded ? Json::object() : Json("none");
  Json velocity = Json::object();
  for (std::size_t i = 0; i < 6 && domain.bounded; ++i) {
    const Face face = domain.faces[i];
    if (face == Face::periodic) json["walls"][std::string(1, face_keys[i][1])] = "periodic";
    else json["walls"][face_keys[i]] = face == Face::open ? "open" : "wall";
    if (length(domain.velocity[i]) > 0) velocity[face_keys[i]] = echo(domain.velocity[i]);
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const meltsim::OutletDesc& outlet = domain.outlets[i];
    if (outlet.level) json["outlets"][face_keys[i]]["level"] = *outlet.level;
    if (outlet.speed) json["outlets"][face_keys[i]]["speed"] = *outlet.speed;
  }
  json["no_slip"] = domain.no_slip;
  json["friction"] = domain.friction;
  if (domain.contact_angle != 90) json["contact_angle"] = domain.contact_angle;
  if (!velocity.empty()) json["velocity"] = velocity;
  return json;
}

Json time_json(const SceneTime& time) {
  Json json;
  json["dt"] = time.dt ? Json(*time.dt) : Json("auto");
  json["stepping"] = time.adaptive ? "adaptive" : "fixed";
  json["end"] = time.end;
  json["fps"] = time.fps;
  json["end_when"] = time.until_melted ? "melted" : "time";
  json["tail"] = time.tail;
  return json;
}

const char* name_of(meltsim::NeighbourSearch search) {
  if (search == meltsim::NeighbourSearch::automatic) return "auto";
  return search == meltsim::NeighbourSearch::tree ? "tree" : "grid";
}

Json solver_json(const meltsim::WorldDesc& world, const meltsim::Resolved& resolved) {
  Json json;
  json["gravity"] = echo(world.gravity);
  json["sound_speed"] = resolved.sound_speed > 0 ? Json(resolved.sound_speed) : Json("auto");
  if (world.density_error > 0 && world.sound_speed == 0) json["density_error"] = world.density_error;
  json["artificial_viscosity"] = world.artificial_viscosity;
  json["tension"] = world.tension;
  json["particle_shifting"] = world.particle_shifting;
  json["neighbour_search"] = name_of(resolved.neighbour_search);
  json["viscosity"] = keys::viscosity.at(static_cast<std::size_t>(world.viscosity));
  json["courant"] = world.courant;
  json["max_substeps"] = world.max_substeps;
  json["pieces_interval"] = world.pieces_interval;
  json["stray"] = keys::stray.at(static_cast<std::size_t>(world.stray));
  return json;
}

/// Null when nothing is set.
Json surface_json(const meltsim::SurfaceHeatDesc& surface) {
  if (surface.temperature) return {{"temperature", *surface.temperature}};
  if (surface.flux == 0 && surface.convection == 0 && surface.emissivity == 0) return {};
  return {{"flux", surface.flux},
          {"convection", surface.convection},
          {"emissivity", surface.emissivity},
          {"ambient", surface.ambient}};
}

/// A number, or the points.
Json property_json(double constant, const std::vector<meltsim::PropertyPoint>& points) {
  if (points.empty()) return constant;
  Json list = Json::array();
  for (const auto& p : points) list.push_back({p.temperature, p.value});
  return list;
}

Json heat_json(const Scene& scene) {
  const meltsim::HeatDesc& heat = scene.world.heat;
  const char* models[] = {"none", "paper", "iwasaki", "enthalpy"};
  Json json = {{"model", models[static_cast<std::size_t>(heat.model)]},
               {"time_scale", heat.time_scale},
               {"interval", heat.interval > 0 ? Json(heat.interval) : Json("auto")},
               {"max_stages", heat.max_stages},
               {"max_supersteps", heat.max_supersteps},
               {"level_tolerance", heat.level_tolerance}};
  if (const Json surface = surface_json(heat.free_surface); !surface.is_null())
    json["free_surface"] = surface;
  for (std::size_t i = 0; i < 6; ++i) {
    const Json wall = surface_json(scene.world.domain.heat[i]);
    if (!wall.is_null()) json["walls"][face_keys[i]] = wall;
  }
  for (const SceneHeatRegion& region : scene.heat_regions) {
    Json r = {{"name", region.desc.name}, {"shape", region.shape.echo}};
    if (region.desc.temperature) r["temperature"] = *region.desc.temperature;
    else r["source"] = region.desc.source;
    r["from"] = region.desc.from;
    r["until"] = echo_number(region.desc.until);
    json["regions"].push_back(r);
  }
  return json;
}

/// Null where nothing is dissolved.
Json fractions_json(const SceneFractions& fractions) {
  Json json;
  for (const auto& [name, value] : fractions) json[name] = value;
  return json;
}

Json material_json(const SceneMaterial& material) {
  const meltsim::MaterialDesc& desc = material.desc;
  Json json;
  json["density"] = property_json(desc.density, desc.density_points);
  json["viscosity"] = property_json(desc.viscosity, desc.viscosity_points);
  json["conductivity"] = property_json(desc.conductivity, desc.conductivity_points);
  json["heat_capacity"] = property_json(desc.heat_capacity, desc.heat_capacity_points);
  if (desc.diffusivity) json["diffusivity"] = *desc.diffusivity;
  json["melting_point"] = echo_number(desc.melting_point);
  json["latent_heat"] = desc.latent_heat;
  if (!material.becomes.empty()) json["becomes"] = material.becomes;
  if (desc.freezes) json["freezes"] = true;
  if (!material.dissolves_in.empty()) {
    json["dissolves_in"] = material.dissolves_in;
    json["solubility"] = property_json(desc.solubility, desc.solubility_points);
    json["diffusivity_in"] = desc.diffusivity_in;
    json["heat_of_solution"] = desc.heat_of_solution;
    if (desc.transfer_coefficient) json["transfer_coefficient"] = *desc.transfer_coefficient;
  }
  json["region_half_width"] = desc.region_half_width;
  if (desc.youngs_modulus > 0) json["youngs_modulus"] = desc.youngs_modulus;
  else json["stiffness"] = desc.stiffness;
  json["damping"] = desc.damping;
  json["friction"] = desc.friction;
  if (desc.surface_tension > 0) json["surface_tension"] = desc.surface_tension;
  if (desc.contact_angle != 90) json["contact_angle"] = desc.contact_angle;
  const bool yields = desc.yield_stress > 0 || !desc.yield_stress_points.empty();
  if (yields) json["yield_stress"] = property_json(desc.yield_stress, desc.yield_stress_points);
  if (desc.flow_index != 1) json["flow_index"] = desc.flow_index;
  if (yields || desc.flow_index != 1) json["regularisation"] = desc.regularisation;
  if (material.color) json["color"] = *material.color;
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
  json["domain"] = domain_json(scene.world.domain);
  json["particles"] = {{"spacing", scene.world.spacing}, {"support", resolved.support_radius}};
  json["time"] = time_json(scene.time);
  json["solver"] = solver_json(scene.world, resolved);
  json["heat"] = heat_json(scene);
  if (std::any_of(scene.materials.begin(), scene.materials.end(),
                  [](const SceneMaterial& m) { return !m.dissolves_in.empty(); }))
    json["solute"] = {{"time_scale", scene.world.solute.time_scale},
                      {"max_supersteps", scene.world.solute.max_supersteps}};
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
