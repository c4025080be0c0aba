// SPDX-License-Identifier: Apache-2.0
// custom_stage.cpp on the GPU: the wind is a kernel of the host's, launched on the World's stream.
#include <cstdio>

#include "meltsim/cuda_interop.hpp"
#include "meltsim/meltsim.hpp"

namespace {

__global__ void blow(meltsim::DeviceSpan<meltsim::Vec4<float>> position,
                     meltsim::DeviceSpan<meltsim::Vec3<float>> acceleration, const std::uint32_t* tag,
                     float above, float wind) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < position.size && meltsim::is_fluid(tag[i]) && position.data[i].y > above)
    acceleration.data[i].x += wind;
}

void wind_stage(const meltsim::StageContext& context, void*) {
  namespace interop = meltsim::cuda_interop;
  const auto position = interop::position<float>(context);
  const auto acceleration = interop::acceleration<float>(context);
  if (position.data == nullptr || acceleration.data == nullptr) return;
  const unsigned threads = 128, blocks = static_cast<unsigned>((position.size + threads - 1) / threads);
  blow<<<blocks, threads, 0, interop::stream(context)>>>(position, acceleration, context.tag, 0.2f, 3.0f);
}

}  // namespace

int main() {
  using namespace meltsim;
  const auto fail = [](const Error& e) {
    std::fprintf(stderr, "%s\n", e.message.c_str());
    return 1;
  };

  WorldDesc desc;
  desc.backend = Backend::cuda;
  desc.spacing = 0.05;
  desc.domain.bounded = true;
  desc.domain.max = {1, 1, 0.5};
  auto world = World::create(desc);
  if (!world) return fail(world.error());  // for example: no GPU

  auto water = world->add_material({});
  if (!water) return fail(water.error());
  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {1, 0.3, 0.5});
  pool.material = *water;
  if (auto added = world->add_fluid(pool); !added) return fail(added.error());

  CustomStage stage;
  stage.name = "wind";
  stage.run = wind_stage;
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
