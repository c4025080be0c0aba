// SPDX-License-Identifier: Apache-2.0
// A solid with a given Young's modulus: the modulus holds whatever the step, and changing the step costs
// nothing but time.
#include <algorithm>
#include <cmath>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, density = 1000;

struct Bar {
  World world;
  MaterialId material;
};

/// A bar along x of n x 2 x 2 sites that spins about z, without gravity.
Bar bar(int n, double modulus, double spin, double speed = 0) {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  auto world = World::create(d);
  EXPECT_TRUE(world);
  MaterialDesc m;
  m.name = "solid";
  m.density = density;
  m.youngs_modulus = modulus;
  m.damping = 0;
  const auto material = *world->add_material(m);
  SolidDesc s;
  s.shape = Shape::box({0, 0, 0}, {n * dx, 2 * dx, 2 * dx});
  s.material = material;
  s.angular_velocity = {0, 0, spin};
  s.velocity = {0, 0, speed};
  require(world->add_solid(s));
  return {std::move(*world), material};
}

double distance_of_ends(World& world) {
  const ParticleData p = *world.particles();
  double most = 0;
  for (const Vec3d& x : p.position) most = std::max(most, length(x - p.position[0]));
  return most;
}

// A bar set spinning swings to twice its centrifugal stretch after L/c, half the period of its first mode;
// the parabola through the highest sample and its neighbours finds that time. 40 sites: 10 % of a wave at w =
// 4, the widest region needed here, which slows it by 0.5 %; 5 % of E is 2.5 % of c.
TEST(Stiffness, AModulusHoldsWhateverTheStep) {
  MELTSIM_NEEDS_BACKEND();
  const int n = 40;
  const double speed = 120, L = n * dx;  // 1 ms: w 2, alpha 0.72
  for (const double dt : {0.25e-3, 1e-3, 2e-3}) {
    Bar b = bar(n, density * speed * speed, speed / L * 0.09);
    std::vector<double> stretch;
    while (b.world.time() < 1.5 * L / speed) {
      require(b.world.step(dt));
      stretch.push_back(distance_of_ends(b.world));
    }
    const auto top = std::max_element(stretch.begin() + 1, stretch.end() - 1);
    const double bend = top[-1] - 2 * top[0] + top[1];
    const double at = dt * (1 + double(top - stretch.begin()) + 0.5 * (top[-1] - top[1]) / bend);
    EXPECT_NEAR(L / at / speed, 1, 0.025) << "dt " << dt;
  }
}

// Exact: which width, which alpha, and what is said where it cannot be had.
TEST(Stiffness, RegionsFollowTheStepAndResolvedSaysWhatTheyDeliver) {
  MELTSIM_NEEDS_BACKEND();
  Bar b = bar(6, 1.44e7, 0);                                          // E/(rho dx^2) dt^2 = 1.44 at 1 ms
  EXPECT_EQ(b.world.resolved().stiffness.at(0).youngs_modulus, 0.0);  // no step is known yet
  const auto after = [&](double dt) {
    require(b.world.step(dt));
    const int w = b.world.lattice()->region_half_width;
    const Stiffness s = b.world.resolved().stiffness.at(0);
    EXPECT_EQ(s.region_half_width, w);
    return s;
  };
  const Stiffness narrow = after(1e-3);  // w 2 gives 2
  EXPECT_EQ(narrow.region_half_width, 2);
  EXPECT_NEAR(narrow.stiffness, 0.72, 1e-12);
  EXPECT_NEAR(narrow.youngs_modulus / 1.44e7, 1, 1e-12);
  const Stiffness wide = after(4e-3);  // 23.04; w 8 gives 24
  EXPECT_EQ(wide.region_half_width, 8);
  EXPECT_NEAR(wide.stiffness, 0.96, 1e-12);
  EXPECT_FALSE(b.world.synchronize().modulus_unreachable);
  const Stiffness soft = after(8e-3);
  EXPECT_EQ(soft.stiffness, 1.0);
  EXPECT_NEAR(soft.youngs_modulus, 24 * density * (dx / 8e-3) * (dx / 8e-3), 1);
  EXPECT_TRUE(b.world.synchronize().modulus_unreachable);
  EXPECT_EQ(after(1e-3).region_half_width, 2);
  EXPECT_TRUE(b.world.synchronize().modulus_unreachable);  // the step before was one of them
  EXPECT_FALSE(b.world.synchronize().modulus_unreachable);
}

TEST(Stiffness, WithoutAModulusNothingFollowsTheStep) {
  MELTSIM_NEEDS_BACKEND();
  Bar b = bar(6, 0, 0);
  for (const double dt : {1e-3, 4e-3}) {
    require(b.world.step(dt));
    const Stiffness s = b.world.resolved().stiffness.at(0);
    EXPECT_EQ(s.region_half_width, 2);
    EXPECT_EQ(s.stiffness, 1.0);
    EXPECT_NEAR(s.youngs_modulus, 2 * density * (dx / dt) * (dx / dt), 1);
  }
  EXPECT_FALSE(b.world.synchronize().modulus_unreachable);
}

// Bit for bit: a World that has had wide regions goes on like one that was restored and never had them.
TEST(Stiffness, AChangeOfStepLeavesNoTraceInTheState) {
  MELTSIM_NEEDS_BACKEND();
  Bar a = bar(12, 1.44e7, 3), b = bar(12, 1.44e7, 3);
  for (const double dt : {1e-3, 3e-3, 1e-3})
    for (int k = 0; k < 20; ++k) require(a.world.step(dt));
  const auto snapshot = *a.world.snapshot();
  require(b.world.restore(snapshot.data(), snapshot.size()));
  for (World* w : {&a.world, &b.world})
    for (const double dt : {1e-3, 3e-3})
      for (int k = 0; k < 20; ++k) require(w->step(dt));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_EQ(a.world.steps(), b.world.steps());
}

// What happened before a rebuild is still reported after it: 300 m/s for 1 ms is 1.2 support radii, for 10 us
// not.
TEST(Stiffness, ARebuildForgetsNoFlag) {
  MELTSIM_NEEDS_BACKEND();
  Bar c = bar(6, 1e8, 0, 110);
  require(c.world.step(1e-3));  // w 5
  require(c.world.step(1e-4));  // w 2: rebuilt
  EXPECT_EQ(c.world.lattice()->region_half_width, 2);
  const StepResult r = c.world.synchronize();
  EXPECT_TRUE(r.courant_exceeded);
  EXPECT_NEAR(r.max_speed, 110, 1);
  EXPECT_FALSE(c.world.synchronize().courant_exceeded);
  EXPECT_EQ(r.steps, 2u);
}

// Only materials with a modulus pay for the wide regions' sites, and only bodies of them get wide regions.
TEST(Stiffness, BodiesOfOtherMaterialsKeepTheirRegions) {
  MELTSIM_NEEDS_BACKEND();
  Bar b = bar(4, 1.44e7, 0);
  MaterialDesc m;
  m.name = "other";
  m.region_half_width = 1;
  SolidDesc s;
  s.shape = Shape::box({0, 1, 0}, {8 * dx, 1 + dx, dx});  // a row of eight
  s.material = *b.world.add_material(m);
  require(b.world.add_solid(s));
  require(b.world.step(4e-3));
  const LatticeData l = *b.world.lattice();
  EXPECT_EQ(l.region_half_width, 8);
  const std::size_t box = 17 * 17 * 17;
  std::size_t stiff = 0, other = 0;
  for (std::size_t v = 0; v < l.live.size(); ++v) {
    std::size_t members = 0;
    for (std::size_t k = 0; k < box; ++k) members += l.arrayR[v * box + k] != 0 ? 1u : 0u;
    if (l.body[v] == 1) stiff = std::max(stiff, members);
    else other = std::max(other, members);
  }
  EXPECT_EQ(stiff, 16u);  // all of the bar
  EXPECT_EQ(other, 3u);   // itself and one on each side
}

/// A cube on the floor of a tank with another on top of it, both under water.
World loaded(double modulus) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = {12 * dx, 16 * dx, 12 * dx};
  auto world = World::create(d);
  EXPECT_TRUE(world);
  MaterialDesc m;
  m.name = "stone";
  m.density = 3000;
  m.youngs_modulus = modulus;
  SolidDesc s;
  s.material = *world->add_material(m);
  for (const int y : {0, 4}) {
    s.shape = Shape::box({4 * dx, y * dx, 4 * dx}, {8 * dx, (y + 4) * dx, 8 * dx});
    require(world->add_solid(s));
  }
  FluidDesc f;
  f.material = *world->add_material(MaterialDesc{});
  f.shape = Shape::box({0, 0, 0}, {12 * dx, 10 * dx, 12 * dx});
  require(world->add_fluid(f));
  return std::move(*world);
}

// Goals and contacts hold a load by distances that belong to the steps before. A step that is far shorter may
// not turn those into speeds, distance over dt. Stiffness stops growing at a quarter of the acoustic step, so
// forces are at most 16 times those of long steps: under eight layers of stone 80 g, with a modulus, whose
// regions change their width, 120 g. Floats leave 1e-6 of a few cm/s. At full stiffness it is 11 m/s at 1e-2,
// 114 m/s at 1e-3.
TEST(Stiffness, AShortStepThrowsNothing) {
  MELTSIM_NEEDS_BACKEND();
  for (const double modulus : {0.0, 1e7}) {
    World world = loaded(modulus);
    const double usual = world.resolved().stable_dt;
    for (int k = 0; k < 200; ++k) require(world.step(usual));
    const auto snapshot = *world.snapshot();
    const ParticleData before = *world.particles();
    for (const double share : {0.25, 1e-2, 1e-3, 1e-6}) {
      require(world.restore(snapshot.data(), snapshot.size()));
      require(world.step(share * usual));
      const StepResult r = world.synchronize();
      ASSERT_FALSE(r.halted) << r.halt_reason;
      const ParticleData after = *world.particles();
      double most = 0;
      for (std::size_t i = 0; i < before.id.size(); ++i)
        most = std::max(most, length(after.velocity[i] - before.velocity[i]));
      EXPECT_LT(most, 200 * 9.81 * share * usual + 1e-6) << "share " << share << ", modulus " << modulus;
      // The long steps after it find what they left.
      for (int k = 0; k < 5; ++k) require(world.step(usual));
      EXPECT_LT(world.synchronize().max_speed, 0.5);
    }
  }
}

// The length that springs go by is the scene's, not its history's: bit for bit.
TEST(Stiffness, ARestoredWorldTakesTheSameShortStep) {
  MELTSIM_NEEDS_BACKEND();
  World a = loaded(0), b = loaded(0);
  const double usual = a.resolved().stable_dt;
  for (int k = 0; k < 20; ++k) require(a.step(usual));
  const auto snapshot = *a.snapshot();
  require(b.restore(snapshot.data(), snapshot.size()));
  for (World* w : {&a, &b})
    for (const double share : {1e-3, 1.0, 0.1}) require(w->step(share * usual));
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
}

// What is said of it: the modulus follows the step down to a quarter of the acoustic step.
TEST(Stiffness, TheModulusOfShortStepsIsTheScenes) {
  MELTSIM_NEEDS_BACKEND();
  World world = loaded(0);
  const Resolved r = world.resolved();
  const double reference = 0.4 * r.support_radius / r.sound_speed;
  const auto after = [&](double dt) {
    require(world.step(dt));
    return world.resolved().stiffness.at(0);
  };
  for (const double dt : {0.5 * reference, 0.25 * reference}) {
    const Stiffness s = after(dt);
    EXPECT_NEAR(s.stiffness, 1, 1e-12);
    EXPECT_NEAR(s.youngs_modulus / (2 * 3000 * (dx / dt) * (dx / dt)), 1, 1e-12);
  }
  const Stiffness s = after(0.025 * reference);
  EXPECT_NEAR(s.stiffness, 0.01, 1e-12);
  EXPECT_NEAR(s.youngs_modulus / (2 * 3000 * std::pow(4 * dx / reference, 2)), 1, 1e-12);
}

}  // namespace
}  // namespace meltsim_test
