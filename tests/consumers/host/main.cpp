// SPDX-License-Identifier: Apache-2.0
// A host program as others write it: public headers only, no macros, no CUDA. Water and ice, ten steps.
#include <cmath>
#include <cstdio>

#include "meltsim/meltsim.hpp"

namespace {
int fail(const meltsim::Error& e) {
  std::fprintf(stderr, "host: %s\n", e.message.c_str());
  return 1;
}
}  // namespace

int main() {
  using namespace meltsim;
  WorldDesc desc;
  desc.backend = Backend::cpu;  // a consumer test must not depend on the machine's GPU
  desc.spacing = 0.1;
  desc.domain.bounded = true;
  desc.domain.max = {1, 1, 1};
  auto world = World::create(desc);
  if (!world) return fail(world.error());

  auto water = world->add_material({});
  if (!water) return fail(water.error());
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.melting_point = 0;
  ice.latent_heat = 3.34e5;
  ice.melts_into = *water;
  auto ice_id = world->add_material(ice);
  if (!ice_id) return fail(ice_id.error());

  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {1, 0.3, 1});
  pool.material = *water;
  auto filled = world->add_fluid(pool);
  if (!filled) return fail(filled.error());
  SolidDesc block;
  block.shape = Shape::box({0.3, 0.4, 0.3}, {0.7, 0.7, 0.7});
  block.material = *ice_id;
  block.temperature = -10;
  auto body = world->add_solid(block);
  if (!body) return fail(body.error());

  const auto before = world->totals();
  if (!before) return fail(before.error());
  for (int i = 0; i < 10; ++i)
    if (Status s = world->step(0.001); !s) return fail(s.error());
  const StepResult result = world->synchronize();
  const auto after = world->totals();
  if (!after) return fail(after.error());

  std::printf("meltsim %s: %llu liquid, %llu solid, mass %.3f kg, momentum y %.3f kg m/s, t = %.3f s\n",
              build_info().version.c_str(), static_cast<unsigned long long>(after->fluid),
              static_cast<unsigned long long>(after->solid), after->mass, after->momentum.y, result.time);
  // 300 liquid and 48 solid lattice points of 0.1^3 m^3.
  const bool plausible = after->fluid == 300 && after->solid == 48 && !result.halted &&
                         std::abs(after->mass - (300 * 1.0 + 48 * 0.917)) < 1e-3 &&
                         std::abs(after->mass - before->mass) < 1e-9 && std::abs(result.time - 0.01) < 1e-9;
  if (!plausible) std::fprintf(stderr, "host: these totals are wrong\n");
  return plausible ? 0 : 1;
}
