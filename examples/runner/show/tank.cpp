// SPDX-License-Identifier: Apache-2.0
#include "show/tank.hpp"

#include <cstddef>

namespace runner {

using meltsim::Vec3d;

double tank_width(const Scene& scene) {
  constexpr double share = 0.0035;  // of the diagonal: thin enough to look past
  const meltsim::DomainDesc& domain = scene.world.domain;
  return domain.bounded ? share * length(domain.max - domain.min) : 0;
}

std::vector<Bar> tank_bars(const Scene& scene, const Vec3d& eye) {
  const meltsim::DomainDesc& domain = scene.world.domain;
  std::vector<Bar> bars;
  if (!domain.bounded) return bars;
  const double width = tank_width(scene), from[3] = {domain.min.x, domain.min.y, domain.min.z},
               to[3] = {domain.max.x, domain.max.y, domain.max.z}, seen_from[3] = {eye.x, eye.y, eye.z};
  const auto is_wall = [&](std::size_t axis, std::size_t side) {
    return domain.faces[2 * axis + side] == meltsim::Face::wall;
  };
  const auto is_turned_to_eye = [&](std::size_t axis, std::size_t side) {
    return side == 0 ? seen_from[axis] < from[axis] : seen_from[axis] > to[axis];
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const std::size_t at_u = corner & 1, at_v = corner >> 1;
      if (!is_wall(u, at_u) && !is_wall(v, at_v)) continue;
      if (is_turned_to_eye(u, at_u) && is_turned_to_eye(v, at_v)) continue;
      double low[3], high[3];
      low[axis] = from[axis] - width;
      high[axis] = to[axis] + width;
      for (const auto& [other, side] : {std::pair{u, at_u}, std::pair{v, at_v}}) {
        low[other] = side == 0 ? from[other] - width : to[other];
        high[other] = low[other] + width;
      }
      bars.push_back({{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
    }
  }
  return bars;
}

}  // namespace runner
