// SPDX-License-Identifier: Apache-2.0
#include "edits.hpp"

#include <algorithm>
#include <cmath>

#include "resolution.hpp"

namespace view {

namespace {

using Form = ConductivityEdit::Form;

void set(meltsim::MaterialDesc& material, const ConductivityEdit& edit) {
  if (edit.form == Form::diffusivity) material.diffusivity = edit.value;
  if (edit.form == Form::conductivity) material.conductivity = edit.value;
  if (edit.form == Form::factor)
    for (meltsim::PropertyPoint& point : material.conductivity_points) point.value *= edit.value;
}

ConductivityEdit conductivity_of(const meltsim::MaterialDesc& material) {
  if (!material.conductivity_points.empty()) return {material.name, Form::factor, 1};
  if (material.diffusivity) return {material.name, Form::diffusivity, *material.diffusivity};
  return {material.name, Form::conductivity, material.conductivity};
}

/// Calls f(name, temperature) for everything the scene starts or goes on with; the order is that of Edits.
template <class S, class F>
void for_each_temperature(S& scene, F f) {
  for (std::size_t i = 0; i < scene.fluids.size(); ++i)
    f("liquid " + std::to_string(i + 1) + ": " + scene.fluids[i].material, scene.fluids[i].desc.temperature);
  for (auto& body : scene.bodies) f(body.desc.name + ": " + body.material, body.desc.temperature);
  for (auto& emitter : scene.emitters)
    f(emitter.desc.name + ": " + emitter.material, emitter.desc.temperature);
}

void include(meltsim::Box& box, const meltsim::Box& more) {
  if (more.min.x > more.max.x) return;
  box.min = {std::min(box.min.x, more.min.x), std::min(box.min.y, more.min.y),
             std::min(box.min.z, more.min.z)};
  box.max = {std::max(box.max.x, more.max.x), std::max(box.max.y, more.max.y),
             std::max(box.max.z, more.max.z)};
}

}  // namespace

Edits edits_of(const runner::Scene& scene, double scale) {
  Edits edits;
  for (const runner::SceneMaterial& material : scene.materials)
    edits.conductivities.push_back(conductivity_of(material.desc));
  for_each_temperature(scene, [&edits](const std::string& name, double value) {
    edits.temperatures.push_back({name, value});
  });
  edits.time_scale = scene.world.heat.time_scale;
  edits.scale = scale;
  return edits;
}

runner::Scene edited(const runner::Scene& scene, const Edits& edits, runner::Quality quality) {
  runner::Scene changed = scene;
  for (std::size_t i = 0; i < changed.materials.size(); ++i)
    set(changed.materials[i].desc, edits.conductivities.at(i));
  std::size_t at = 0;
  for_each_temperature(changed,
                       [&](const std::string&, double& value) { value = edits.temperatures.at(at++).value; });
  changed.world.heat.time_scale = edits.time_scale;
  runner::apply_resolution(changed, edits.scale, quality);
  return changed;
}

Range temperature_range(const runner::Scene& scene) {
  Range range{meltsim::infinity, -meltsim::infinity};
  const auto add = [&range](double value) {
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  };
  for_each_temperature(scene, [&add](const std::string&, double value) { add(value); });
  for (const runner::SceneHeatRegion& region : scene.heat_regions)
    if (region.desc.temperature) add(*region.desc.temperature);
  for (const meltsim::SurfaceHeatDesc& wall : scene.world.domain.heat)
    if (wall.temperature) add(*wall.temperature);
  if (range.low > range.high) return {19.5, 20.5};
  if (range.high - range.low < 1) return {range.low - 0.5, range.high + 0.5};
  return range;
}

meltsim::Box scene_box(const runner::Scene& scene) {
  if (scene.world.domain.bounded) return {scene.world.domain.min, scene.world.domain.max};
  const double far = meltsim::infinity;
  meltsim::Box box{{far, far, far}, {-far, -far, -far}};
  for (const runner::SceneFluid& fluid : scene.fluids) include(box, fluid.desc.shape.bounds());
  for (const runner::SceneBody& body : scene.bodies) include(box, body.desc.shape.bounds());
  for (const runner::SceneEmitter& emitter : scene.emitters)
    include(box, {emitter.desc.center, emitter.desc.center});
  if (box.min.x > box.max.x) return {{-1, -1, -1}, {1, 1, 1}};
  return box;
}

}  // namespace view
