// SPDX-License-Identifier: Apache-2.0
// Scene to World.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meltsim/world.hpp"
#include "options.hpp"
#include "probes.hpp"
#include "scene.hpp"

namespace runner {

struct Built {
  meltsim::World world;
  std::vector<std::uint64_t> fluid_particles;  ///< per fluid of the scene, before bodies carve theirs away
  std::vector<std::string> materials;          ///< by the index in a particle's tag
  std::vector<meltsim::MaterialId> material_ids;
  std::vector<meltsim::BodyId> body_ids;
  std::vector<bool> body_melts;           ///< per body of the scene: it melts or dissolves
  bool melts = false, dissolves = false;  ///< some body does
  std::vector<meltsim::ForceFieldId> force_field_ids;
  std::vector<meltsim::EmitterId> emitter_ids;
  std::vector<meltsim::HeatRegionId> heat_region_ids;
  std::uint64_t meltable = 0;     ///< solid particles that can melt or dissolve
  ProbeGroups probes;             ///< once add_probes() was called; the World of a viewer has none
  std::uint64_t start_bytes = 0;  ///< memory of the World with its probes, before the first step
  meltsim::Settled settled;       ///< how its liquid came to rest, where the scene asks for it
};

/// The keys of the scene that make its bodies go sooner.
const char* pace_keys(const Built& built);

/// Builds and prepares the world. Failures carry the place in the scene.
Built build_world(const Scene& scene, const MachineOptions& machine);

/// A warning for every material whose bodies are softer than its youngs_modulus asks for.
std::vector<std::string> softer_than_asked(Built& built);

/// The density_error at which a derived sound speed is `sound_factor` times as large.
double error_at(double density_error, double sound_factor);

/// "cpu, 2 threads (no usable CUDA device)": what was chosen and why.
std::string backend_text(meltsim::World& world);
/// "1.5 MB for the World", of `start_bytes`.
std::string memory_text(const Built& built);
const char* backend_name(meltsim::Backend backend);

}  // namespace runner
