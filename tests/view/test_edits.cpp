// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "edits.hpp"
#include "load_scene.hpp"

namespace {

using namespace view;

const char* text = R"(
meltsim: 1
domain: {min: [0, 0, 0], max: [1.6, 2, 1.2], walls: box}
particles: {spacing: 0.2, support: 0.5}
heat: {model: enthalpy, time_scale: 1000}
materials:
  water: {conductivity: 0.6}
  oil: {diffusivity: 1.0e-7}
  lava: {conductivity: [[0, 1], [100, 3]]}
  ice: {density: 917, melting_point: 0, becomes: water}
fluids:
  - {shape: {box: [[0, 0, 0], [1.6, 0.6, 1.2]]}, material: water, temperature: 40}
bodies:
  - {name: block, shape: {box: [[0.4, 0.8, 0.4], [1.2, 1.2, 0.8]]}, material: ice, temperature: -10}
emitters:
  - {name: jet, nozzle: {center: [0.8, 1.8, 0.6], radius: 0.25}, material: water, temperature: 90, until: 1}
)";

runner::Scene scene() { return runner::parse_scene(text, "edits.yaml", "", {}); }

ConductivityEdit& edit_of(Edits& edits, const std::string& material) {
  for (ConductivityEdit& edit : edits.conductivities)
    if (edit.material == material) return edit;
  throw std::runtime_error("no material " + material);
}

const meltsim::MaterialDesc& material_of(const runner::Scene& scene, const std::string& name) {
  for (const runner::SceneMaterial& material : scene.materials)
    if (material.desc.name == name) return material.desc;
  throw std::runtime_error("no material " + name);
}

TEST(Edits, NothingChangedChangesNothing) {
  const runner::Scene before = scene(),
                      after = edited(before, edits_of(before, 1), runner::Quality::balanced);
  EXPECT_EQ(after.world.spacing, before.world.spacing);
  EXPECT_EQ(after.world.heat.time_scale, 1000);
  EXPECT_EQ(after.fluids[0].desc.temperature, 40);
  EXPECT_EQ(material_of(after, "lava").conductivity_points[1].value, 3);
}

TEST(Edits, ConductivityInTheFormTheSceneGives) {
  Edits edits = edits_of(scene(), 1);
  edit_of(edits, "water").value = 1.2;
  EXPECT_EQ(edit_of(edits, "oil").form, ConductivityEdit::Form::diffusivity);
  edit_of(edits, "oil").value = 4e-7;
  EXPECT_EQ(edit_of(edits, "lava").form, ConductivityEdit::Form::factor);
  edit_of(edits, "lava").value = 10;
  const runner::Scene after = edited(scene(), edits, runner::Quality::balanced);
  EXPECT_EQ(material_of(after, "water").conductivity, 1.2);
  EXPECT_EQ(material_of(after, "oil").diffusivity.value_or(0), 4e-7);
  EXPECT_EQ(material_of(after, "lava").conductivity_points[0].value, 10);
  EXPECT_EQ(material_of(after, "lava").conductivity_points[1].value, 30);
}

TEST(Edits, TemperaturesReachTheirFluidBodyAndEmitter) {
  Edits edits = edits_of(scene(), 1);
  ASSERT_EQ(edits.temperatures.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) edits.temperatures[i].value = 10 * static_cast<double>(i + 1);
  const runner::Scene after = edited(scene(), edits, runner::Quality::balanced);
  EXPECT_EQ(after.fluids[0].desc.temperature, 10);
  EXPECT_EQ(after.bodies[0].desc.temperature, 20);
  EXPECT_EQ(after.emitters[0].desc.temperature, 30);
}

TEST(Edits, QualityIsTheRunnersScale) {
  Edits edits = edits_of(scene(), 1);
  edits.scale = 2;
  const runner::Scene after = edited(scene(), edits, runner::Quality::balanced);
  EXPECT_DOUBLE_EQ(after.world.spacing, 0.1);
  EXPECT_DOUBLE_EQ(after.world.support_radius, 0.25);
}

TEST(Edits, RangeSpansWhatTheSceneNames) {
  const Range range = temperature_range(scene());
  EXPECT_EQ(range.low, -10);
  EXPECT_EQ(range.high, 90);
}

TEST(Edits, BoxIsTheDomainOrWhatIsInIt) {
  runner::Scene s = scene();
  EXPECT_EQ(scene_box(s).max.z, 1.2);
  s.world.domain.bounded = false;
  EXPECT_NEAR(scene_box(s).max.y, 1.8, 1e-9);  // the nozzle
}

}  // namespace
