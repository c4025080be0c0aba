// SPDX-License-Identifier: Apache-2.0
#include "enclosed_liquid.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>

#include "cells.hpp"
#include "expect.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

// What lies in nooks between bodies and in their dents is less.
constexpr std::size_t least_enclosed = 27;
// Cells looked at: scenes of more are not asked, so that nobody waits for it.
constexpr double most_cells = 5e7;

/// Cells around all particles, with one more on every side: from there all is open.
class Grid {
 public:
  explicit Grid(const std::vector<Cell>& cells) {
    low_ = cells.front();
    Cell high = low_;
    for (const Cell& c : cells)
      for (std::size_t a = 0; a < 3; ++a)
        low_[a] = std::min(low_[a], c[a]), high[a] = std::max(high[a], c[a]);
    for (std::size_t a = 0; a < 3; ++a) low_[a] -= 1, size_[a] = high[a] - low_[a] + 2;
    if (count() <= most_cells)
      body_.assign(static_cast<std::size_t>(count()), 0), open_.assign(body_.size(), false);
  }
  bool fits() const { return !body_.empty(); }
  /// body: from 1 on.
  void put_solid(const Cell& cell, std::uint32_t body) { body_[index(cell)] = body; }
  bool is_open(const Cell& cell) const { return open_[index(cell)]; }

  /// From outside as far as no solid is in the way.
  void flood() {
    std::vector<std::size_t> left{0};
    open_[0] = true;
    while (!left.empty()) {
      const std::size_t at = left.back();
      left.pop_back();
      visit_neighbours(at, [&](std::size_t next) {
        if (open_[next] || body_[next] != 0) return;
        open_[next] = true;
        left.push_back(next);
      });
    }
  }

  /// The body that bounds the closed cells around a cell most; 0: none does. Those cells count as seen, `found` is called with each.
  template <class Found>
  std::uint32_t wall_around(const Cell& cell, const Found& found) {
    std::map<std::uint32_t, std::size_t> walls;
    std::vector<std::size_t> left{index(cell)};
    open_[left.back()] = true;
    while (!left.empty()) {
      const std::size_t at = left.back();
      left.pop_back();
      found(at);
      visit_neighbours(at, [&](std::size_t next) {
        if (body_[next] != 0) ++walls[body_[next]];
        if (open_[next] || body_[next] != 0) return;
        open_[next] = true;
        left.push_back(next);
      });
    }
    const auto most = std::max_element(walls.begin(), walls.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return most == walls.end() ? 0 : most->first;
  }

  std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>(((c[0] - low_[0]) * size_[1] + c[1] - low_[1]) * size_[2] + c[2] -
                                    low_[2]);
  }

 private:
  double count() const {
    return static_cast<double>(size_[0]) * static_cast<double>(size_[1]) * static_cast<double>(size_[2]);
  }
  template <class Visit>
  void visit_neighbours(std::size_t at, const Visit& visit) const {
    const std::size_t steps[] = {static_cast<std::size_t>(size_[1] * size_[2]),
                                 static_cast<std::size_t>(size_[2]), 1};
    const auto all = static_cast<std::int64_t>(at);
    const std::int64_t place[] = {all / (size_[1] * size_[2]), all / size_[2] % size_[1], all % size_[2]};
    for (std::size_t a = 0; a < 3; ++a) {
      if (place[a] > 0) visit(at - steps[a]);
      if (place[a] + 1 < size_[a]) visit(at + steps[a]);
    }
  }

  Cell low_{}, size_{};
  std::vector<std::uint32_t> body_;
  std::vector<bool> open_;
};

/// Particles of a liquid of the scene in the cavity of a body.
using Counts = std::map<std::pair<std::size_t, std::uint32_t>, std::size_t>;

/// The liquid of the scene that a place is of: later ones take no place of earlier ones.
std::optional<std::size_t> fluid_at(const Scene& scene, const meltsim::Vec3d& x) {
  for (std::size_t i = 0; i < scene.fluids.size(); ++i)
    if (scene.fluids[i].desc.shape.contains(x)) return i;
  return std::nullopt;
}

struct Liquid {
  Cell cell;
  meltsim::Vec3d position;
};

Counts enclosed(const Scene& scene, Grid& grid, const std::vector<const Liquid*>& inside) {
  std::map<std::size_t, std::size_t> in_cell;  // particles by cell
  for (const Liquid* l : inside) ++in_cell[grid.index(l->cell)];
  Counts counts;
  for (const Liquid* l : inside) {
    if (grid.is_open(l->cell)) continue;  // seen with another
    std::size_t count = 0;
    const std::uint32_t body = grid.wall_around(l->cell, [&](std::size_t cell) {
      const auto found = in_cell.find(cell);
      if (found != in_cell.end()) count += found->second;
    });
    const auto fluid = fluid_at(scene, l->position);
    if (body != 0 && fluid && count >= least_enclosed) counts[{*fluid, body}] += count;
  }
  return counts;
}

/// Per liquid of the scene: whether it lies outside of bodies as well. Before enclosed(), which counts what it has seen as open.
std::vector<bool> lie_outside(const Scene& scene, const Grid& grid, const std::vector<Liquid>& liquid) {
  std::vector<bool> open(scene.fluids.size());
  for (std::size_t i = 0; i < open.size(); ++i)
    open[i] = std::any_of(liquid.begin(), liquid.end(), [&](const Liquid& l) {
      return grid.is_open(l.cell) && scene.fluids[i].desc.shape.contains(l.position);
    });
  return open;
}

}  // namespace

std::vector<std::string> enclosed_liquid(const Scene& scene, Built& built) {
  std::vector<std::string> warnings;
  if (scene.bodies.empty() || scene.fluids.empty()) return warnings;
  const meltsim::ParticleData now = expect(built.world.particles());
  std::vector<Cell> cells;
  std::vector<Liquid> liquid;
  for (std::size_t i = 0; i < now.id.size(); ++i) {
    cells.push_back(cell_of(scene, now.position[i]));
    if (meltsim::is_fluid(now.tag[i])) liquid.push_back({cells.back(), now.position[i]});
  }
  if (liquid.size() < least_enclosed) return warnings;
  Grid grid(cells);
  if (!grid.fits()) return warnings;
  for (std::size_t i = 0; i < now.id.size(); ++i)
    if (meltsim::is_solid(now.tag[i])) grid.put_solid(cells[i], meltsim::body_of(now.tag[i]));
  grid.flood();
  std::vector<const Liquid*> inside;
  for (const Liquid& l : liquid)
    if (!grid.is_open(l.cell)) inside.push_back(&l);
  if (inside.size() < least_enclosed) return warnings;
  const std::vector<bool> open = lie_outside(scene, grid, liquid);
  for (const auto& [where, count] : enclosed(scene, grid, inside)) {
    const auto [fluid, body] = where;
    if (!open[fluid]) continue;  // a vessel that it was put into
    const SceneBody& hollow = scene.bodies.at(body - 1);
    warnings.push_back(
        fmt::format("{}: {}: {} of its particles are enclosed in body \"{}\": its shape covers the cavity "
                    "too; if there is "
                    "to be air, subtract the body's outer shape from it (difference)",
                    scene.fluids[fluid].source.where, scene.fluids[fluid].source.path, count_text(count),
                    hollow.desc.name));
  }
  return warnings;
}

}  // namespace runner
