// SPDX-License-Identifier: Apache-2.0
// The sections of a scene, one reader each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "scene_options.hpp"

namespace runner {

/// Names those of a list that have none: the kind and their place in the list, or the next number that no other has.
template <class Item>
void number_names(std::vector<Item>& items, const char* kind) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!items[i].desc.name.empty()) continue;
    std::size_t number = i + 1;
    const auto is_taken = [&](const Item& other) { return other.desc.name == kind + std::to_string(number); };
    while (std::any_of(items.begin(), items.end(), is_taken)) ++number;
    items[i].desc.name = kind + std::to_string(number);
  }
}

/// Faces that a key like "-x" or "x" names, in the order of the library.
std::vector<std::size_t> face_indices(const std::string& key);
void load_section(const Section& section, const Node& node, Scene& scene);
void load_domain(const Section& section, const Node& node, Scene& scene);
void load_walls(const Node& node, meltsim::DomainDesc& domain);
void load_outlets(const Node& node, meltsim::DomainDesc& domain);
void load_face_velocities(const Node& node, meltsim::DomainDesc& domain);
void load_wall_heat(const Node& node, meltsim::DomainDesc& domain);
void load_heat_regions(const Node& node, Scene& scene);
/// In an order in which `becomes` and `dissolves_in` are already known.
void load_materials(const Node& node, Scene& scene);
void load_fluids(const Node& node, Scene& scene);
void load_bodies(const Node& node, Scene& scene);
void load_emitters(const Node& node, Scene& scene);
void load_nozzle(const Node& node, meltsim::EmitterDesc& desc);
void load_force_fields(const Node& node, Scene& scene);
void load_probes(const Node& node, Scene& scene);
void take_default_fields(const Node& item, SceneProbe& probe);
/// A part of `output`: what is given of its keys.
void load_wish(const Node& node, const Options<Json>& options, Json& wish);
void load_surface_wish(const Node& node, Scene& scene);
void load_camera(const Node& node, Json& camera);
/// Parts of `trade`; names are checked once the World is there.
void load_observe(const Node& node, Scene& scene);
void load_exact(const Node& node, Scene& scene);
Json exact_json(const Scene& scene);

}  // namespace runner
