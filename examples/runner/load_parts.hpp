// SPDX-License-Identifier: Apache-2.0
// The sections of a scene, one reader each.
#pragma once

#include "scene.hpp"

namespace runner {

/// Faces that a key like "-x" or "x" names, in the order of the library.
std::vector<std::size_t> face_indices(const std::string& key);
void load_domain(const Node& node, Scene& scene);
void load_particles(const Node& node, Scene& scene);
void load_time(const Node& node, Scene& scene);
void load_solver(const Node& node, Scene& scene);
void load_heat(const Node& node, Scene& scene);
void load_solute(const Node& node, Scene& scene);
/// In an order in which `becomes` and `dissolves_in` are already known.
void load_materials(const Node& node, Scene& scene);
void load_fluids(const Node& node, Scene& scene);
void load_bodies(const Node& node, Scene& scene);
void load_emitters(const Node& node, Scene& scene);
void load_probes(const Node& node, Scene& scene);
void load_output(const Node& node, Scene& scene);
void load_trade(const Node& node, Scene& scene);  ///< names are checked once the World is there

}  // namespace runner
