// SPDX-License-Identifier: Apache-2.0
// Nozzles, open faces and periodic axes.
#include <cmath>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

World tank(std::array<Face, 6> faces, double gravity = -9.81) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.2, 1.2};
  d.domain.faces = faces;
  d.gravity = {0, gravity, 0};
  d.sound_speed = 40;
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

constexpr std::array<Face, 6> walls{Face::wall, Face::wall, Face::wall, Face::wall, Face::wall, Face::wall};

EmitterDesc nozzle(MaterialId water) {
  EmitterDesc e;
  e.name = "jet";
  e.material = water;
  e.center = {0.6, 1.0, 0.6};
  e.axis = {0, -2, 0};  // need not be a unit vector
  e.radius = 0.15;      // a disc of 4 points: |(0.05, 0.05)| = 0.07 inside, |(0.15, 0.05)| = 0.158 outside
  e.speed = 2;
  e.until = 0.5;
  return e;
}

TEST(Emitter, EmitsSpeedTimesAreaAndStops) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(walls);
  const auto water = *w.add_material({});
  require(w.add_emitter(nozzle(water)));
  for (int k = 0; k < 110; ++k) require(w.step(0.005));
  const ParticleData p = *w.particles();
  for (const Vec3d& x : p.position) EXPECT_LT(x.y, 0.9);  // the last left at 2 m/s, 0.05 s ago or more
  for (int k = 0; k < 90; ++k) require(w.step(0.005));    // 1 s, twice the time it runs
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_FALSE(r.emitter_exhausted);
  EXPECT_EQ(r.fluid, 40u);                                 // 2 m/s for 0.5 s = 10 layers of 4
  EXPECT_NEAR(w.totals()->mass, 40 * 1000 * 0.001, 1e-4);  // float masses
}

TEST(Emitter, ParticlesLeaveTheNozzleASpacingApartWhateverTheStep) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(walls, 0);
  const auto water = *w.add_material({});
  require(w.add_emitter(nozzle(water)));
  for (const double dt : {0.001, 0.013, 0.0005, 0.02, 0.007}) require(w.step(dt));
  const double time = w.time();
  const auto p = *w.particles();
  ASSERT_EQ(p.id.size(), 4 * static_cast<std::size_t>(1 + std::floor(time * 2 / 0.1)));
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const double layer = double(p.id[i] / 4);
    EXPECT_NEAR(p.position[i].y, 1.0 - 2 * (time - layer * 0.05), 1e-4);  // free flight so far
  }
}

TEST(Emitter, StopsAtItsLimitAndSaysSo) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(walls);
  const auto water = *w.add_material({});
  EmitterDesc e = nozzle(water);
  e.until = infinity;
  e.max_particles = 10;  // two layers of 4
  require(w.add_emitter(e));
  for (int k = 0; k < 60; ++k) require(w.step(0.005));
  const StepResult r = w.synchronize();
  EXPECT_TRUE(r.emitter_exhausted);
  EXPECT_EQ(r.fluid, 8u);
}

TEST(Domain, LiquidThatLeavesAnOpenFaceIsCounted) {
  MELTSIM_NEEDS_BACKEND();
  std::array<Face, 6> faces = walls;
  faces[2] = Face::open;  // no floor
  World w = tank(faces);
  const auto water = *w.add_material({});
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0.3, 0.3, 0.3}, {0.9, 0.9, 0.9});
  const auto n = *w.add_fluid(f);
  for (int k = 0; k < 160; ++k) require(w.step(0.005));  // falls 3 m
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_EQ(r.removed, n);
  EXPECT_EQ(r.fluid, 0u);
  EXPECT_EQ(w.particles()->id.size(), 0u);
  EXPECT_EQ(w.totals()->mass, 0.0);
}

TEST(Domain, APeriodicAxisWrapsWithoutASeam) {
  MELTSIM_NEEDS_BACKEND();
  std::array<Face, 6> faces{Face::periodic, Face::periodic, Face::periodic,
                            Face::periodic, Face::periodic, Face::periodic};
  World w = tank(faces, 0);
  const auto water = *w.add_material({});
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0, 0, 0}, {1.2, 1.2, 1.2});
  f.velocity = {1, 0.5, 0};
  require(w.add_fluid(f));
  for (int k = 0; k < 120; ++k) require(w.step(0.005));  // half of it crosses a seam
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  // A uniform stream stays uniform: any seam would show as pressure and speed. Rounding of positions at 1.2 m
  // is 1e-7, against a spacing of 0.1: 1e-6 in density, amplified 7-fold by the equation of state.
  EXPECT_NEAR(r.max_density_ratio, 1.0, 1e-5);
  EXPECT_NEAR(r.max_speed, std::sqrt(1.25), 1e-3);
  const auto p = *w.particles();
  for (const Vec3d& x : p.position) {
    EXPECT_GE(x.x, 0.0);
    EXPECT_LE(x.x, 1.2 + 1e-6);
  }
}

}  // namespace
}  // namespace meltsim_test
