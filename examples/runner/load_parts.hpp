// SPDX-License-Identifier: Apache-2.0
// The sections of a scene, one reader each.
#pragma once

#include "scene_options.hpp"

namespace runner {

/// Faces that a key like "-x" or "x" names, in the order of the library.
std::vector<std::size_t> face_indices(const std::string& key);
void load_section(const Section& section, const Node& node, Scene& scene);
void load_domain(const Section& section, const Node& node, Scene& scene);
void load_particles(const Section& section, const Node& node, Scene& scene);
void load_walls(const Node& node, meltsim::DomainDesc& domain);
void load_outlets(const Node& node, meltsim::DomainDesc& domain);
void load_face_velocities(const Node& node, meltsim::DomainDesc& domain);
void load_wall_heat(const Node& node, meltsim::DomainDesc& domain);
void load_heat_regions(const Node& node, Scene& scene);
Json heat_regions_json(const Scene& scene);
/// In an order in which `becomes` and `dissolves_in` are already known.
void load_materials(const Node& node, Scene& scene);
void load_fluids(const Node& node, Scene& scene);
void load_bodies(const Node& node, Scene& scene);
void load_emitters(const Node& node, Scene& scene);
void load_force_fields(const Node& node, Scene& scene);
void load_probes(const Node& node, Scene& scene);
void load_output(const Node& node, Scene& scene);
void load_trade(const Node& node, Scene& scene);  ///< names are checked once the World is there

}  // namespace runner
