// SPDX-License-Identifier: Apache-2.0
// A force the library does not have: wind that blows along x above a height. The host's stage runs inside
// every sub-step, after the built-in forces have been added up and before they move anything.
#include <cstdio>

#include "meltsim/meltsim.hpp"

namespace {

struct Wind {
  double acceleration = 3;  // [m/s^2]
  double above = 0.2;       // [m]; stored positions are relative to World::resolved().origin
};

// Pointers are typed by precision, so the work is a template and the stage picks one.
template <class T>
void blow(const meltsim::StageContext& context, const Wind& wind) {
  const auto* position = static_cast<const meltsim::Vec4<T>*>(context.position);
  auto* acceleration = static_cast<meltsim::Vec3<T>*>(context.acceleration);
  for (std::uint64_t i = 0; i < context.particles; ++i)
    if (meltsim::is_fluid(context.tag[i]) && position[i].y > static_cast<T>(wind.above))
      acceleration[i].x += static_cast<T>(wind.acceleration);
}

void wind_stage(const meltsim::StageContext& context, void* user) {
  const Wind& wind = *static_cast<const Wind*>(user);
  if (context.precision == meltsim::Precision::double_precision) blow<double>(context, wind);
  else blow<float>(context, wind);
}

}  // namespace

int main() {
  using namespace meltsim;
  const auto fail = [](const Error& e) {
    std::fprintf(stderr, "%s\n", e.message.c_str());
    return 1;
  };

  WorldDesc desc;
  desc.spacing = 0.05;
  desc.domain.bounded = true;
  desc.domain.max = {1, 1, 0.5};
  auto world = World::create(desc);
  if (!world) return fail(world.error());
  if (world->backend() == Backend::cuda) {
    // The pointers are device memory there: the stage would launch a kernel of the host's on context.stream.
    std::printf(
        "a custom stage on CUDA needs a kernel; this example shows the CPU. Set desc.backend = cpu.\n");
    return 0;
  }

  auto water = world->add_material({});
  if (!water) return fail(water.error());
  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {1, 0.3, 0.5});
  pool.material = *water;
  if (auto added = world->add_fluid(pool); !added) return fail(added.error());

  Wind wind;
  wind.above -= world->resolved().origin.y;
  CustomStage stage;
  stage.name = "wind";
  stage.run = wind_stage;
  stage.user = &wind;  // must live as long as the stage
  stage.reads = {"position", "tag"};
  stage.writes = {"acceleration"};
  if (Status s = world->scheduler().insert_after("sph.forces", stage); !s) return fail(s.error());

  for (int frame = 0; frame < 10; ++frame) {
    if (Status s = world->step(0.02); !s) return fail(s.error());
    auto totals = world->totals();
    if (!totals) return fail(totals.error());
    std::printf("t = %.2f s: momentum along x %.3f kg m/s\n", world->time(), totals->momentum.x);
  }
  return 0;
}
