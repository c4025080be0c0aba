// SPDX-License-Identifier: Apache-2.0
// domain, particles, time, solver.
#include <fmt/format.h>

#include "failure.hpp"
#include "load_parts.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

/// "-x" is one face, "x" is both faces of the axis. Order of the library: -x, +x, -y, +y, -z, +z.
std::vector<std::size_t> face_indices(const std::string& key) {
  const std::size_t axis = static_cast<std::size_t>(key.back() - 'x');
  if (key.front() == '-') return {2 * axis};
  if (key.front() == '+') return {2 * axis + 1};
  return {2 * axis, 2 * axis + 1};
}

namespace {

using meltsim::Face;

Face face_of(const std::string& word) {
  if (word == "open") return Face::open;
  return word == "periodic" ? Face::periodic : Face::wall;
}

void load_walls(const Node& node, meltsim::DomainDesc& domain) {
  if (!node.is_mapping()) {
    const std::string word = node.choice({"box", "open", "none", "a mapping of faces like {x: periodic}"});
    domain.bounded = word != "none";
    if (word == "open") domain.faces.fill(Face::open);
    return;
  }
  node.allow_keys(keys::faces);
  for (const auto& [key, value] : node.entries()) {
    const Face face = face_of(value.choice(keys::face));
    for (const std::size_t i : face_indices(key)) domain.faces[i] = face;
    const bool one_side = key.size() == 2;
    if (one_side && face == Face::periodic) {
      value.fail(fmt::format("both faces of an axis are periodic or none; write {}: periodic", key.back()));
    }
  }
}

void load_outlets(const Node& node, meltsim::DomainDesc& domain) {
  node.allow_keys(keys::faces);
  for (const auto& [key, value] : node.entries()) {
    value.allow_keys(keys::outlet);
    meltsim::OutletDesc outlet;
    if (const auto level = value.find("level")) outlet.level = level->number("m");
    if (const auto speed = value.find("speed")) outlet.speed = speed->positive("m/s");
    for (const std::size_t i : face_indices(key)) domain.outlets[i] = outlet;
  }
}

}  // namespace

void load_domain(const Node& node, Scene& scene) {
  node.allow_keys(keys::domain);
  scene.domain = node.source();
  meltsim::DomainDesc& domain = scene.world.domain;
  domain.bounded = true;
  if (const auto walls = node.find("walls")) load_walls(*walls, domain);
  if (domain.bounded) {
    domain.min = node.require("min", "3 numbers [x, y, z] (m)").vector("m");
    domain.max = node.require("max", "3 numbers [x, y, z] (m)").vector("m");
  } else {
    for (const char* key : {"min", "max"}) {
      if (const auto corner = node.find(key))
        corner->fail("walls: none has no bounds; remove this or the walls");
    }
  }
  if (const auto value = node.find("outlets")) load_outlets(*value, domain);
  if (const auto value = node.find("no_slip")) domain.no_slip = value->boolean();
  if (const auto value = node.find("friction")) domain.friction = value->number("Coulomb coefficient");
  if (const auto value = node.find("contact_angle")) domain.contact_angle = value->number("degrees");
  if (const auto value = node.find("velocity")) {
    value->allow_keys(keys::faces);
    for (const auto& [key, velocity] : value->entries()) {
      for (const std::size_t i : face_indices(key)) domain.velocity[i] = velocity.vector("m/s");
    }
  }
}

void load_particles(const Node& node, Scene& scene) {
  node.allow_keys(keys::particles);
  scene.particles = node.source();
  scene.world.spacing = node.require("spacing", "the distance of particles (m)").positive("m");
  const auto support = node.find("support");
  if (support && !support->is_word("auto")) scene.world.support_radius = support->positive("m");
}

void load_time(const Node& node, Scene& scene) {
  node.allow_keys(keys::time);
  scene.time_source = node.source();
  SceneTime& time = scene.time;
  if (const auto value = node.find("dt")) {
    if (!value->is_word("auto")) time.dt = value->positive("s");
    time.dt_where = value->where();
  }
  if (const auto value = node.find("stepping")) time.adaptive = value->choice(keys::stepping) == "adaptive";
  if (const auto value = node.find("fps")) time.fps = value->positive("frames per simulated second");
  if (const auto value = node.find("end")) {
    time.end = value->number("s");
    if (time.end < 0) value->fail(fmt::format("expected 0 or more (s), got {}", value->found()));
  }
  if (const auto value = node.find("end_when")) {
    time.until_melted = value->choice(keys::end_when) == "melted";
    time.end_when_where = value->where();
  }
  if (const auto value = node.find("tail")) {
    time.tail = value->number("s");
    if (time.tail < 0) value->fail(fmt::format("expected 0 or more (s), got {}", value->found()));
  }
}

void load_solver(const Node& node, Scene& scene) {
  node.allow_keys(keys::solver);
  scene.solver = node.source();
  meltsim::WorldDesc& world = scene.world;
  if (const auto value = node.find("gravity")) world.gravity = value->vector("m/s^2");
  if (const auto value = node.find("sound_speed")) {
    if (!value->is_word("auto")) world.sound_speed = value->positive("m/s");
  }
  if (const auto value = node.find("density_error")) {
    world.density_error = value->positive("compression");
    if (world.sound_speed > 0) value->fail("sound_speed decides; drop one of them");
  }
  if (const auto value = node.find("artificial_viscosity")) {
    world.artificial_viscosity = value->number("Monaghan's alpha");
  }
  if (const auto value = node.find("tension")) world.tension = value->boolean();
  if (const auto value = node.find("particle_shifting")) world.particle_shifting = value->boolean();
  if (const auto value = node.find("neighbour_search")) {
    const std::string search = value->choice(keys::neighbour_search);
    if (search == "grid" || search == "verlet") world.neighbour_search = meltsim::NeighbourSearch::grid;
    if (search == "tree") world.neighbour_search = meltsim::NeighbourSearch::tree;
  }
  if (const auto value = node.find("viscosity")) {
    const std::string how = value->choice(keys::viscosity);
    if (how == "explicit") world.viscosity = meltsim::Viscosity::explicit_;
    if (how == "implicit") world.viscosity = meltsim::Viscosity::implicit;
  }
  if (const auto value = node.find("courant")) world.courant = value->positive("Courant number");
  if (const auto value = node.find("max_substeps")) world.max_substeps = value->small_integer();
  if (const auto value = node.find("pieces_interval")) world.pieces_interval = value->small_integer();
  if (const auto value = node.find("stray"))
    world.stray = value->choice(keys::stray) == "halt" ? meltsim::Stray::halt : meltsim::Stray::remove;
}

}  // namespace runner
