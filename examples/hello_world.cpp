// SPDX-License-Identifier: Apache-2.0
// The smallest melting scene: an ice cube falls into a tray of warm water.
#include <cstdio>

#include "meltsim/meltsim.hpp"

int main() {
  using namespace meltsim;

  // Errors are values: a Result holds the thing asked for or a message that names field, value and fix.
  const auto fail = [](const Error& e) {
    std::fprintf(stderr, "%s\n", e.message.c_str());
    return 1;
  };

  WorldDesc desc;
  desc.spacing = 0.05;  // [m] between particles; everything else has a default or is derived from it
  desc.domain.bounded = true;
  desc.domain.min = {0, 0, 0};
  desc.domain.max = {1, 1, 1};
  desc.heat.time_scale = 50000;  // a time lapse: melting takes hours, falling a second
  auto world = World::create(desc);
  if (!world) return fail(world.error());

  MaterialDesc water;  // the defaults are water
  water.viscosity = 0.2;
  auto water_id = world->add_material(water);
  if (!water_id) return fail(water_id.error());

  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = 3.34e5;
  ice.melts_into = *water_id;
  auto ice_id = world->add_material(ice);
  if (!ice_id) return fail(ice_id.error());

  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {1, 0.3, 1});
  pool.material = *water_id;
  pool.temperature = 60;
  auto filled = world->add_fluid(pool);
  if (!filled) return fail(filled.error());

  SolidDesc block;
  block.name = "block";
  block.shape = Shape::box({0.35, 0.4, 0.35}, {0.65, 0.7, 0.65});
  block.material = *ice_id;
  block.temperature = -5;
  auto body = world->add_solid(block);
  if (!body) return fail(body.error());

  std::printf("runs on %s\n", world->resolved().backend == Backend::cuda ? "CUDA" : "the CPU");
  for (int frame = 0; frame < 20; ++frame) {
    // Enqueues only. Sub-steps keep it stable, whatever dt is.
    if (Status s = world->step(0.05); !s) return fail(s.error());
    const StepResult r = world->synchronize();  // waits
    if (r.halted) return fail({ErrorCode::halted, r.halt_reason});
    std::printf("t = %.2f s: %llu liquid, %llu solid, %llu melted so far\n", r.time,
                static_cast<unsigned long long>(r.fluid), static_cast<unsigned long long>(r.solid),
                static_cast<unsigned long long>(r.melted));
  }
  return 0;
}
