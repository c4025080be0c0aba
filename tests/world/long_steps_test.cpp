// SPDX-License-Identifier: Apache-2.0
// Steps as long as a frame, where nothing limits them: what begins and ends within one, and what melts in one.
#include <algorithm>
#include <cmath>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.01, side = 0.1;

/// A fixed or floating cube in a weightless box that it fills, or not.
World cube(bool fixed, Motion motion = Motion::free) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.domain.bounded = true;
  d.domain.max = {side, side, side};
  if (!fixed) {
    d.domain.min = {-0.5, -0.5, -0.5};
    d.domain.max = {1, 1, 1};
    d.max_substeps = 20000;
  }
  World w = std::move(*World::create(d));
  MaterialDesc m;
  m.name = "metal";
  m.density = 2000;
  m.heat_capacity = 500;
  m.conductivity = 20;
  SolidDesc s;
  s.material = *w.add_material(m);
  s.shape = Shape::box({0, 0, 0}, {side, side, side});
  s.fixed = fixed;
  if (!fixed) s.motion = motion;
  require(w.add_solid(s));
  return w;
}

// 1 MW/m^3 in a litre for 0.05 s are 50 J, wherever steps begin and end: what is not cut at its ends takes 0, 40 or 48 of them. Sums of
// 1000 particles in single precision: 1e-6.
TEST(LongSteps, ASourceActsFromItsBeginningToItsEnd) {
  MELTSIM_NEEDS_BACKEND();
  for (const double dt : {0.5, 0.1, 0.04, 0.016})
    for (const bool budget : {false, true}) {
      World w = cube(true);
      HeatRegionDesc r;
      r.shape = Shape::box({0, 0, 0}, {side, side, side});
      r.source = 1e6;
      r.from = 0.25;
      r.until = 0.30;
      require(w.add_heat_region(r));
      for (double t = 0; t < 0.5 - 1e-9; t += dt) {
        if (!budget) {
          require(w.step(dt));
          continue;
        }
        const auto done = w.step_within(dt, 1e6);
        ASSERT_TRUE(done) << done.error().message;
        EXPECT_EQ(done->simulated, dt);
        EXPECT_EQ(done->substeps, done->planned);
      }
      EXPECT_NEAR(w.totals()->heat_in, 50, 5e-5) << dt;
    }
}

// A region of a held temperature that begins within a step has set its particles at the end of it, and lets go of them at its own.
TEST(LongSteps, ARegionHoldsFromItsBeginningToItsEnd) {
  MELTSIM_NEEDS_BACKEND();
  World w = cube(true);
  HeatRegionDesc r;
  r.shape = Shape::box({0, 0, 0}, {side, side, side});
  r.temperature = 200;
  r.from = 0.25;
  r.until = 0.5;
  require(w.add_heat_region(r));
  require(w.step(1));
  EXPECT_NEAR(w.totals()->heat_in, 1000 * (200 - 20), 1);  // 2 kg of 500 J/(kg K) from 20 degrees
}

// 3 m/s^2 for 0.05 s, twice: the body goes on at 0.3 m/s. A sub-step more or less would be 2e-4 m/s; velocities add up in single precision.
TEST(LongSteps, AForceFieldActsFromItsBeginningToItsEnd) {
  MELTSIM_NEEDS_BACKEND();
  for (const double dt : {0.4, 0.15}) {
    World w = cube(false, Motion::rigid);
    for (const double from : {0.1, 0.25}) {
      ForceFieldDesc f;
      f.acceleration = {3, 0, 0};
      f.from = from;
      f.until = from + 0.05;
      require(w.add_force_field(f));
    }
    for (double t = 0; t < 0.4 - 1e-9; t += dt) require(w.step(dt));
    EXPECT_FALSE(w.synchronize().halted);
    EXPECT_NEAR((*w.pieces())[0].velocity.x, 0.3, 1e-5) << dt;
  }
}

/// What a bar of ice on a wall of 60 degrees holds after some steps, and the range of its temperatures in all of them.
struct Melted {
  double heat = 0, least = 1e9, most = -1e9;
  int stages = 0;
};
Melted melted(double time, int steps) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 0.2;  // long steps, though something may move once it has melted
  d.domain.bounded = true;
  d.domain.max = {20 * dx, 8 * dx, 8 * dx};
  d.domain.faces = {Face::wall, Face::wall, Face::periodic, Face::periodic, Face::periodic, Face::periodic};
  d.heat.time_scale = 2e4;
  World w = std::move(*World::create(d));
  SurfaceHeatDesc hot;
  hot.temperature = 60;
  require(w.set_wall_heat(0, hot));
  MaterialDesc m;
  m.name = "water";
  m.conductivity = 0.6;
  m.heat_capacity = 4186;
  m.viscosity = 0.1;
  const MaterialId water = *w.add_material(m);
  m.name = "ice";
  m.conductivity = 2.2;
  m.heat_capacity = 2100;
  m.melting_point = 0;
  m.latent_heat = 3.34e5;
  m.melts_into = water;
  SolidDesc s;
  s.material = *w.add_material(m);
  s.shape = Shape::box({0, 0, 0}, d.domain.max);
  s.temperature = -20;
  s.fixed = true;
  require(w.add_solid(s));
  Melted out;
  for (int k = 0; k < steps; ++k) {
    require(w.step(time / steps));
    const ParticleData p = *w.particles();
    const auto range = std::minmax_element(p.temperature.begin(), p.temperature.end());
    out.least = std::min(out.least, *range.first);
    out.most = std::max(out.most, *range.second);
  }
  out.heat = w.totals()->heat_in;
  out.stages = w.resolved().heat_stages;
  return out;
}

// A slab at 300 degrees whose one face is held at 100: the mean of what it lacks is 200 (1/2 - sum over odd n of 4/(n pi)^2
// exp(-n^2 pi^2 D t/L^2)). Liquid that nothing drives takes sub-steps of 0.1 s, in a time lapse 0.3 of L^2/D, and heat that is as right as a body's, to 1 %: of the
// walls, whose particles lie half a spacing in, 0.4 %.
TEST(LongSteps, LiquidThatNothingDrivesConductsAsBodiesDo) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double pi = 3.14159265358979323846, length = 0.12, density = 2400, capacity = 1000, k = 95;
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.domain.bounded = true;
  d.domain.max = {0.06, length, 0.06};
  d.domain.heat[2].temperature = 100;
  d.domain.heat[3].temperature = 300;
  d.heat.time_scale = 1150;
  World w = std::move(*World::create(d));
  MaterialDesc m;
  m.name = "metal";
  m.density = density;
  m.heat_capacity = capacity;
  m.conductivity = k;
  FluidDesc f;
  f.material = *w.add_material(m);
  f.shape = Shape::box({0, 0, 0}, {0.06, length, 0.06});
  f.temperature = 300;
  require(w.add_fluid(f));
  for (int step = 1; step <= 3; ++step) {
    require(w.step(0.1));
    double lacks = 0.5;
    for (int n = 1; n < 20; n += 2)
      lacks -= 4 / (n * n * pi * pi) *
               std::exp(-n * n * pi * pi * k / (density * capacity) * 115 * step / (length * length));
    const double exact = -200 * lacks * density * capacity * length * 0.06 * 0.06;
    EXPECT_NEAR(w.totals()->heat_in, exact, 0.01 * -exact) << step;
  }
}

// Heat flows from warm to cold, so that nothing gets warmer than the wall or colder than the ice, and a step 20 times as long comes to the
// same heat but for the error of its integrator, of first order (5 %): 4 dx^2/alpha of ice per sub-step. With 64 stages a particle read 98
// degrees and the first step took 74 % too much.
TEST(LongSteps, WhatMeltsKeepsTheRangeOfWhatIsAround) {
  MELTSIM_NEEDS_BACKEND();
  const Melted exact = melted(0.1, 100), coarse = melted(0.1, 5);
  EXPECT_GT(coarse.stages, 2);  // or it is no long step
  for (const Melted& m : {exact, coarse}) {
    EXPECT_GE(m.least, -20 - 1e-3);
    EXPECT_LE(m.most, 60 + 1e-3);
  }
  EXPECT_NEAR(coarse.heat, exact.heat, 0.07 * exact.heat);
}

}  // namespace
}  // namespace meltsim_test
