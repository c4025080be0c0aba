// SPDX-License-Identifier: Apache-2.0
#include "resolution.hpp"

#include <algorithm>
#include <cmath>

#include "meltsim/physics/surface_tension.hpp"

namespace runner {

namespace {

constexpr double least_change = 1e-9, most_change = 0.12, rounding = 0.02;
// Spacings by which World::add_fluid takes a shape to reach a wall.
constexpr double touching = 1e-3;
// Gaps in spacings that a change of the spacing by as much as itself is worth.
constexpr double worth = 2;
// Presets are a factor of about 4 in cost apart, in scenes without flow as well (docs/trade.md): 0.8^4 = 0.41 of the work by
// the spacing, 0.8 each by sound speed and Courant number; 1.4^4 = 3.8 times the work.
constexpr double draft_scale = 0.8, draft_sound = 0.8, draft_courant = 0.5, accurate_scale = 1.4;

/// What a whole number of spacings leaves of a domain [spacings], over the axes across gravity, along which liquid seldom reaches the other end:
/// cells of liquid and of fixed bodies are stretched to fill it, and other bodies leave it free. As much as is left to rounding counts as none.
double misfit(const meltsim::WorldDesc& world, double spacing) {
  const meltsim::Vec3d length = world.domain.max - world.domain.min, g = world.gravity;
  const double sizes[] = {length.x, length.y, length.z},
               pull[] = {std::fabs(g.x), std::fabs(g.y), std::fabs(g.z)};
  const double most = std::max({pull[0], pull[1], pull[2]});
  double sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool open = world.domain.faces[2 * a] == meltsim::Face::open ||
                      world.domain.faces[2 * a + 1] == meltsim::Face::open;
    if (open || (most > 0 && pull[a] == most)) continue;
    const double cells = sizes[a] / spacing;
    sum += std::max(0.0, cells - std::floor(cells + rounding));
  }
  return sum;
}

/// The spacing near `wanted` that fits the domain best, so that cells are cubes.
double fitted(const meltsim::WorldDesc& world, double wanted) {
  if (!world.domain.bounded || misfit(world, wanted) < 1e-6) return wanted;
  const meltsim::Vec3d size = world.domain.max - world.domain.min;
  const auto cost = [&](double s) { return misfit(world, s) + worth * std::fabs(s / wanted - 1); };
  double best = wanted;
  for (const double length : {size.x, size.y, size.z})
    for (double cells = std::round(length / wanted) - 2; cells <= length / wanted + 2; ++cells) {
      if (cells < 1) continue;
      const double s = length / cells;
      if (std::fabs(s / wanted - 1) <= most_change && cost(s) < cost(best) - least_change) best = s;
    }
  return best;
}

/// A length that whole cells fill, where that is within an eighth of the spacing: as the library stretches them.
double filling(double length, double spacing) {
  const double fitted = length / std::floor(length / spacing + 0.49);
  return std::isfinite(fitted) && std::fabs(fitted / spacing - 1) <= 0.125 ? fitted : spacing;
}

/// The least sound speed that liquids with surface tension allow at this spacing [m/s].
double least_sound_speed(const Scene& scene) {
  double least = 0;
  for (const SceneMaterial& m : scene.materials) {
    if (!(m.desc.surface_tension > 0)) continue;
    double density = m.desc.density;
    for (const meltsim::PropertyPoint& p : m.desc.density_points) density = std::min(density, p.value);
    least = std::max(
        least, meltsim::physics::tension_sound_speed(m.desc.surface_tension, density, scene.world.spacing));
  }
  return least * (1 + 1e-6);
}

}  // namespace

void apply_resolution(Scene& scene, double scale, Quality quality) {
  double factor = scale;
  if (quality == Quality::draft) factor *= draft_scale;
  if (quality == Quality::accurate) factor *= accurate_scale;
  meltsim::WorldDesc& world = scene.world;
  if (factor != 1) factor = world.spacing / fitted(world, world.spacing / factor);
  apply_spacing(scene, world.spacing / factor);
  if (quality == Quality::draft) {
    scene.sound_factor = draft_sound;
    if (world.sound_speed > 0) world.sound_speed *= draft_sound;
    world.courant = std::max(world.courant, draft_courant);
  }
  // One that the scene sets would be refused at a finer spacing, or in draft quality: once its liquid has melted.
  if (world.sound_speed > 0 && (factor != 1 || quality == Quality::draft))
    world.sound_speed = std::max(world.sound_speed, least_sound_speed(scene));
}

void apply_spacing(Scene& scene, double spacing) {
  const double factor = scene.world.spacing / spacing;
  scene.world.spacing = spacing;
  // The support keeps its ratio to the spacing, or the neighbour count would change with the resolution.
  scene.world.support_radius /= factor;
  if (scene.output.surface.contains("cell")) {
    scene.output.surface["cell"] = scene.output.surface["cell"].get<double>() / factor;
  }
}

void apply_chosen_spacing(Scene& scene, double spacing) {
  const double volume = std::pow(spacing / scene.world.spacing, 3);
  apply_spacing(scene, spacing);
  for (SceneEmitter& emitter : scene.emitters)
    emitter.desc.max_particles =
        static_cast<std::uint64_t>(std::ceil(static_cast<double>(emitter.desc.max_particles) / volume));
}

double volume_of(const meltsim::Shape& shape, double points, int lattices) {
  const meltsim::Box b = shape.bounds();
  const meltsim::Vec3d size = b.max - b.min;
  const double bounds = size.x * size.y * size.z;
  if (!(bounds > 0)) return 0;
  const double step = std::cbrt(bounds * lattices / std::max(points, double(lattices)));
  // Multiples of 1, 2 and 4 lie evenly in a cube, modulo 13 and modulo 5, and perfectly so along each axis.
  constexpr int factors[] = {1, 2, 4};
  double sum = 0;
  for (int k = 0; k < lattices; ++k) {
    const auto shift = [&](int axis) { return (k * factors[axis] % lattices + 0.5) / lattices * step; };
    const meltsim::Vec3d origin = b.min - meltsim::Vec3d{shift(0), shift(1), shift(2)};
    sum += static_cast<double>(shape.lattice_points(origin, step).size());
  }
  return sum / lattices * step * step * step;
}

std::array<double, 3> filled_lengths(const meltsim::DomainDesc& d, const meltsim::Shape& shape, bool fills,
                                     double spacing) {
  const meltsim::Box b = shape.bounds();
  const double low[] = {b.min.x, b.min.y, b.min.z}, high[] = {b.max.x, b.max.y, b.max.z},
               from[] = {d.min.x, d.min.y, d.min.z}, to[] = {d.max.x, d.max.y, d.max.z};
  std::array<double, 3> lengths{};
  for (std::size_t a = 0; a < 3 && fills && d.bounded; ++a) {
    const bool open = d.faces[2 * a] == meltsim::Face::open || d.faces[2 * a + 1] == meltsim::Face::open;
    if (!open && low[a] < from[a] + touching * spacing && high[a] > to[a] - touching * spacing)
      lengths[a] = to[a] - from[a];
  }
  return lengths;
}

double cell_volume(const meltsim::DomainDesc& d, const meltsim::Shape& shape, bool fills, double spacing) {
  double volume = 1;
  for (const double length : filled_lengths(d, shape, fills, spacing))
    volume *= length > 0 ? filling(length, spacing) : spacing;
  return volume;
}

double volume_of_particles(const meltsim::DomainDesc& d, const meltsim::Shape& shape, bool fills,
                           double spacing) {
  return static_cast<double>(shape.lattice_points(d.min, spacing).size()) *
         cell_volume(d, shape, fills, spacing);
}

}  // namespace runner
