// SPDX-License-Identifier: Apache-2.0
#include "missing_mass.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "expect.hpp"
#include "numbers.hpp"
#include "resolution.hpp"

namespace runner {

namespace {

// What is worth a warning: an eighth, by which the library stretches cells of liquid at most. What melts takes as much longer, and no
// error of the models of heat and motion is as large. Spheres and ducks of a hundred particles are off by less.
constexpr double most_off = 0.125;
// What a spacing that is advised comes to; and how far below the present one it is looked for.
constexpr double fits = 0.05, least_share = 0.5;
// Points looked at for the volumes of all shapes: every run pays for them, and for a walk through the triangles of every mesh per shift. And
// lattice points for all spacings that are tried, where something does not fit.
constexpr double volume_points = 4e5, trial_points = 1e7;
constexpr int shifts = 13, shifts_of_mesh = 5;
constexpr std::size_t most_warnings = 3;

/// A body or a liquid as it is in the scene, and what its particles take up.
struct Part {
  const Source* source;
  std::string name;  ///< for people
  meltsim::Shape shape;
  bool mesh;             ///< one that is slow to ask
  bool fills;            ///< its cells are stretched from wall to wall
  double density;        ///< [kg/m^3]; 0: differs with temperature or contents
  double particles = 0;  ///< [m^3] of its particles
  double volume = 0;     ///< [m^3] of its shape
  double off() const { return particles / volume - 1; }
};

std::vector<Part> bodies_of(const Scene& scene, Built& built) {
  std::vector<double> mass(scene.bodies.size(), 0);
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces()))
    mass.at(piece.body.index) += piece.mass;
  std::vector<Part> parts;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.desc.motion == meltsim::Motion::proxy) continue;  // its mass is given
    const auto material = std::find_if(scene.materials.begin(), scene.materials.end(),
                                       [&](const SceneMaterial& m) { return m.desc.name == body.material; });
    const bool fixed = body.desc.fixed || body.desc.motion == meltsim::Motion::fixed;
    const double density = body.density.value_or(material->desc.density);
    parts.push_back({&body.source, fmt::format("\"{}\"", body.desc.name), body.desc.shape,
                     body.shape.mesh != 0, fixed && body.desc.growth == 0, density, mass[i] / density});
  }
  return parts;
}

/// Each without those before it, which keep what they have.
std::vector<Part> liquids_of(const Scene& scene, const Built& built) {
  std::vector<Part> parts;
  std::vector<meltsim::Shape> before;
  for (std::size_t i = 0; i < scene.fluids.size(); ++i) {
    const SceneFluid& fluid = scene.fluids[i];
    const meltsim::Shape& shape = fluid.desc.shape;
    const auto material = std::find_if(scene.materials.begin(), scene.materials.end(),
                                       [&](const SceneMaterial& m) { return m.desc.name == fluid.material; });
    const bool same = material->desc.density_points.empty() && fluid.fractions.empty();
    Part part{&fluid.source,
              "the liquid",
              before.empty() ? shape : meltsim::Shape::subtract(shape, meltsim::Shape::unite(before)),
              fluid.shape.mesh != 0,
              true,
              same ? material->desc.density : 0};
    part.particles = static_cast<double>(built.fluid_particles[i]) *
                     cell_volume(scene.world.domain, part.shape, part.fills, scene.world.spacing);
    parts.push_back(part);
    before.push_back(shape);
  }
  return parts;
}

/// The largest |off()| of all of them at another spacing.
double worst_at(const meltsim::DomainDesc& domain, const std::vector<Part>& parts, double spacing) {
  double worst = 0;
  for (const Part& part : parts) {
    const double volume = volume_of_particles(domain, part.shape, part.fills, spacing);
    worst = std::max(worst, std::fabs(volume / part.volume - 1));
  }
  return worst;
}

/// Spacings below the present one, from large to small: of two digits, and those that what fills the domain is a whole number of.
std::vector<double> candidates(const Scene& scene, const std::vector<double>& lengths) {
  const double now = scene.world.spacing, digit = std::pow(10, std::floor(std::log10(now)) - 1);
  std::vector<double> all;
  const auto add = [&](double spacing) {
    const double as_typed = typed(spacing);
    if (as_typed < now * (1 - 1e-6) && as_typed >= least_share * now) all.push_back(as_typed);
  };
  for (double units = std::ceil(now / digit); units * digit >= least_share * now; --units) add(units * digit);
  for (const double length : lengths)
    for (double cells = std::ceil(length / now); cells * least_share * now <= length; ++cells)
      add(length / cells);
  std::sort(all.begin(), all.end(), std::greater<>());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

/// A spacing that fits all of them: the largest that leaves liquid as it is between walls, too, else the largest that does not, else the best.
std::optional<double> fitting_spacing(const Scene& scene, const std::vector<Part>& parts) {
  std::vector<double> lengths;
  double volume = 0, points = 0, best = most_off;
  for (const Part& part : parts) {
    volume += part.volume;
    for (const double length :
         filled_lengths(scene.world.domain, part.shape, part.fills, scene.world.spacing))
      if (length > 0) lengths.push_back(length);
  }
  std::optional<double> found;
  for (const double spacing : candidates(scene, lengths)) {
    const bool even = std::all_of(lengths.begin(), lengths.end(), [&](double length) {
      return std::fabs(length / spacing / std::round(length / spacing) - 1) < 1e-3;
    });
    if (!even && best <= fits) continue;
    points += volume / (spacing * spacing * spacing);
    if (points > trial_points) break;
    const double off = worst_at(scene.world.domain, parts, spacing);
    if (off <= fits && even) return spacing;
    if (off < best) found = spacing, best = off;
  }
  return found;
}

std::string text_of(const Part& part, double spacing, const std::string& advice) {
  const bool mass = part.density > 0;
  const double scale = mass ? part.density : 1;
  return fmt::format(
      "{}: {}.shape: the particles of {} have {:.3g} {}, {:.0f} % {} than its {}, about {} {}: "
      "particles.spacing "
      "{:g} does not fit it; {}",
      part.source->where, part.source->path, part.name, scale * part.particles, mass ? "kg" : "m^3",
      100 * std::fabs(part.off()), part.off() < 0 ? "less" : "more", mass ? "volume times density" : "shape",
      two_digits(scale * part.volume), mass ? "kg" : "m^3", spacing, advice);
}

}  // namespace

std::vector<std::string> missing_mass(const Scene& scene, Built& built) {
  std::vector<Part> parts = bodies_of(scene, built), liquids = liquids_of(scene, built);
  parts.insert(parts.end(), liquids.begin(), liquids.end());
  std::vector<const Part*> wrong;
  for (Part& part : parts)
    part.volume = volume_of(part.shape, volume_points / static_cast<double>(parts.size()),
                            part.mesh ? shifts_of_mesh : shifts);
  for (const Part& part : parts)
    if (part.volume > 0 && std::fabs(part.off()) > most_off) wrong.push_back(&part);
  std::vector<std::string> warnings;
  if (wrong.empty()) return warnings;
  const std::optional<double> spacing = fitting_spacing(scene, parts);
  const bool changed = std::fabs(scene.given_spacing / scene.world.spacing - 1) > 1e-6;
  const std::string advice =
      spacing ? fmt::format("use particles.spacing {:g}{}, which fits every body and liquid", *spacing,
                            changed ? " and no --scale or --quality" : "")
              : "use a much smaller particles.spacing, or sizes and places of whole spacings";
  for (const Part* part : wrong) {
    if (warnings.size() == most_warnings) break;
    warnings.push_back(text_of(*part, scene.world.spacing, advice));
  }
  if (wrong.size() > most_warnings)
    warnings.push_back(
        fmt::format("{} more of the bodies and liquids have over {:g} % more or less than their shapes",
                    wrong.size() - most_warnings, 100 * most_off));
  return warnings;
}

}  // namespace runner
