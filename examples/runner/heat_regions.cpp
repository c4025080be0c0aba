// SPDX-License-Identifier: Apache-2.0
#include "heat_regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "expect.hpp"
#include "meltsim/physics/path.hpp"
#include "numbers.hpp"
#include "resolution.hpp"

namespace runner {

namespace {

using meltsim::Shape;
using meltsim::Vec3d;

// As of bodies (missing_mass.cpp): an eighth, and points looked at for the volume of one shape.
constexpr double most_uneven = 0.125, region_points = 4e5;
constexpr int region_shifts = 13, mesh_region_shifts = 5;
// A region of as many cells has its volume to a percent or two, and nobody waits for it to be counted.
constexpr double many_cells = 1e5;

Vec3d lattice_origin(const Scene& scene) {
  return scene.world.domain.bounded ? scene.world.domain.min : Vec3d{};
}

/// The part of a region that is in the domain, and around periodic axes.
Shape in_domain(const meltsim::DomainDesc& domain, const Shape& shape) {
  if (!domain.bounded) return shape;
  std::vector<Shape> all{shape};
  const Vec3d size = domain.max - domain.min;
  const Vec3d periods[] = {{size.x, 0, 0}, {0, size.y, 0}, {0, 0, size.z}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (domain.faces[2 * axis] != meltsim::Face::periodic) continue;
    for (std::size_t k = 0, n = all.size(); k < n; ++k)
      for (const double way : {-1.0, 1.0}) all.push_back(all[k].transformed(periods[axis] * way));
  }
  return Shape::intersect({Shape::unite(std::move(all)), Shape::box(domain.min, domain.max)});
}

/// Where a region is when it begins to act, from where its shape is [m].
Vec3d at_begin(const SceneHeatRegion& region) {
  const std::vector<meltsim::PathPoint>& path = region.desc.path;
  if (path.empty()) return {};
  return meltsim::physics::displacement_at(path.data(), static_cast<std::uint32_t>(path.size()),
                                           region.desc.from);
}

/// What acts of a region that rests: what is in the domain. One that moves may bring the rest in.
Shape acting(const Scene& scene, const SceneHeatRegion& region) {
  return region.desc.path.empty() ? in_domain(scene.world.domain, region.desc.shape) : region.desc.shape;
}

/// [kg/m^3] of a material at a temperature.
double density_at(const meltsim::MaterialDesc& m, double temperature) {
  const std::vector<meltsim::PropertyPoint>& points = m.density_points;
  if (points.empty()) return m.density;
  const auto after =
      std::find_if(points.begin(), points.end(), [&](const auto& p) { return p.temperature >= temperature; });
  if (after == points.begin()) return points.front().value;
  if (after == points.end()) return points.back().value;
  const auto& before = *(after - 1);
  return before.value + (after->value - before.value) * (temperature - before.temperature) /
                            (after->temperature - before.temperature);
}

std::string text_of(const Scene& scene, const SceneHeatRegion& region, double cells, double volume) {
  const auto key = region.source.keys.find("source");
  const double dx = scene.world.spacing;
  return fmt::format(
      "{}: {}.source: \"{}\" heats particles whose centres are in it: at particles.spacing {:g} those of "
      "{:.0f} cells, {:.3g} m^3, {:.0f} % {} than its shape has, {:.3g} m^3, and so is its power; use "
      "source: "
      "{:.3g} for what source times the shape comes to, a larger shape, or a smaller particles.spacing",
      key == region.source.keys.end() ? region.source.where : key->second, region.source.path,
      region.desc.name, dx, cells, cells * dx * dx * dx, 100 * std::fabs(cells * dx * dx * dx / volume - 1),
      cells * dx * dx * dx < volume ? "less" : "more", volume,
      region.desc.source * volume / (cells * dx * dx * dx));
}

}  // namespace

std::vector<RegionPower> region_powers(const Scene& scene, Built& built) {
  std::vector<RegionPower> all;
  const auto heats = [](const SceneHeatRegion& region) { return region.desc.source != 0; };
  if (std::none_of(scene.heat_regions.begin(), scene.heat_regions.end(), heats)) return all;
  const meltsim::ParticleData now = expect(built.world.particles());
  const Vec3d origin = lattice_origin(scene);
  const double dx = scene.world.spacing;
  // A region is of whole cells of the lattice: those whose middle is inside.
  const auto middle = [&](double x, double from) { return from + (std::floor((x - from) / dx) + 0.5) * dx; };
  std::vector<meltsim::MaterialDesc> table;
  for (const meltsim::MaterialId id : built.material_ids) table.push_back(built.world.material(id));
  for (const SceneHeatRegion& region : scene.heat_regions) {
    if (!heats(region)) continue;
    const Shape shape = acting(scene, region);
    const Vec3d moved = at_begin(region);
    RegionPower sum{&region, 0, 0};
    for (std::size_t i = 0; i < now.id.size(); ++i) {
      const Vec3d x = now.position[i] - moved;
      if (meltsim::is_removed(now.tag[i]) ||
          !shape.contains({middle(x.x, origin.x), middle(x.y, origin.y), middle(x.z, origin.z)}))
        continue;
      ++sum.particles;
      sum.power += region.desc.source * now.mass[i] /
                   density_at(table.at(meltsim::material_of(now.tag[i])), now.temperature[i]);
    }
    all.push_back(sum);
  }
  return all;
}

std::vector<std::string> uneven_regions(const Scene& scene) {
  std::vector<std::string> warnings;
  const double dx = scene.world.spacing;
  for (const SceneHeatRegion& region : scene.heat_regions) {
    if (region.desc.source == 0) continue;
    const Shape shape = acting(scene, region);
    const meltsim::Box b = shape.bounds();
    const Vec3d size = b.max - b.min;
    if (!(size.x * size.y * size.z < many_cells * dx * dx * dx)) continue;
    const double volume =
        volume_of(shape, region_points, region.shape.mesh != 0 ? mesh_region_shifts : region_shifts);
    const double cells = static_cast<double>(shape.lattice_points(lattice_origin(scene), dx).size());
    if (cells == 0 || !(std::fabs(cells * dx * dx * dx / volume - 1) > most_uneven)) continue;
    warnings.push_back(text_of(scene, region, cells, volume));
  }
  return warnings;
}

}  // namespace runner
