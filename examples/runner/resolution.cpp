// SPDX-License-Identifier: Apache-2.0
#include "resolution.hpp"

#include <algorithm>

namespace runner {

void apply_resolution(Scene& scene, double scale, Quality quality) {
  double factor = scale;
  if (quality == Quality::draft) factor *= 0.75;
  if (quality == Quality::accurate) factor *= 1.25;
  meltsim::WorldDesc& world = scene.world;
  world.spacing /= factor;
  // The support keeps its ratio to the spacing, or the neighbour count would change with the resolution.
  world.support_radius /= factor;
  if (quality == Quality::draft) world.support_radius = 2 * world.spacing;
  if (quality == Quality::accurate) world.courant = std::min(world.courant, 0.25);
  if (scene.output.surface.contains("cell")) {
    scene.output.surface["cell"] = scene.output.surface["cell"].get<double>() / factor;
  }
}

}  // namespace runner
