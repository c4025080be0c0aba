// SPDX-License-Identifier: Apache-2.0
// Whether the package links and runs: a block falls for a tenth of a second.
#include <cmath>
#include <cstdio>

#include "meltsim/meltsim.hpp"

int main() {
  meltsim::WorldDesc desc;
  desc.backend = meltsim::Backend::cpu;
  desc.spacing = 0.1;
  desc.heat.model = meltsim::HeatModel::none;
  auto world = meltsim::World::create(desc);
  if (!world) return 1;
  meltsim::SolidDesc block;
  block.material = *world->add_material({});
  block.shape = meltsim::Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  if (!world->add_solid(block) || !world->step(0.1)) return 1;
  const auto pieces = world->pieces();
  if (!pieces || std::fabs(pieces->front().velocity.y + 0.981) > 1e-4) return 1;
  std::printf("meltsim %s: %.3f m/s\n", meltsim::build_info().version.c_str(), pieces->front().velocity.y);
  return 0;
}
