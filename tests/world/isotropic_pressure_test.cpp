// SPDX-License-Identifier: Apache-2.0
// Isotropic pressure: liquid under pressure shears as its viscosity says, momentum stays what it is, and what would gain motion is
// refused. What walls and bodies carry is in load_test.cpp, other directions and units in invariance_test.cpp.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Share that is left after two seconds of a wave u_x(z) = U sin(2 pi z/L) in a tank with periodic sides, whose liquid is under
/// the pressure of its weight, below the upper four layers. 12 layers and a wave of 12 spacings: the fewest that
/// are deep and smooth; U = c/110: slow flow shows it most.
double left_of_wave(bool isotropic, double viscosity) {
  constexpr int n = 12;
  constexpr double dx = 0.05, L = n * dx, speed = 0.3;
  WorldDesc d = describe();
  d.spacing = dx;
  d.artificial_viscosity = 0;
  d.isotropic_pressure = isotropic;
  d.hydrostatic_start = false;  // at rest from the start 0.71 of the right wave is left without the option
  d.max_substeps = 2000;
  d.domain.bounded = true;
  d.domain.max = {L, 1.5 * L, L};
  d.domain.faces = {Face::periodic, Face::periodic, Face::wall, Face::wall, Face::periodic, Face::periodic};
  d.domain.no_slip = false;
  World world = *World::create(d);
  MaterialDesc water;
  water.viscosity = 1000 * viscosity;
  const MaterialId id = *world.add_material(water);
  for (int k = 0; k < n; ++k) {
    FluidDesc layer;
    layer.shape = Shape::box({0, 0, k * dx}, {L, L, (k + 1) * dx});
    layer.material = id;
    layer.velocity = {speed * std::sin(2 * pi * (k + 0.5) / n), 0, 0};
    require(world.add_fluid(layer));
  }
  const auto amplitude = [&] {
    const ParticleData p = *world.particles();
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      if (p.position[i].y > L - 4 * dx) continue;
      sum += 2 * p.velocity[i].x * std::sin(2 * pi * p.position[i].z / L);
      ++count;
    }
    return sum / count;
  };
  const double before = amplitude();
  require(world.step(2));
  return amplitude() / before;
}

TEST(IsotropicPressure, LiquidUnderPressureShearsAsItsViscositySays) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double viscosity = 0.002, k = 2 * pi / 0.6;   // twice the least that damps
  const double right = std::exp(-2 * viscosity * k * k);  // 0.64
  // A tenth: the lattice breaks first, and 12 particles to a wave resolve its second derivative to 3 %.
  EXPECT_NEAR(left_of_wave(true, viscosity) / right, 1, 0.1);
  EXPECT_LT(left_of_wave(false, viscosity) / right, 0.6);  // the option is what does it
}

TEST(IsotropicPressure, MomentumStaysWhatItIs) {
  MELTSIM_NEEDS_BACKEND();
  // A ball in a stirred box without gravity: momentum. In double: sums of 1,000 particles round to 1e-13.
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = 0.1;
  d.gravity = {0, 0, 0};
  d.isotropic_pressure = true;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  d.domain.faces.fill(Face::periodic);
  d.sound_speed = 20;
  d.max_substeps = 2000;
  World world = *World::create(d);
  MaterialDesc m;
  m.name = "stone";
  m.density = 2000;
  const MaterialId stone = *world.add_material(m), water = *world.add_material({});
  SolidDesc ball;
  ball.shape = Shape::sphere({0.5, 0.5, 0.5}, 0.25);
  ball.material = stone;
  ball.velocity = {0.7, -1, 0.3};
  ball.angular_velocity = {1, 2, 3};
  require(world.add_solid(ball));
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {1, 1, 1});
  f.material = water;
  require(world.add_fluid(f));
  const Vec3d before = world.totals()->momentum;
  require(world.step(0.3));
  const Totals after = *world.totals();
  EXPECT_LT(length(after.momentum - before), 1e-10 * length(before));
  EXPECT_GT(after.kinetic, 0);
}

TEST(IsotropicPressure, WhatWouldGainMotionIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.isotropic_pressure = true;
  d.artificial_viscosity = 0;
  d.domain.bounded = true;
  d.domain.max = {2, 2, 2};
  const auto error_of = [&](double viscosity, double artificial) {
    d.artificial_viscosity = artificial;
    World world = *World::create(d);
    MaterialDesc m;
    m.name = "oil";
    m.viscosity = viscosity;
    FluidDesc f;
    f.shape = Shape::box({0, 0, 0}, {2, 1, 2});
    f.material = *world.add_material(m);
    require(world.add_fluid(f));
    const Status s = world.step(0.001);
    return s ? std::string() : s.error().message;
  };
  const std::string thin = error_of(1e-3, 0);
  EXPECT_NE(thin.find("isotropic_pressure: needs an artificial_viscosity of 0.01"), std::string::npos)
      << thin;
  EXPECT_NE(thin.find("\"oil\""), std::string::npos) << thin;
  EXPECT_EQ(error_of(1e-3, 0.01), "");
  EXPECT_EQ(error_of(200, 0), "");  // its own viscosity does
}

TEST(IsotropicPressure, WhatGetsThinWhileAWorldRunsIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool added : {true, false}) {  // liquid in place, or another viscosity
    WorldDesc d = describe();
    d.isotropic_pressure = true;
    d.artificial_viscosity = 0;
    d.reserved_particles = 1000;
    d.domain.bounded = true;
    d.domain.max = {2, 2, 2};
    World world = *World::create(d);
    MaterialDesc thick, thin;
    thick.name = "syrup";
    thick.viscosity = 200;
    const MaterialId syrup = *world.add_material(thick), oil = *world.add_material(thin);
    FluidDesc f;
    f.shape = Shape::box({0, 0, 0}, {2, 1, 2});
    f.material = syrup;
    require(world.add_fluid(f));
    require(world.step(0.001));
    if (added) {
      f.shape = Shape::box({0, 1, 0}, {2, 1.4, 2});
      f.material = oil;
      require(world.add_fluid(f));
    } else {
      thick.viscosity = 1e-3;
      require(world.set_material(syrup, thick));
    }
    const Status s = world.step(0.001);
    ASSERT_FALSE(s) << added;
    EXPECT_NE(s.error().message.find("isotropic_pressure: needs"), std::string::npos) << s.error().message;
  }
}

/// A tank of water, with what `change` makes of it before it is filled.
World tank(const std::function<void(WorldDesc&, MaterialDesc&)>& change) {
  WorldDesc d = describe();
  d.domain.bounded = true;
  d.domain.max = {2, 2, 2};
  MaterialDesc water;
  change(d, water);
  World world = *World::create(d);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {2, 1, 2});
  f.material = *world.add_material(water);
  f.temperature = 60;
  require(world.add_fluid(f));
  return world;
}

bool is_on(World& world) {
  require(world.prepare());
  for (const StageReport& s : world.plan().stages)
    if (std::string(s.name) == "sph.arrangement") return s.runs;
  return false;
}

SolidDesc cube(World& world, double temperature) {
  MaterialDesc m;
  m.name = "ice";
  m.density = 900;
  m.latent_heat = 1000;
  m.melting_point = 0;
  m.melts_into = MaterialId{0, 1};
  SolidDesc s;
  s.material = *world.add_material(m);
  s.shape = Shape::box({0.8, 1.2, 0.8}, {1.2, 1.6, 1.2});
  s.temperature = temperature;
  return s;
}

TEST(IsotropicPressure, IsOnWhereLiquidFlowsSlowlyUnlessTheHostSaysOtherwise) {
  MELTSIM_NEEDS_BACKEND();
  const auto on = [](const std::function<void(WorldDesc&, MaterialDesc&)>& change) {
    World world = tank(change);
    return is_on(world);
  };
  EXPECT_FALSE(on([](WorldDesc&, MaterialDesc&) {}));
  EXPECT_TRUE(on([](WorldDesc& d, MaterialDesc&) { d.isotropic_pressure = true; }));
  EXPECT_TRUE(on([](WorldDesc&, MaterialDesc& m) { m.yield_stress = 10; }));
  EXPECT_TRUE(on([](WorldDesc&, MaterialDesc& m) { m.surface_tension = 0.07; }));
  EXPECT_TRUE(on([](WorldDesc&, MaterialDesc& m) { m.density_points = {{0, 1000}, {100, 960}}; }));
  EXPECT_FALSE(on([](WorldDesc& d, MaterialDesc& m) {
    d.isotropic_pressure = false;
    m.yield_stress = 10;
  }));
  // What nothing damps is left as it is, not refused.
  EXPECT_FALSE(on([](WorldDesc& d, MaterialDesc& m) {
    d.artificial_viscosity = 0;
    m.surface_tension = 0.07;
  }));
}

// Water on both sides of a held plate, 2 spacings from rest: how far it stands on the other side half a period of a thin tube later, in
// spacings. Legs and the bend below the plate are 4 spacings wide.
double swing_of_a_u_tube(std::optional<bool> isotropic) {
  constexpr double dx = 0.01;
  WorldDesc d = describe();
  d.spacing = dx;
  d.max_substeps = 4000;
  d.isotropic_pressure = isotropic;
  d.domain.bounded = true;
  d.domain.max = {11 * dx, 24 * dx, 8 * dx};
  d.domain.faces[4] = d.domain.faces[5] = Face::periodic;
  d.domain.no_slip = false;
  World world = *World::create(d);
  const MaterialId water = *world.add_material(MaterialDesc{});
  SolidDesc plate;
  plate.material = water;
  plate.fixed = true;
  plate.shape = Shape::box({4 * dx, 4 * dx, 0}, {7 * dx, 24 * dx, 8 * dx});
  require(world.add_solid(plate));
  FluidDesc f;
  f.material = water;
  const double right[] = {4, 7, 11}, top[] = {18, 4, 14};
  for (int k = 0; k < 3; ++k) {
    f.shape = Shape::box({(k == 0 ? 0 : right[k - 1]) * dx, 0, 0}, {right[k] * dx, top[k] * dx, 8 * dx});
    require(world.add_fluid(f));
  }
  const double half_period = pi * std::sqrt((2 * 14 + 7) * dx / (2 * 9.81));
  require(world.step(half_period));
  const ParticleData p = *world.particles();
  double more = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (!is_solid(p.tag[i])) more += p.position[i].x > 5.5 * dx ? 0.5 : -0.5;
  return more / (4 * 8);
}

// A fifth may be lost: a surface is resolved to less than half a spacing. The level of pressure, which without the option acts as
// friction between layers of particles, takes half.
TEST(IsotropicPressure, WaterSwingsAroundAHeldPlate) {
  MELTSIM_NEEDS_BACKEND();
  EXPECT_GT(swing_of_a_u_tube({}), 0.8 * 2);
  EXPECT_LT(swing_of_a_u_tube(false), 0.6 * 2);
}

TEST(IsotropicPressure, IsOnWhereLiquidsOfDifferentDensityMeet) {
  MELTSIM_NEEDS_BACKEND();
  const auto with = [](double density, bool emitted) {
    World world = tank([](WorldDesc&, MaterialDesc&) {});
    MaterialDesc oil;
    oil.name = "oil";
    oil.density = density;
    const MaterialId id = *world.add_material(oil);
    FluidDesc f;
    f.shape = Shape::box({0, 1, 0}, {2, 1.4, 2});
    f.material = id;
    EmitterDesc e;
    e.center = {1, 1.8, 1};
    e.radius = 0.3;
    e.material = id;
    e.max_particles = 100;
    if (emitted) require(world.add_emitter(e));
    else require(world.add_fluid(f));
    return is_on(world);
  };
  EXPECT_FALSE(with(1000, false));
  EXPECT_TRUE(with(850, false));
  EXPECT_FALSE(with(1000, true));
  EXPECT_TRUE(with(850, true));
}

TEST(IsotropicPressure, IsOnWithBodiesAndStaysWhenTheyHaveMelted) {
  MELTSIM_NEEDS_BACKEND();
  const auto with = [](const std::function<void(SolidDesc&)>& change) {
    World world = tank([](WorldDesc& d, MaterialDesc& m) {
      d.heat.time_scale = 1e4;
      m.conductivity = 1;
    });
    SolidDesc s = cube(world, 0);
    change(s);
    require(world.add_solid(s));
    return world;
  };
  World held = with([](SolidDesc& s) { s.fixed = true; });
  EXPECT_TRUE(is_on(held));
  World moved = with([](SolidDesc& s) { s.motion = Motion::kinematic; });
  EXPECT_TRUE(is_on(moved));
  World floating = with([](SolidDesc&) {});
  EXPECT_TRUE(is_on(floating));
  for (int k = 0; k < 400 && floating.synchronize().solid > 0; ++k) require(floating.step(0.01));
  ASSERT_EQ(floating.synchronize().solid, 0u);
  EXPECT_TRUE(is_on(floating));
}

}  // namespace
}  // namespace meltsim_test
