// SPDX-License-Identifier: Apache-2.0
// domain, particles, time, solver: what scene_options.cpp has no kind of row for.
#include <fmt/format.h>

#include "failure.hpp"
#include "load_parts.hpp"
#include "scene_options.hpp"

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

}  // namespace

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
    meltsim::OutletDesc outlet;
    load_options(value, outlet_options(), outlet);
    for (const std::size_t i : face_indices(key)) domain.outlets[i] = outlet;
  }
}

void load_face_velocities(const Node& node, meltsim::DomainDesc& domain) {
  node.allow_keys(keys::faces);
  for (const auto& [key, velocity] : node.entries())
    for (const std::size_t i : face_indices(key)) domain.velocity[i] = velocity.vector("m/s");
}

void load_section(const Section& section, const Node& node, Scene& scene) {
  load_options(node, section.options(), scene);
  scene.*section.source = node.source();
}

void load_domain(const Section& section, const Node& node, Scene& scene) {
  scene.world.domain.bounded = true;
  load_section(section, node, scene);
  for (const char* corner : {"min", "max"})
    if (scene.world.domain.bounded) node.require(corner, "3 numbers [x, y, z] (m)");
}

}  // namespace runner
