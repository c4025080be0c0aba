// SPDX-License-Identifier: Apache-2.0
// The scene of the GPU tests: a block of ice in a tank of warm water. Every stage but thermal.paper runs in
// it.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "meltsim/world.hpp"

namespace gpu_test {

using meltsim::Backend;
using meltsim::Precision;
using meltsim::World;

struct MeltingScene {
  Backend backend = Backend::cuda;
  Precision precision = Precision::single_precision;
  void* stream = nullptr;
  int side = 16;         ///< tank, in spacings
  int ice = 8;           ///< block, in spacings; 0: none
  int second_ice = 0;    ///< another block beside it, so that bodies can touch
  int half_width = 2;    ///< of regions
  double support = 2.5;  ///< in spacings
  double water_temperature = 80;
  double latent_heat = 3.34e5;
  double heat_time_scale = 2e4;
  int pieces_interval = 16;
  meltsim::HeatModel heat_model = meltsim::HeatModel::enthalpy;
  bool still = false;  ///< no gravity, blocks fixed
  bool at_rest = true;
  meltsim::NeighbourSearch search = meltsim::NeighbourSearch::automatic;
};

inline constexpr double spacing = 0.1;
inline constexpr double time_step = 1.0 / 512;  // exact, so that sums of steps are

/// For the names of tests.
inline std::string name_of(Precision p) { return p == Precision::single_precision ? "Single" : "Double"; }
inline std::string name_of(Backend b) { return b == Backend::cuda ? "Cuda" : "Cpu"; }

/// gtest's ASSERT needs a function that returns nothing; a failure here means that the test is broken.
template <class T>
T value_of(meltsim::Result<T> result) {
  if (!result) {
    ADD_FAILURE() << result.error().message;
    std::abort();
  }
  return *std::move(result);
}

inline void succeed(const meltsim::Status& status) {
  if (!status) FAIL() << status.error().message;
}

inline World make_world(const MeltingScene& scene) {
  using namespace meltsim;
  WorldDesc desc;
  desc.backend = scene.backend;
  desc.precision = scene.precision;
  desc.stream = scene.stream;
  desc.spacing = spacing;
  desc.support_radius = scene.support * spacing;
  desc.domain.bounded = true;
  const double wide = scene.side * spacing;
  desc.domain.max = {wide, wide, wide};
  desc.heat.model = scene.heat_model;
  desc.heat.time_scale = scene.heat_time_scale;
  desc.neighbour_search = scene.search;
  desc.hydrostatic_start = scene.at_rest;
  if (scene.still) {
    desc.gravity = {0, 0, 0};
    desc.sound_speed = 50;
  }
  desc.pieces_interval = scene.pieces_interval;
  World world = value_of(World::create(desc));

  MaterialDesc water;
  water.viscosity = 0.2;
  const MaterialId water_id = value_of(world.add_material(water));
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = scene.latent_heat;
  ice.melts_into = water_id;
  ice.region_half_width = scene.half_width;
  const MaterialId ice_id = value_of(world.add_material(ice));

  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {wide, 0.7 * wide, wide});
  pool.material = water_id;
  pool.temperature = scene.water_temperature;
  value_of(world.add_fluid(pool));

  if (scene.ice == 0) {
    succeed(world.prepare());
    return world;
  }
  SolidDesc block;
  const double low = (scene.side - scene.ice) / 2 * spacing, length = scene.ice * spacing;
  block.shape = Shape::box({low, low, low}, {low + length, low + length, low + length});
  block.material = ice_id;
  block.temperature = -5;
  block.fixed = scene.still;
  value_of(world.add_solid(block));
  if (scene.second_ice > 0) {
    SolidDesc second = block;
    const double s = scene.second_ice * spacing, top = low + length;
    second.shape = Shape::box({low, top, low}, {low + s, top + s, low + s});
    value_of(world.add_solid(second));
  }
  succeed(world.prepare());
  return world;
}

inline void step(World& world, int steps) {
  for (int k = 0; k < steps; ++k) succeed(world.step(time_step));
}

inline std::uint64_t hash_after(World& world, int steps) {
  step(world, steps);
  const meltsim::StepResult r = world.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  return value_of(world.state_hash());
}

}  // namespace gpu_test
