// SPDX-License-Identifier: Apache-2.0
// Liquids that yield, thin and thicken, in a World: profiles in channels, what a heap comes to rest at, what they share with
// other liquids, and what a host may get wrong.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.01, speed = 0.1;

struct Channel {
  World world;
  int layers;
  double plug, index, dt;  ///< plug: half-width over that of the channel
};

/// Driven along x between two plates `layers` spacings apart, periodic otherwise, so that the exact profile is `speed` fast in
/// the middle: u = n/(n+1) (f/K)^(1/n) ((h-y0)^(1+1/n) - (y-y0)^(1+1/n)) outside the plug, y0 = tau_y/f. sigma: nu dt/dx^2 at
/// the mean shear rate and the acoustic step.
Channel channel(int layers, double index, double plug, double sigma, double regularisation = 100,
                Viscosity how = Viscosity::automatic, Precision precision = Precision::single_precision) {
  WorldDesc d = describe();
  d.viscosity = how;
  d.precision = precision;
  d.spacing = dx;
  d.sound_speed = 20 * speed;
  d.domain.bounded = true;
  d.domain.max = {8 * dx, layers * dx, 8 * dx};
  d.domain.faces = {Face::periodic, Face::periodic, Face::wall, Face::wall, Face::periodic, Face::periodic};
  const double dt = 0.4 * 2.5 * dx / d.sound_speed, h = 0.5 * layers * dx;
  MaterialDesc m;
  m.name = "paste";
  m.viscosity = 1000 * sigma * dx * dx / dt / std::pow(speed / h, index - 1);
  const double f =
      m.viscosity * std::pow(speed * (index + 1) / index / std::pow((1 - plug) * h, 1 + 1 / index), index);
  m.flow_index = index;
  m.yield_stress = plug * h * f;
  m.regularisation = regularisation;
  d.gravity = {f / 1000, 0, 0};
  auto w = World::create(d);
  require(w);
  FluidDesc fluid;
  const auto id = w->add_material(m);
  require(id);
  fluid.material = *id;
  fluid.shape = Shape::box({0, 0, 0}, d.domain.max);
  require(w->add_fluid(fluid));
  return {std::move(*w), layers, plug, index, dt};
}

void run(Channel& c, int steps) {
  for (int k = 0; k < steps; ++k) require(c.world.step(c.dt));
  const StepResult s = c.world.synchronize();
  ASSERT_FALSE(s.halted) << s.halt_reason;
  EXPECT_FALSE(s.viscous_bound_exceeded);
}

struct Profile {
  double error = 0;   ///< largest, over the exact speed in the middle
  double middle = 0;  ///< speed of the plug, of the exact one
  double plug =
      0;  ///< half-width over that of the channel, from the line that the root of u_plug - u lies on
};
Profile profile(Channel& c) {
  const ParticleData p = *c.world.particles();
  const auto n = static_cast<std::size_t>(c.layers);
  std::vector<double> u(n), count(n);
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const auto b = static_cast<std::size_t>(std::clamp(p.position[i].y / dx, 0.0, c.layers - 1.0));
    u[b] += p.velocity[i].x / speed;
    count[b] += 1;
  }
  Profile r;
  double ys = 0, qs = 0, yy = 0, yq = 0, points = 0;
  const double power = 1 + 1 / c.index;
  for (std::size_t b = 0; b < n; ++b) r.middle = std::max(r.middle, u[b] /= count[b]);
  for (std::size_t b = 0; b < n; ++b) {
    const double y = std::fabs((double(b) + 0.5) / (0.5 * c.layers) - 1);
    const double exact = y < c.plug ? 1 : 1 - std::pow((y - c.plug) / (1 - c.plug), power);
    r.error = std::max(r.error, std::fabs(u[b] - exact));
    const double lag = 1 - u[b] / r.middle, q = std::pow(lag, 1 / power);
    if (lag < 0.1 || lag > 0.9) continue;
    ys += y, qs += q, yy += y * y, yq += y * q, points += 1;
  }
  const double slope = (points * yq - ys * qs) / (points * yy - ys * ys);
  r.plug = (slope * ys - qs) / (points * slope);
  return r;
}

// A power law: 20 layers and 6 times h^2/nu, as velocities approach the profile with n times the viscosity. The 2 % asked of
// liquids with a constant viscosity; a parabola would be off by 15 and 7 %.
TEST(FlowCurve, PowerLawsInAChannel) {
  MELTSIM_NEEDS_BACKEND();
  for (const double index : {0.5, 1.5}) {
    Channel c = channel(20, index, 0, 10);
    ASSERT_EQ(c.world.resolved().viscosity, Viscosity::implicit);
    run(c, 60);
    const Profile p = profile(c);
    EXPECT_LT(p.error, 0.02) << index;
  }
}

// A Bingham liquid, plug of half the channel. The kernel smears the shear rate across the edge of the plug, which moves it by a third
// of a spacing: 12 layers leave 0.05 of the width and 5 % of the speed, twice the layers less than half (docs/validation.md has 20 to 80).
TEST(FlowCurve, ABinghamLiquidMovesAsAPlug) {
  MELTSIM_NEEDS_BACKEND();
  double error = 1, width = 1;
  for (const int layers : {12, 24}) {
    Channel c = channel(layers, 1, 0.5, 2, 100);
    run(c, layers * layers / 4);
    const Profile p = profile(c);
    EXPECT_NEAR(p.middle, 1, layers == 12 ? 0.06 : 0.025);
    EXPECT_NEAR(p.plug, 0.5, layers == 12 ? 0.07 : 0.03);
    EXPECT_LT(p.error, 0.65 * error) << layers;  // first order would be 0.5
    EXPECT_LT(std::fabs(p.plug - 0.5), 0.65 * width) << layers;
    error = p.error;
    width = std::fabs(p.plug - 0.5);
  }
}

// Below the yield stress nothing flows: the plug is as wide as the channel. The speed is that at which it creeps, tau/(tau_y
// m) over the half-width: here at most h/m = 0.001 m/s.
TEST(FlowCurve, WhatDoesNotYieldCreeps) {
  MELTSIM_NEEDS_BACKEND();
  Channel c = channel(20, 1, 0.5, 1);
  require(c.world.set_gravity(c.world.desc().gravity * 0.45));  // tau_y is 0.5 f h
  run(c, 40);
  const double fastest = c.world.totals()->max_speed;
  EXPECT_LT(fastest, 0.001);
  EXPECT_GT(fastest, 1e-5);
}

// Explicit and implicit viscosity have the same viscosities: after the same short steps of the explicit one the same flow, within
// 1 % of its speed: on a lattice that has hardly moved the stages have 1.5 % less viscosity than in flow (ImplicitViscosity). 0.5 % was
// found.
TEST(FlowCurve, ExplicitAndImplicitViscosityAgree) {
  MELTSIM_NEEDS_BACKEND();
  Channel a = channel(12, 0.6, 0.3, 0.05, 20, Viscosity::explicit_),
          b = channel(12, 0.6, 0.3, 0.05, 20, Viscosity::implicit);
  const double dt = a.world.resolved().stable_dt;
  for (int k = 0; k < 200; ++k) {
    require(a.world.step(dt));
    require(b.world.step(dt));
  }
  const ParticleData p = *a.world.particles(), q = *b.world.particles();
  double worst = 0, fastest = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    worst = std::max(worst, length(p.velocity[i] - q.velocity[i]));
    fastest = std::max(fastest, length(p.velocity[i]));
  }
  EXPECT_GT(fastest, 0.001 * speed);
  EXPECT_LT(worst, 0.01 * fastest);
}

// A flow curve that is Newtonian in effect is the Newtonian liquid: K and n = 1 with a yield stress of next to nothing.
TEST(FlowCurve, WithoutYieldStressIsTheNewtonianLiquid) {
  MELTSIM_NEEDS_BACKEND();
  Channel a = channel(12, 1, 0, 5), b = channel(12, 1, 1e-9, 5);
  run(a, 40);
  run(b, 40);
  const ParticleData p = *a.world.particles(), q = *b.world.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i)
    EXPECT_LT(length(p.velocity[i] - q.velocity[i]), 1e-4 * speed);
}

// What no material asks for is not there: stage, viscosities per particle.
TEST(FlowCurve, CostsNothingWhereNoLiquidHasOne) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool shears : {false, true}) {
    Channel c = channel(12, shears ? 0.9 : 1, 0, 1);
    const Plan plan = c.world.plan();
    for (const StageReport& s : plan.stages)
      if (s.name == "sph.strain" || s.name == "sph.viscosity") {
        EXPECT_EQ(s.runs, shears) << s.name;
      }
    for (const ChannelReport& r : plan.channels)
      if (r.name == "viscosity" || r.name == "properties") {
        EXPECT_EQ(r.bytes > 0, shears) << r.name;
      }
  }
}

// The viscosity at rest, tau_y m + K m^(1-n), is what the explicit step is made for.
TEST(FlowCurve, TheStepAllowsForTheViscosityAtRest) {
  MELTSIM_NEEDS_BACKEND();
  const auto limit = [](double viscosity, double yield, double index, double m) {
    auto w = World::create(describe());
    require(w);
    MaterialDesc d;
    d.viscosity = viscosity;
    d.yield_stress = yield;
    d.flow_index = index;
    d.regularisation = m;
    FluidDesc f;
    f.material = *w->add_material(d);
    f.shape = Shape::box({0, 0, 0}, {0.5, 0.5, 0.5});
    require(w->add_fluid(f));
    return w->resolved().viscous_dt;
  };
  const double newtonian = limit(1, 0, 1, 100);
  EXPECT_NEAR(limit(2, 5, 1, 40), newtonian / 202, 1e-9 * newtonian);
  EXPECT_NEAR(limit(2, 0, 0.5, 100), newtonian / 20, 1e-9 * newtonian);
  EXPECT_NEAR(limit(2, 0, 1, 40), newtonian / 2, 1e-9 * newtonian);
}

// Viscosities follow from the state alone: a World that is restored goes on with the same bits.
TEST(FlowCurve, ARestoredWorldGoesOnWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  Channel a = channel(12, 0.7, 0.3, 5), b = channel(12, 0.7, 0.3, 5);
  run(a, 10);
  const auto snapshot = a.world.snapshot();
  require(snapshot);
  require(b.world.restore(snapshot->data(), snapshot->size()));
  run(a, 10);
  run(b, 10);
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
}

// mu(T) is that of the consistency: twice as thick where it is colder, by the table, and as if it were given as a constant.
TEST(FlowCurve, TablesOfViscosityAreTheConsistency) {
  MELTSIM_NEEDS_BACKEND();
  const auto hash = [](bool table) {
    WorldDesc d = describe();
    d.spacing = dx;
    d.sound_speed = 2;
    d.domain.bounded = true;
    d.domain.max = {0.1, 0.1, 0.1};
    auto w = World::create(d);
    require(w);
    MaterialDesc m;
    m.viscosity = 4;
    m.yield_stress = 10;
    m.flow_index = 0.8;
    if (table) m.viscosity_points = {{0, 6}, {50, 2}};
    FluidDesc f;
    f.material = *w->add_material(m);
    f.temperature = 25;
    f.shape = Shape::box({0, 0, 0}, {0.05, 0.08, 0.1});
    require(w->add_fluid(f));
    // The table allows for 6 Pa s: the same steps are given to both.
    for (int k = 0; k < 20; ++k) require(w->step(2e-3));
    return w->synchronize().max_speed;
  };
  // 1e-3: 6 Pa s may take more stages than 4.
  EXPECT_NEAR(hash(true), hash(false), 1e-3 * hash(false));
}

/// How far a block of 5 by 8 spacings has slumped after a while [m], at a temperature.
double slumped(double temperature, double yield, std::vector<PropertyPoint> points) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.sound_speed = 8;
  d.domain.bounded = true;
  d.domain.no_slip = true;
  d.domain.max = {0.2, 0.1, 0.08};
  d.domain.faces = {Face::wall, Face::wall, Face::wall, Face::wall, Face::periodic, Face::periodic};
  auto w = World::create(d);
  require(w);
  MaterialDesc m;
  m.viscosity = 1;
  m.yield_stress = yield;
  m.yield_stress_points = std::move(points);
  m.regularisation = 10;
  FluidDesc f;
  f.material = *w->add_material(m);
  f.temperature = temperature;
  f.shape = Shape::box({0, 0, 0}, {0.05, 0.08, 0.08});
  require(w->add_fluid(f));
  for (int k = 0; k < 100; ++k) require(w->step(2.5e-3));
  EXPECT_FALSE(w->synchronize().halted);
  double reach = 0;
  const ParticleData p = *w->particles();
  for (const Vec3d& x : p.position) reach = std::max(reach, x.x);
  return reach - 0.045;
}

// 300 Pa hold a bank of 0.06 m, 1 Pa of 0.2 mm: cold it stands, warm it runs, and in between it does what the table says, as if that
// were given as a constant (1e-2: the table allows for 300 Pa, in more stages).
TEST(FlowCurve, YieldStressFollowsTemperature) {
  MELTSIM_NEEDS_BACKEND();
  const std::vector<PropertyPoint> points{{20, 300}, {40, 0}};
  const double cold = slumped(10, 0, points), warm = slumped(50, 0, points), between = slumped(30, 0, points);
  EXPECT_LT(cold, dx);
  EXPECT_GT(warm, 6 * dx);
  EXPECT_GT(between, cold);
  EXPECT_LT(between, warm);
  EXPECT_NEAR(between, slumped(30, 150, {}), 1e-2 * between);
  EXPECT_NEAR(warm, slumped(30, 0, {}), 0.1 * warm);
}

TEST(FlowCurve, BadInputIsRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(describe());
  require(w);
  const MaterialId water = *w->add_material({});
  const auto refuses = [&](const char* field, const std::function<void(MaterialDesc&)>& change) {
    MaterialDesc m;
    m.name = "paste";
    m.yield_stress = 10;
    change(m);
    const auto id = w->add_material(m);
    ASSERT_FALSE(id) << field;
    EXPECT_EQ(id.error().message.find(std::string("material \"paste\": ") + field), 0u) << id.error().message;
  };
  const double nan = std::nan("");
  refuses("yield_stress:", [](MaterialDesc& m) { m.yield_stress = -1; });
  refuses("yield_stress:", [&](MaterialDesc& m) { m.yield_stress = nan; });
  refuses("yield_stress_points: temperatures must ascend", [](MaterialDesc& m) {
    m.yield_stress_points = {{40, 1}, {20, 2}};
  });
  refuses("yield_stress_points: must be 2..8", [](MaterialDesc& m) { m.yield_stress_points = {{40, 1}}; });
  refuses("yield_stress_points: values", [](MaterialDesc& m) {
    m.yield_stress_points = {{40, 1}, {50, -2}};
  });
  refuses("yield_stress_points: values", [&](MaterialDesc& m) {
    m.yield_stress_points = {{40, nan}, {50, 2}};
  });
  refuses("regularisation:", [](MaterialDesc& m) {
    m.yield_stress_points = {{40, 9}, {50, 0}}, m.regularisation = 0;
  });
  refuses("yield_stress_points:", [&](MaterialDesc& m) {
    m.yield_stress_points = {{40, 9}, {50, 0}}, m.melts_into = water, m.melting_point = 0;
  });
  refuses("flow_index: must be in 0.1..3, got 0", [](MaterialDesc& m) { m.flow_index = 0; });
  refuses("flow_index:", [](MaterialDesc& m) { m.flow_index = -0.5; });
  refuses("flow_index:", [&](MaterialDesc& m) { m.flow_index = nan; });
  refuses("flow_index:", [](MaterialDesc& m) { m.flow_index = 5; });
  refuses("regularisation:", [](MaterialDesc& m) { m.regularisation = 0; });
  refuses("regularisation:", [&](MaterialDesc& m) { m.regularisation = infinity; });
  refuses("regularisation:",
          [](MaterialDesc& m) { m.yield_stress = 0, m.flow_index = 0.5, m.regularisation = -1; });
  refuses("yield_stress:", [&](MaterialDesc& m) { m.melts_into = water, m.melting_point = 0; });
  refuses("yield_stress:", [&](MaterialDesc& m) { m.dissolves_in = water, m.diffusivity_in = 1e-9; });
  // Without either, the time means nothing.
  MaterialDesc m;
  m.name = "oil";
  m.regularisation = 0;
  require(w->add_material(m));
}

}  // namespace
}  // namespace meltsim_test
