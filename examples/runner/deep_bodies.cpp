// SPDX-License-Identifier: Apache-2.0
#include "deep_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "numbers.hpp"

namespace runner {

namespace {

using meltsim::Box;
using meltsim::Vec3d;

// A rigid sphere of 8 spacings goes 0.6 to 0.8 of its way under 24 spacings of water where it has 0.917 to 1.2 times the water's density
// (docs/limits.md): heavier and lighter ones, and those nearer to the surface, come closer.
constexpr double nearly = 0.25, deep = 12;
// Waves and splashes stay above: the field's level is put as far below the surface.
constexpr double waves = 5;

double& part(Vec3d& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
double part(Vec3d v, int axis, int sign) { return sign * part(v, axis); }

/// The direction of a scene's gravity where it is along an axis.
struct Up {
  int axis, sign;
};
std::optional<Up> up_of(Vec3d gravity) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::fabs(part(gravity, axis)) > 0.99 * length(gravity))
      return Up{axis, part(gravity, axis) > 0 ? -1 : 1};
  return {};
}

/// A liquid around a body, and how far up it reaches.
struct Around {
  double density, level;
};

std::optional<Around> liquid_around(const Scene& scene, const Box& body, Up up) {
  std::optional<Around> found;
  for (const SceneFluid& fluid : scene.fluids) {
    Box box = fluid.desc.shape.bounds();
    bool holds = true;
    for (int axis = 0; axis < 3; ++axis) {
      const double middle = 0.5 * (part(body.min, axis, 1) + part(body.max, axis, 1));
      holds = holds && part(box.min, axis) <= middle && middle <= part(box.max, axis);
    }
    if (!holds) continue;
    const auto material = std::find_if(scene.materials.begin(), scene.materials.end(),
                                       [&](const SceneMaterial& m) { return m.desc.name == fluid.material; });
    const double level = std::max(part(box.min, up.axis, up.sign), part(box.max, up.axis, up.sign));
    if (!found || level > found->level) found = Around{material->desc.density, level};
  }
  return found;
}

bool can_move(const meltsim::SolidDesc& body) {
  return !body.fixed && (body.motion == meltsim::Motion::free || body.motion == meltsim::Motion::rigid);
}

std::string warning_of(const SceneBody& body, double ratio, double depth, Vec3d level, double density) {
  return fmt::format(
      "{}: {}: \"{}\", of {:.3g} times the density of the liquid, lies {:.0f} spacings deep: the pressure "
      "there holds "
      "it back, by a quarter or more of its way. Where all below a level stays full of liquid, this cures "
      "it: "
      "force_fields: [{{kind: hydrostatic, center: [{:.4g}, {:.4g}, {:.4g}], density: {:g}}}]",
      body.source.where, body.source.path, body.desc.name, ratio, depth, level.x, level.y, level.z, density);
}

}  // namespace

std::vector<std::string> deep_bodies(const Scene& scene) {
  std::vector<std::string> warnings;
  const auto rests = [](const SceneForceField& f) {
    return f.desc.kind == meltsim::ForceFieldKind::hydrostatic;
  };
  const std::optional<Up> up = up_of(scene.world.gravity);
  if (!up || std::any_of(scene.force_fields.begin(), scene.force_fields.end(), rests)) return warnings;
  for (const SceneBody& body : scene.bodies) {
    if (!can_move(body.desc)) continue;
    const auto material = std::find_if(scene.materials.begin(), scene.materials.end(),
                                       [&](const SceneMaterial& m) { return m.desc.name == body.material; });
    Box box = body.desc.shape.bounds();
    const std::optional<Around> liquid = liquid_around(scene, box, *up);
    if (!liquid) continue;
    const double ratio = body.density.value_or(material->desc.density) / liquid->density,
                 top = std::max(part(box.min, up->axis, up->sign), part(box.max, up->axis, up->sign)),
                 depth = (liquid->level - top) / scene.world.spacing;
    if (!(std::fabs(ratio - 1) <= nearly && depth >= deep)) continue;
    Vec3d level = (box.min + box.max) * 0.5;
    part(level, up->axis) = up->sign * (liquid->level - waves * scene.world.spacing);
    warnings.push_back(warning_of(body, ratio, depth, level, liquid->density));
  }
  return warnings;
}

}  // namespace runner
