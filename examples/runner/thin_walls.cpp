// SPDX-License-Identifier: Apache-2.0
#include "thin_walls.hpp"

#include <fmt/format.h>

#include "cells.hpp"
#include "expect.hpp"

namespace runner {

namespace {

// Bodies of fewer sites hold nothing, and a wire or a crumb among them is no wall.
constexpr std::size_t least_sites = 30;
constexpr double least_thin = 1.0 / 3;
// Of the thin sites as many hold on to the next by an edge alone; flat walls along the lattice, none of whose do, do not leak at rest.
constexpr double least_diagonal = 0.1;
// Liquid so near touches a wall [cells].
constexpr int wet_reach = 2;

using Sites = std::vector<std::uint64_t>;

struct Body {
  std::vector<Cell> cells;
  Sites keys;  ///< sorted
};

Cell moved(Cell cell, std::size_t axis, int by) {
  cell[axis] += by;
  return cell;
}

/// Along some axis there is no site of the body on either side.
bool is_thin(const Body& body, const Cell& cell) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!holds(body.keys, moved(cell, axis, -1)) && !holds(body.keys, moved(cell, axis, 1))) return true;
  return false;
}

/// It shares an edge with a site of the body, and neither of the two cells between them is one: liquid passes there.
bool is_diagonal(const Body& body, const Cell& cell) {
  for (std::size_t a = 0; a < 3; ++a)
    for (const int along : {-1, 1})
      for (const int across : {-1, 1}) {
        const Cell one = moved(cell, a, along), other = moved(cell, (a + 1) % 3, across);
        if (holds(body.keys, moved(one, (a + 1) % 3, across)) && !holds(body.keys, one) &&
            !holds(body.keys, other))
          return true;
      }
  return false;
}

bool is_wet(const Sites& liquid, const Cell& cell) {
  for (int x = -wet_reach; x <= wet_reach; ++x)
    for (int y = -wet_reach; y <= wet_reach; ++y)
      for (int z = -wet_reach; z <= wet_reach; ++z)
        if (holds(liquid, {cell[0] + x, cell[1] + y, cell[2] + z})) return true;
  return false;
}

/// The share of a body's sites that are one thick, where its walls can leak; else 0.
double leaky_share(const Body& body, const Sites& liquid, bool wet_later) {
  std::size_t thin = 0, diagonal = 0;
  bool wet = wet_later;
  for (const Cell& cell : body.cells) {
    if (!is_thin(body, cell)) continue;
    ++thin;
    if (!is_diagonal(body, cell)) continue;
    ++diagonal;
    wet = wet || is_wet(liquid, cell);
  }
  const double share = static_cast<double>(thin) / static_cast<double>(body.cells.size());
  const bool walls = thin > least_sites && share > least_thin;
  return walls && wet && static_cast<double>(diagonal) > least_diagonal * static_cast<double>(thin) ? share
                                                                                                    : 0;
}

}  // namespace

std::vector<std::string> thin_walls(const Scene& scene, Built& built) {
  std::vector<std::string> warnings;
  if (scene.bodies.empty() || (scene.fluids.empty() && scene.emitters.empty())) return warnings;
  std::vector<Body> bodies(scene.bodies.size());
  Sites liquid;
  const meltsim::ParticleData now = expect(built.world.particles());
  for (std::size_t i = 0; i < now.id.size(); ++i) {
    const Cell cell = cell_of(scene, now.position[i]);
    if (meltsim::is_fluid(now.tag[i])) liquid.push_back(key_of(cell));
    if (!meltsim::is_solid(now.tag[i])) continue;
    Body& body = bodies.at(meltsim::body_of(now.tag[i]) - 1);
    body.cells.push_back(cell);
    body.keys.push_back(key_of(cell));
  }
  std::sort(liquid.begin(), liquid.end());
  const double dx = scene.world.spacing;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].cells.size() <= least_sites) continue;
    std::sort(bodies[i].keys.begin(), bodies[i].keys.end());
    const double share = leaky_share(bodies[i], liquid, !scene.emitters.empty());
    if (!(share > 0)) continue;
    const SceneBody& body = scene.bodies[i];
    warnings.push_back(
        fmt::format("{}: {}.shape: {:.0f} % of the sites of \"{}\" are one thick, in walls that are curved "
                    "or turned against "
                    "the lattice: liquid leaks through; make its walls 1.5 to 2 spacings thick ({:.3g} m or "
                    "more), or use a "
                    "particles.spacing of {:.3g} or less",
                    body.source.where, body.source.path, 100 * share, body.desc.name, 2 * dx, dx / 2));
  }
  return warnings;
}

}  // namespace runner
