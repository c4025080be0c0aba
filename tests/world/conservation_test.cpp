// SPDX-License-Identifier: Apache-2.0
// Mass, momentum and energy through complete melting.
#include <cmath>
#include <map>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

TEST(Conservation, MassOfEveryParticleKeepsItsBitsThroughMelting) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  const auto before = *s.world.particles();
  melt(s.world, 0.005, 10);
  const auto after = *s.world.particles();
  EXPECT_EQ(s.world.synchronize().solid, 0u);
  ASSERT_EQ(before.id, after.id);
  EXPECT_EQ(before.mass, after.mass);  // bit for bit
}

TEST(Conservation, EnthalpyOfAnInsulatedTankIsConstantThroughMelting) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision p : {Precision::single_precision, Precision::double_precision}) {
    WorldDesc d = describe();
    d.precision = p;
    Scene s = ice_in_water(d);
    const double before = s.world.totals()->thermal;
    melt(s.world, 0.005, 10);
    const Totals after = *s.world.totals();
    EXPECT_EQ(after.solid, 0u);
    EXPECT_EQ(after.melted, 27u);
    // The ledger in a closed box, 1e-6 in float, 1e-12 in double.
    EXPECT_NEAR(after.thermal / before, 1.0, p == Precision::single_precision ? 1e-6 : 1e-12);
  }
}

World without_gravity() {
  WorldDesc d = describe();
  d.gravity = {0, 0, 0};
  d.spacing = 0.2;
  d.sound_speed = 20;
  auto world = World::create(d);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

/// The sum of |m v|, against which rounding is measured.
double momentum_scale(World& world) {
  double scale = 0;
  const auto p = *world.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i) scale += p.mass[i] * length(p.velocity[i]);
  return scale;
}

TEST(Conservation, MomentumOfLiquidAndSolidWithoutGravityIsConstant) {
  MELTSIM_NEEDS_BACKEND();
  World world = without_gravity();
  const auto water = *world.add_material({});
  MaterialDesc wood;
  wood.name = "wood";
  wood.density = 300;
  const auto m = *world.add_material(wood);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {2, 1, 1});
  f.material = water;
  f.velocity = {0.5, 0, 0};
  require(world.add_fluid(f));
  SolidDesc b;
  b.shape = Shape::box({2, 0.2, 0.2}, {2.6, 0.8, 0.8});
  b.material = m;
  b.velocity = {-1.0, 0.1, 0};
  b.angular_velocity = {0, 0, 1};
  require(world.add_solid(b));
  const Totals before = *world.totals();
  const double scale = momentum_scale(world);
  for (int k = 0; k < 400; ++k) require(world.step(0.0025));
  ASSERT_FALSE(world.synchronize().halted);
  const Totals after = *world.totals();
  // Every pair force is exactly antisymmetric; what is left is the rounding of 400 velocity sums in float.
  EXPECT_LT(length(after.momentum - before.momentum) / scale, 1e-6);
  EXPECT_GT(length(after.solid_center - before.solid_center), 0.02);  // they did meet
}

// Where there is one liquid alone, forces do not ask a neighbour what it is. A World has to know of the second one
// however it comes: with the viscosity of its own liquid alone, either end of a pair would feel another force.
TEST(Conservation, MomentumOfTwoLiquidsIsConstantHoweverTheSecondOneComes) {
  MELTSIM_NEEDS_BACKEND();
  for (const char* comes : {"poured", "melted", "emitted"}) {
    SCOPED_TRACE(comes);
    const std::string way = comes;
    World world = without_gravity();
    MaterialDesc oil;
    oil.name = "oil";
    oil.density = 800;
    oil.viscosity = 100;
    const auto water = *world.add_material({}), second = *world.add_material(oil);
    FluidDesc f;
    f.shape = Shape::box({0, 0, 0}, {2, 1, 1});
    f.material = water;
    f.temperature = 20;
    require(world.add_fluid(f));
    f.shape = Shape::box({2, 0, 0}, {3, 1, 1});
    f.velocity = {-1, 0.3, 0};
    if (way == "poured") {
      f.material = second;
      require(world.add_fluid(f));
    } else if (way == "melted") {
      MaterialDesc wax;
      wax.name = "wax";
      wax.density = 800;
      wax.melting_point = 20;
      wax.melts_into = second;
      SolidDesc b;
      b.material = *world.add_material(wax);
      b.shape = f.shape;
      b.velocity = f.velocity;
      b.temperature = 20;
      require(world.add_solid(b));
      MaterialDesc stone;  // once nothing is solid any more, a World looks again
      stone.name = "stone";
      b.material = *world.add_material(stone);
      b.shape = Shape::box({10, 0, 0}, {10.4, 0.4, 0.4});
      b.velocity = {};
      require(world.add_solid(b));
    } else {
      EmitterDesc e;
      e.material = second;
      e.center = {2.4, 0.5, 0.5};
      e.axis = {-1, 0.3, 0};
      e.radius = 0.4;
      e.speed = 1;
      e.until = 0.02;  // let go within the 0.45 s below: a nozzle holds what it emits for two spacings
      e.temperature = 20;
      require(world.add_emitter(e));
    }
    for (int k = 0; k < 180; ++k)
      require(world.step(0.0025));  // what is emitted has been, what melts is liquid
    ASSERT_EQ(world.synchronize().solid, way == "melted" ? 8u : 0u);
    const Totals before = *world.totals();
    const double scale = momentum_scale(world);
    for (int k = 0; k < 200; ++k) require(world.step(0.0025));
    const StepResult r = world.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    // As above.
    EXPECT_LT(length(world.totals()->momentum - before.momentum) / scale, 1e-6);
  }
}

TEST(Conservation, ABodyInFreeFlightKeepsMomentumAndSpin) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.gravity = {0, 0, 0};
  auto world = World::create(d);
  ASSERT_TRUE(world);
  MaterialDesc m;
  m.name = "stone";
  const auto stone = *world->add_material(m);
  SolidDesc b;
  b.shape = Shape::box({0, 0, 0}, {0.8, 0.6, 1.2});
  b.material = stone;
  b.velocity = {0.3, -0.2, 0.1};
  b.angular_velocity = {0.5, 1.0, -0.7};
  require(world->add_solid(b));
  const Totals before = *world->totals();
  const Vec3d spin_before = before.angular_momentum - cross(before.solid_center, before.momentum);
  for (int k = 0; k < 10000; ++k) require(world->step(0.001));  // 1e4 steps: the drift a long run would see
  const Totals after = *world->totals();
  const Vec3d spin_after = after.angular_momentum - cross(after.solid_center, after.momentum);
  EXPECT_LT(length(after.momentum - before.momentum) / length(before.momentum), 1e-5);
  EXPECT_LT(length(spin_after - spin_before) / length(spin_before), 1e-4);
}

TEST(Conservation, MeltingStartsOutsideAndEveryParticleLeavesOnce) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.block = 5;  // depths 0, 1 and 2
  scene.depth = 2.2;
  scene.block_floor = 0.8;  // in a hot bath from all sides
  scene.box = 2.6;
  Scene s = ice_in_water(describe(), scene);
  const auto first = *s.world.lattice();
  std::vector<int> melted_at(first.live.size(), -1);
  for (int k = 1; k <= 4000; ++k) {
    const auto before = *s.world.lattice();
    require(s.world.step(0.005));
    ASSERT_FALSE(s.world.synchronize().halted);
    const auto now = *s.world.lattice();
    bool any = false;
    for (std::size_t v = 0; v < now.live.size(); ++v) {
      any = any || now.live[v];
      if (now.live[v] || !before.live[v]) continue;
      melted_at[v] = k;
      int direct = 0;
      for (int n = 0; n < 27; ++n) direct += before.arrayN[v * 27 + static_cast<std::size_t>(n)] != 0;
      EXPECT_LT(direct, 27) << "an internal particle melted";  // exact: no IBP ever melts
    }
    if (!any) break;
  }
  for (const int k : melted_at) EXPECT_GT(k, 0);
}

}  // namespace
}  // namespace meltsim_test
