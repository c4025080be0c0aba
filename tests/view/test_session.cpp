// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "load_scene.hpp"
#include "session.hpp"
#include "temperature_table.hpp"

namespace {

using namespace view;

// Liquids with and without a table, one that freezes, a body that melts; 512 particles or so.
const char* text = R"(
meltsim: 1
domain: {min: [0, 0, 0], max: [1.6, 1.6, 1.6], walls: box}
particles: {spacing: 0.2}
time: {dt: 0.002, fps: 50}
heat: {model: enthalpy, time_scale: 1.0e+6}
materials:
  water: {density: 1000, viscosity: 0.2, conductivity: 0.6, heat_capacity: 4186}
  brine: {density: 1100, viscosity: 0.2, conductivity: 0.5, heat_capacity: [[0, 3500], [50, 3900]]}
  ice: {density: 917, conductivity: 2.2, heat_capacity: 2100, melting_point: 0, latent_heat: 3.34e5, becomes: water,
        freezes: true}
fluids:
  - {shape: {box: [[0, 0, 0], [1.6, 0.4, 1.6]]}, material: brine, temperature: 5}
  - {shape: {box: [[0, 0.4, 0], [1.6, 0.8, 1.6]]}, material: water, temperature: 40}
bodies:
  - {name: block, shape: {box: [[0.6, 0.6, 0.6], [1.2, 1.2, 1.2]]}, material: ice, temperature: -10, growth: 1}
)";

Session make_session(double scale = 1, const std::vector<std::string>& set = {}) {
  runner::MachineOptions machine;
  machine.backend = meltsim::Backend::cpu;
  machine.threads = 1;
  return {runner::parse_scene(text, "session.yaml", "", set), machine, scale, runner::Quality::balanced};
}

constexpr double ample = 1e9;  // budget [s]

TEST(Session, AdvancesInWholeStepsAndOwesTheRest) {
  Session session = make_session();
  session.advance(0.0053, ample, 1);
  EXPECT_NEAR(session.time(), 0.004, 1e-9);
  session.advance(0.0009, ample, 1);
  EXPECT_NEAR(session.time(), 0.006, 1e-9);
  session.single_step();
  EXPECT_NEAR(session.time(), 0.008, 1e-9);
  EXPECT_EQ(session.error(), "");
}

TEST(Session, WithoutBudgetTimeIsDroppedNotMadeUpFor) {
  Session session = make_session();
  session.advance(10, 0, 1);
  EXPECT_EQ(session.time(), 0);
  session.advance(0.002, ample, 1);
  EXPECT_LE(session.time(), 0.0041);  // at most what was owed: one step
}

TEST(Session, ConductivityChangesWithTheStateKept) {
  Session session = make_session();
  session.advance(0.02, ample, 1);
  const auto before = session.world().particles();
  ASSERT_TRUE(before);
  Edits edits = session.edits();
  for (ConductivityEdit& edit : edits.conductivities) edit.value *= 2;
  session.rebuild(edits, true);
  EXPECT_EQ(session.error(), "");
  EXPECT_NEAR(session.time(), 0.02, 1e-9);
  EXPECT_EQ(session.generation(), 1);
  const auto after = session.world().particles();
  ASSERT_TRUE(after);
  ASSERT_EQ(after->id.size(), before->id.size());
  for (std::size_t i = 0; i < after->id.size(); ++i) {
    EXPECT_EQ(after->enthalpy[i], before->enthalpy[i]);
    EXPECT_EQ(after->position[i].y, before->position[i].y);
  }
  const meltsim::MaterialDesc water = session.world().material(session.built().material_ids[0]);
  EXPECT_GT(water.conductivity, 1.1 * 0.6);
  session.advance(0.02, ample, 1);
  EXPECT_EQ(session.error(), "");
  EXPECT_NEAR(session.time(), 0.04, 1e-9);
}

TEST(Session, TemperatureAndQualityStartAgain) {
  Session session = make_session();
  session.advance(0.01, ample, 1);
  const std::uint64_t particles = session.result().fluid;
  Edits edits = session.edits();
  edits.temperatures.at(0).value = 12;
  edits.scale = 1.25;
  session.rebuild(edits, false);
  EXPECT_EQ(session.time(), 0);
  EXPECT_GT(session.result().fluid, particles);
}

TEST(Session, SqueezedLiquidIsSaid) {
  // At 0.7, 1.6 m are 5.6 spacings: what has no room beside the walls is left out.
  Session good = make_session(), fits_not = make_session(0.7);
  Session bad = make_session(1, {"solver.sound_speed=21", "fluids[1].velocity=[0, -20, 0]"});
  for (Session* session : {&good, &fits_not, &bad}) session->advance(0.02, ample, 1);
  EXPECT_EQ(good.warning(), "");
  EXPECT_EQ(fits_not.warning(), "");
  EXPECT_NE(bad.warning().find("squeezed"), std::string::npos) << bad.warning();
}

TEST(Session, WhatCannotBeBuiltLeavesTheOldWorld) {
  Session session = make_session();
  session.advance(0.01, ample, 1);
  Edits edits = session.edits();
  edits.scale = 0.05;  // the domain is smaller than two support radii
  session.rebuild(edits, false);
  EXPECT_NE(session.error(), "");
  EXPECT_NEAR(session.time(), 0.01, 1e-9);
  EXPECT_EQ(session.edits().scale, 1);
}

/// What the GPU works out per particle is what the World says: to the rounding of single precision.
TEST(TemperatureTable, ParticlesReadTheWorldsTemperature) {
  Session session = make_session();
  session.advance(0.1, ample, 1);
  const auto curves = substance_curves(session.world(), session.built().material_ids);
  const auto data = session.world().particles();
  ASSERT_TRUE(data);
  int between = 0;
  for (std::size_t i = 0; i < data->id.size(); ++i) {
    const double volume = data->mass[i] / curves.at(meltsim::material_of(data->tag[i])).density;
    const double t = particle_temperature(curves.data(), data->tag[i], data->enthalpy[i], volume);
    EXPECT_NEAR(t, data->temperature[i], 1e-4 * (1 + std::abs(data->temperature[i])));
    if (data->liquid_fraction[i] > 0 && data->liquid_fraction[i] < 1) ++between;
  }
  EXPECT_GT(between, 0);
}

}  // namespace
