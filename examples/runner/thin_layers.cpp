// SPDX-License-Identifier: Apache-2.0
#include "thin_layers.hpp"

#include <fmt/format.h>

#include <map>

#include "cells.hpp"
#include "expect.hpp"

namespace runner {

namespace {

// Below this ratio of conductivities a layer passes less than some per cent too much.
constexpr double least_ratio = 5;
// Of the sites of a body so many are between others, or it is no layer.
constexpr double least_share = 1.0 / 3;

/// The cells of every body, the body of every cell (from 1 on), and what each conducts [W/(m K)].
struct Places {
  std::vector<std::vector<Cell>> cells;
  std::map<std::uint64_t, std::uint32_t> body;
  std::vector<double> conducts;

  /// The other body beside a cell; 0: none.
  std::uint32_t beside(Cell cell, std::size_t axis, int by, std::uint32_t own) const {
    cell[axis] += by;
    const auto found = body.find(key_of(cell));
    return found == body.end() || found->second == own ? 0 : found->second;
  }
};

Places places_of(const Scene& scene, Built& built) {
  Places p;
  p.cells.resize(scene.bodies.size());
  p.conducts.resize(scene.bodies.size(), 0);
  const meltsim::ParticleData now = expect(built.world.particles());
  for (std::size_t i = 0; i < now.id.size(); ++i) {
    if (!meltsim::is_solid(now.tag[i])) continue;
    const std::uint32_t body = meltsim::body_of(now.tag[i]);
    const Cell cell = cell_of(scene, now.position[i]);
    p.body[key_of(cell)] = body;
    if (p.cells.at(body - 1).empty()) {
      const auto m = built.world.material(built.material_ids.at(meltsim::material_of(now.tag[i])));
      p.conducts.at(body - 1) =
          m.conductivity_points.empty() ? m.conductivity : m.conductivity_points.front().value;
    }
    p.cells.at(body - 1).push_back(cell);
  }
  return p;
}

/// How many times as well as it the bodies on both sides of a layer conduct, at least; 0 of what is none.
double layer_ratio(const Places& p, std::size_t b) {
  const auto own = static_cast<std::uint32_t>(b + 1);
  std::size_t between = 0;
  double least = meltsim::infinity;
  const auto ratio_along = [&](const Cell& cell, std::size_t axis) {
    const std::uint32_t low = p.beside(cell, axis, -1, own), high = p.beside(cell, axis, 1, own);
    return low == 0 || high == 0 ? 0 : std::min(p.conducts[low - 1], p.conducts[high - 1]) / p.conducts[b];
  };
  for (const Cell& cell : p.cells[b]) {
    const double ratio = std::max({ratio_along(cell, 0), ratio_along(cell, 1), ratio_along(cell, 2)});
    if (ratio < least_ratio) continue;
    least = std::min(least, ratio);
    ++between;
  }
  return static_cast<double>(between) > least_share * static_cast<double>(p.cells[b].size()) ? least : 0;
}

}  // namespace

std::vector<std::string> thin_layers(const Scene& scene, Built& built) {
  std::vector<std::string> warnings;
  const meltsim::HeatDesc& heat = scene.world.heat;
  if (scene.bodies.size() < 3 || heat.model == meltsim::HeatModel::none || !(heat.time_scale > 0))
    return warnings;
  const Places places = places_of(scene, built);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const double ratio = layer_ratio(places, b);
    if (!(ratio > 0)) continue;
    const SceneBody& body = scene.bodies[b];
    warnings.push_back(fmt::format(
        "{}: {}.shape: \"{}\" is one spacing thick between bodies that conduct {:.0f} times as well: these "
        "reach each other across it, so that more heat passes than it would let through, {}; make it two "
        "spacings thick ({:.3g} m), with twice its conductivity where its resistance is to stay",
        body.source.where, body.source.path, body.desc.name, ratio,
        ratio < 100 ? "1.1 times as much at a ratio of 10, 2.6 times at 100"
                    : "2.6 times as much at a ratio of 100, 19 times at 1000",
        2 * scene.world.spacing));
  }
  return warnings;
}

}  // namespace runner
