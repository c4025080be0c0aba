// SPDX-License-Identifier: Apache-2.0
#include "scenes.hpp"

#include <cstdlib>
#include <cstring>

namespace meltsim_test {

Backend backend() {
  const char* name = std::getenv("MELTSIM_TEST_BACKEND");
  if (name == nullptr) name = usual_backend();
  return std::strcmp(name, "cuda") == 0 ? Backend::cuda : Backend::cpu;
}

WorldDesc describe() {
  WorldDesc d;
  d.backend = backend();
  return d;
}

Scene ice_in_water(WorldDesc desc, const IceScene& s) {
  desc.spacing = 0.2;
  desc.domain.bounded = true;
  desc.domain.max = {s.box, s.box, s.box};
  desc.heat.time_scale = s.time_scale;
  auto world = World::create(desc);
  EXPECT_TRUE(world) << world.error().message;
  Scene scene{std::move(*world), {}, {}};
  scene.water = *scene.world.add_material({});
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = s.ice_density;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = s.latent_heat;
  ice.melts_into = scene.water;
  ice.region_half_width = s.region_half_width;
  ice.freezes = s.freezes;
  scene.ice = *scene.world.add_material(ice);
  if (s.water) {
    FluidDesc fluid;
    fluid.shape = Shape::box({0, 0, 0}, {s.box, s.depth, s.box});
    fluid.material = scene.water;
    fluid.temperature = s.water_temperature;
    const auto added = scene.world.add_fluid(fluid);
    EXPECT_TRUE(added) << added.error().message;
  }
  if (s.block > 0) {
    SolidDesc block;
    block.name = "block";
    const double low = 0.8, side = 0.2 * s.block;
    block.shape = Shape::box({low, s.block_floor, low}, {low + side, s.block_floor + side, low + side});
    block.material = scene.ice;
    block.temperature = s.ice_temperature;
    block.growth = s.growth;
    block.fixed = s.fixed;
    block.motion = s.motion;
    const auto added = scene.world.add_solid(block);
    EXPECT_TRUE(added) << added.error().message;
  }
  return scene;
}

int melt(World& world, double dt, double limit) {
  int steps = 0;
  while (world.time() < limit) {
    const Status s = world.step(dt);
    EXPECT_TRUE(s) << s.error().message;
    if (!s) break;
    ++steps;
    if (steps % 10 != 0) continue;
    const StepResult r = world.synchronize();
    EXPECT_FALSE(r.halted) << r.halt_reason;
    if (r.halted || r.solid == 0) break;
  }
  return steps;
}

}  // namespace meltsim_test
