// SPDX-License-Identifier: Apache-2.0
// The plan follows the scene: what has nothing left to do goes, and comes back. Whether it has gone changes no bit.
#include <functional>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

bool runs(World& w, const std::string& stage) {
  for (const StageReport& s : w.plan().stages)
    if (s.name == stage) return s.runs;
  ADD_FAILURE() << "no stage " << stage;
  return false;
}

bool any_runs(World& w, const std::string& module) {
  bool any = false;
  for (const StageReport& s : w.plan().stages) any = any || (s.module == module && s.runs);
  return any;
}

std::string reason(World& w, const std::string& stage) {
  for (const StageReport& s : w.plan().stages)
    if (s.name == stage) return s.reason;
  return "no stage " + stage;
}

std::uint64_t bytes(World& w, const std::string& channel) {
  for (const ChannelReport& c : w.plan().channels)
    if (c.name == channel) return c.bytes;
  ADD_FAILURE() << "no channel " << channel;
  return 0;
}

std::uint64_t total(World& w) {
  std::uint64_t sum = 0;
  for (const ChannelReport& c : w.plan().channels) sum += c.bytes;
  return sum;
}

using Build = std::function<World()>;

/// The state after so many steps is the same for a host that synchronises after each, whose World changes its plan as soon
/// as it can, for one that never does, and for one that stores and restores on the way, before and after the change.
void expect_one_state(const Build& build, int steps, double dt, std::initializer_list<int> stops) {
  World often = build();
  World never = build();
  for (int k = 1; k <= steps; ++k) {
    require(often.step(dt));
    const StepResult r = often.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    require(never.step(dt));
    for (const int stop : stops) {
      if (k != stop) continue;
      const auto snapshot = never.snapshot();
      ASSERT_TRUE(snapshot);
      World other = build();
      require(other.restore(snapshot->data(), snapshot->size()));
      require(other.prepare());
      never = std::move(other);
    }
  }
  EXPECT_EQ(*often.state_hash(), *never.state_hash());
  EXPECT_EQ(often.time(), never.time());
  EXPECT_EQ(often.stable_dt(), never.stable_dt());
}

/// All melts in half a second.
IceScene quickly() {
  IceScene s;
  s.time_scale = 4e6;
  return s;
}

/// Ice in warm water, and a body of stone that stays.
World ice_and_stone(bool fixed, Precision precision) {
  WorldDesc d = describe();
  d.precision = precision;
  Scene s = ice_in_water(d, quickly());
  MaterialDesc stone;
  stone.name = "stone";
  stone.density = 2500;
  SolidDesc block;
  block.name = "stone";
  block.material = *s.world.add_material(stone);
  block.shape = Shape::box({1.8, 0, 1.8}, {2.2, 0.4, 2.2});
  block.temperature = 80;
  block.fixed = fixed;
  require(s.world.add_solid(block));
  return std::move(s.world);
}

TEST(Needs, TopologyGoesWithTheLastThatCanMeltThoughAStoneStays) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool fixed : {true, false}) {
    World w = ice_and_stone(fixed, Precision::single_precision);
    require(w.prepare());
    EXPECT_TRUE(runs(w, "topology.melt"));
    EXPECT_TRUE(runs(w, "lsm.contact"));
    const std::uint64_t before = total(w);
    for (int k = 0; k < 1000 && w.synchronize().melted < 27; ++k) require(w.step(0.005));
    const StepResult r = w.synchronize();
    ASSERT_EQ(r.melted, 27u);
    EXPECT_EQ(r.solid, 8u);
    EXPECT_FALSE(any_runs(w, "topology")) << fixed;
    EXPECT_EQ(reason(w, "topology.melt"), "everything that can melt has melted");
    EXPECT_EQ(any_runs(w, "lsm"), !fixed);
    EXPECT_FALSE(runs(w, "lsm.contact"));
    if (fixed) {
      EXPECT_EQ(reason(w, "lsm.regions"), "every body that could move has melted");
      EXPECT_EQ(bytes(w, "region_mask"), 0u);
    }
    EXPECT_LT(total(w), before);
    // And it comes back.
    SolidDesc more;
    more.shape = Shape::box({0.4, 1.6, 0.4}, {0.8, 2.0, 0.8});
    more.material = MaterialId{1, 1};
    more.temperature = -10;
    require(w.add_solid(more));
    EXPECT_TRUE(runs(w, "topology.melt"));
    EXPECT_TRUE(runs(w, "lsm.contact"));
    require(w.step(0.005));
    EXPECT_FALSE(w.synchronize().halted);
  }
}

TEST(Needs, MeltingOutLeavesTheSameStateHoweverOftenTheHostLooks) {
  MELTSIM_NEEDS_BACKEND();
  // All has melted after about 95 of these steps; before, about when and long after.
  for (const Precision p : {Precision::single_precision, Precision::double_precision}) {
    for (const bool fixed : {true, false})
      expect_one_state([&] { return ice_and_stone(fixed, p); }, 150, 0.005, {50, 100, 130});
    expect_one_state(
        [&] {
          WorldDesc d = describe();
          d.precision = p;
          return ice_in_water(d, quickly()).world;
        },
        150, 0.005, {50, 100, 130});
  }
}

/// Names of the stages that run.
std::vector<std::string> stages(World& w) {
  std::vector<std::string> names;
  for (const StageReport& s : w.plan().stages)
    if (s.runs) names.push_back(s.name);
  return names;
}

/// Water alone, as much as ice_in_water() has of both, all of one temperature, or not.
World water_alone(bool level, std::uint64_t particles) {
  WorldDesc d = describe();
  d.isotropic_pressure = true;  // what bodies have asked for stays: the flow that they made is still there
  Scene s = ice_in_water(d, [] {
    IceScene i;
    i.water = false;
    i.block = 0;
    return i;
  }());
  FluidDesc f;
  f.material = s.water;
  f.shape = Shape::box({0, 0, 0}, {2.4, 1.0, 2.4});
  f.temperature = 20;
  require(s.world.add_fluid(f));
  FluidDesc more = f;
  more.shape = Shape::box({0, 1.2, 0}, {0.6, 1.8, 0.6});
  more.temperature = level ? 20 : 60;
  require(s.world.add_fluid(more));
  EXPECT_EQ(s.world.totals()->fluid, particles);
  return std::move(s.world);
}

// What has melted, levelled out or ended costs what a World costs that never had it: the same stages, and bytes within 3 %. Then
// something melts, heats or pours again, and again it goes. 720 + 27 particles, so that 3 % of the bytes are less than the lattice
// of one body.
TEST(Needs, WhatIsDoneCostsAsIfItHadNeverBeen_StagesAndBytes) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  World& w = s.world;
  World warm = water_alone(false, 747), level = water_alone(true, 747);
  require(w.prepare());
  const std::vector<std::string> at_first = stages(w);
  const std::uint64_t bytes_at_first = total(w);
  const auto within = [](std::uint64_t a, std::uint64_t b) { return double(a) <= 1.03 * double(b); };
  const auto settle = [&](World& world) {     // no temperature differs by more than the tolerance
    require(world.set_heat_time_scale(2e7));  // ten times as soon
    for (int k = 0; k < 4000 && runs(world, "thermal.exchange"); ++k) {
      require(world.step(0.01));
      static_cast<void>(world.synchronize());
    }
    require(world.set_heat_time_scale(2e6));
  };
  for (int round = 0; round < 2; ++round) {
    while (w.synchronize().solid > 0 && w.time() < 60) require(w.step(0.005));
    ASSERT_EQ(w.synchronize().solid, 0u);
    EXPECT_EQ(stages(w), stages(warm)) << round;
    EXPECT_TRUE(within(total(w), total(warm))) << total(w) << " " << total(warm);
    settle(w);
    EXPECT_EQ(stages(w), stages(level)) << round;
    EXPECT_TRUE(within(total(w), total(level))) << total(w) << " " << total(level);
    // A wall heats, and insulates again.
    SurfaceHeatDesc hot;
    hot.flux = 1000;
    require(w.set_wall_heat(2, hot));
    require(w.step(0.005));
    EXPECT_TRUE(runs(w, "thermal.exchange"));
    EXPECT_TRUE(runs(w, "thermal.boundary"));
    require(w.set_wall_heat(2, {}));
    settle(w);
    EXPECT_EQ(stages(w), stages(level)) << round;
    EXPECT_TRUE(within(total(w), total(level))) << total(w) << " " << total(level);
    if (round == 1) break;
    SolidDesc more;
    more.material = s.ice;
    more.shape = Shape::box({0.8, 1.6, 0.8}, {1.4, 2.2, 1.4});
    more.temperature = -10;
    require(w.add_solid(more));
    EXPECT_EQ(stages(w), at_first);
    EXPECT_GT(double(total(w)), 0.97 * double(bytes_at_first));
    // Who never had it goes on with as many particles.
    for (World* const other : {&warm, &level}) {
      FluidDesc f;
      f.material = MaterialId{0, 1};
      f.shape = more.shape;
      f.temperature = other == &warm ? 60 : 20;
      require(other->add_fluid(f));
    }
  }
}

/// Water at rest, and what pours more of it, or not.
World pouring(bool pours) {
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {1.2, 2.4, 1.2};
  auto w = World::create(d);
  EXPECT_TRUE(w);
  MaterialDesc water;
  water.name = "water";
  FluidDesc pool;
  pool.material = *w->add_material(water);
  pool.shape = Shape::box({0, 0, 0}, {1.2, 0.8, 1.2});
  require(w->add_fluid(pool));
  if (!pours) return std::move(*w);
  EmitterDesc e;
  e.material = pool.material;
  e.center = {0.6, 2, 0.6};
  e.axis = {0, -1, 0};
  e.radius = 0.3;
  e.speed = 1;
  e.temperature = 60;
  e.until = 0.5;
  require(w->add_emitter(e));
  return std::move(*w);
}

// A nozzle brings warm liquid: heat flows from the start, since it is to come, and stops once it has ended and all is level.
TEST(Needs, ANozzleThatHasEndedLeavesTheStagesOfLiquidAlone_Stages) {
  MELTSIM_NEEDS_BACKEND();
  World w = pouring(true), alone = pouring(false);
  require(w.prepare());
  require(alone.prepare());
  EXPECT_TRUE(runs(w, "thermal.exchange"));
  EXPECT_FALSE(runs(w, "thermal.level"));  // while one may pour, temperatures are not looked at
  EXPECT_FALSE(runs(alone, "thermal.exchange"));
  require(w.set_heat_time_scale(1e6));
  for (int k = 0; k < 4000 && (k < 100 || runs(w, "thermal.exchange")); ++k) {  // about 3 s
    require(w.step(0.01));
    ASSERT_FALSE(w.synchronize().halted);
  }
  EXPECT_EQ(stages(w), stages(alone));
}

/// Water over a floor that is open, beside a fixed stone.
World drain() {
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {1.2, 2, 1.2};
  d.domain.faces[2] = Face::open;
  d.heat.time_scale = 1e3;
  auto w = World::create(d);
  EXPECT_TRUE(w);
  MaterialDesc water, stone;
  water.name = "water";
  stone.name = "stone";
  const MaterialId liquid = *w->add_material(water);
  SolidDesc block;
  block.material = *w->add_material(stone);
  block.shape = Shape::box({0, 0.8, 0}, {0.4, 1.2, 0.4});
  block.temperature = 20;
  block.fixed = true;
  require(w->add_solid(block));
  FluidDesc pool;
  pool.material = liquid;
  pool.shape = Shape::box({0.6, 0.2, 0.6}, {1.2, 1, 1.2});
  pool.temperature = 40;
  require(w->add_fluid(pool));
  return std::move(*w);
}

TEST(Needs, LiquidThatHasLeftTakesItsStagesAlong) {
  MELTSIM_NEEDS_BACKEND();
  World w = drain();
  require(w.prepare());
  EXPECT_TRUE(any_runs(w, "sph"));
  const double dt = w.stable_dt();
  for (int k = 0; k < 600 && w.synchronize().fluid > 0; ++k) require(w.step(0.005));
  ASSERT_EQ(w.synchronize().fluid, 0u);
  EXPECT_FALSE(any_runs(w, "sph"));
  EXPECT_EQ(reason(w, "sph.density"), "all liquid has left");
  EXPECT_EQ(bytes(w, "density"), 0u);
  EXPECT_EQ(w.stable_dt(), dt);  // the host may have learned of it sooner or later
  FluidDesc more;
  more.material = MaterialId{0, 1};
  more.shape = Shape::box({0.6, 0.2, 0.6}, {1.2, 1, 1.2});
  require(w.add_fluid(more));
  EXPECT_TRUE(runs(w, "sph.density"));
  require(w.step(0.005));
  EXPECT_FALSE(w.synchronize().halted);
  expect_one_state(drain, 400, 0.005, {50, 300});
}

/// Two halves of a pool that differ by 0.4 degrees, and one that is level at a quarter of that.
World nearly_level(double tolerance) {
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.2, 1.2};
  d.heat.time_scale = 2e6;  // 0.5 s for a difference across the pool to fall to 1/e
  d.heat.level_tolerance = tolerance;
  auto w = World::create(d);
  EXPECT_TRUE(w);
  MaterialDesc water, ice;
  water.name = "water";
  FluidDesc half;
  half.material = *w->add_material(water);
  ice.name = "ice";
  ice.melts_into = half.material;
  ice.melting_point = 60;
  ice.freezes = true;
  SolidDesc block;
  block.material = *w->add_material(ice);
  half.shape = Shape::box({0, 0, 0}, {0.6, 0.8, 1.2});
  half.temperature = 80;
  require(w->add_fluid(half));
  half.shape = Shape::box({0.6, 0, 0}, {1.2, 0.8, 1.2});
  half.temperature = 80.4;
  require(w->add_fluid(half));
  return std::move(*w);
}

TEST(Needs, HeatStopsWhereTemperaturesAreLevelToTheTolerance) {
  MELTSIM_NEEDS_BACKEND();
  World w = nearly_level(0.1);
  require(w.prepare());
  EXPECT_TRUE(runs(w, "thermal.exchange"));
  EXPECT_TRUE(runs(w, "thermal.level"));
  int steps = 0;
  for (; steps < 2000 && any_runs(w, "thermal"); ++steps) {
    require(w.step(0.002));
    w.synchronize();
  }
  ASSERT_FALSE(any_runs(w, "thermal"));
  EXPECT_GT(steps, 64);
  EXPECT_EQ(reason(w, "thermal.exchange"), "temperatures are level to 0.1 K and there is no source");
  EXPECT_EQ(bytes(w, "enthalpy"), 0u);  // by id from here on
  EXPECT_EQ(bytes(w, "heat_operand"), 0u);
  auto t = w.totals();
  EXPECT_LE(t->temperature_max - t->temperature_min, 0.1);
  EXPECT_GT(t->temperature_max - t->temperature_min, 0.05);  // 64 sub-steps are a quarter of that time
  const double low = t->temperature_min, high = t->temperature_max, thermal = t->thermal;
  require(w.step(0.1));
  t = w.totals();
  EXPECT_EQ(t->temperature_min, low);
  EXPECT_EQ(t->temperature_max, high);
  EXPECT_EQ(t->thermal, thermal);
  // Something warm comes.
  FluidDesc drop;
  drop.material = MaterialId{0, 1};
  drop.shape = Shape::box({0.4, 1, 0.4}, {0.6, 1.2, 0.6});
  drop.temperature = 90;
  require(w.add_fluid(drop));
  EXPECT_TRUE(runs(w, "thermal.exchange"));
  require(w.step(0.1));
  EXPECT_GT(w.totals()->temperature_min, low);
}

TEST(Needs, ToleranceZeroLetsHeatFlow) {
  MELTSIM_NEEDS_BACKEND();
  World w = nearly_level(0);
  for (int k = 0; k < 800; ++k) require(w.step(0.002));
  w.synchronize();
  EXPECT_TRUE(runs(w, "thermal.exchange"));
  EXPECT_FALSE(runs(w, "thermal.level"));
}

TEST(Needs, HeatStopsInTheSameSubStepHoweverOftenTheHostLooks) {
  MELTSIM_NEEDS_BACKEND();
  int level_at = 0;
  World w = nearly_level(0.1);
  for (; level_at < 2000; ++level_at) {
    require(w.step(0.002));
    w.synchronize();
    if (!any_runs(w, "thermal")) break;
  }
  ASSERT_LT(level_at, 2000);
  // Before, right before and after it.
  expect_one_state([] { return nearly_level(0.1); }, level_at + 200, 0.002,
                   {level_at / 2, level_at - 3, level_at + 70});
}

/// A pool at one temperature that a region heats from 0.5 s to 0.7 s.
World heated_late(bool ice) {
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.2, 1.2};
  d.heat.time_scale = 1e4;
  auto w = World::create(d);
  EXPECT_TRUE(w);
  MaterialDesc water, solid;
  water.name = "water";
  water.viscosity = 0.5;
  FluidDesc pool;
  pool.material = *w->add_material(water);
  pool.shape = Shape::box({0, 0, 0}, {1.2, 0.6, 1.2});
  pool.temperature = -10;
  require(w->add_fluid(pool));
  solid.name = "ice";
  MaterialDesc melt;
  melt.name = "melt";
  melt.viscosity = 5e3;
  solid.melts_into = *w->add_material(melt);
  solid.melting_point = -9;
  solid.latent_heat = 1e4;
  SolidDesc block;
  block.material = *w->add_material(solid);
  block.shape = Shape::box({0.4, 0.6, 0.4}, {0.8, 1, 0.8});
  block.temperature = -10;
  if (ice) require(w->add_solid(block));
  HeatRegionDesc hot;
  hot.shape = Shape::box({0, 0, 0}, {1.2, 1.2, 1.2});
  hot.source = 1e4;  // 10,000 times as much per second of motion: 2e7 J/m^3, and melting takes 1.4e7
  hot.from = 0.5;
  hot.until = 0.7;
  require(w->add_heat_region(hot));
  return std::move(*w);
}

TEST(Needs, AHeatRegionCostsFromTheTimeItBegins) {
  MELTSIM_NEEDS_BACKEND();
  World w = heated_late(false);
  require(w.prepare());
  EXPECT_FALSE(any_runs(w, "thermal"));
  EXPECT_EQ(w.resolved().heat_stages, 0);
  EXPECT_EQ(bytes(w, "heat_region_cells"), 0u);
  EXPECT_EQ(bytes(w, "heat_boundary"), 0u);
  EXPECT_NE(reason(w, "thermal.exchange").find("no heat region acts before 0.5 s"), std::string::npos)
      << reason(w, "thermal.exchange");
  const std::uint64_t before = total(w);
  const double thermal = w.totals()->thermal;
  for (int k = 0; k < 99; ++k) require(w.step(0.005));
  w.synchronize();
  EXPECT_EQ(total(w), before);
  EXPECT_EQ(w.totals()->thermal, thermal);
  for (int k = 0; k < 10; ++k) require(w.step(0.005));
  w.synchronize();
  EXPECT_TRUE(runs(w, "thermal.boundary"));
  EXPECT_GT(total(w), before);
  for (int k = 0; k < 50; ++k) require(w.step(0.005));
  w.synchronize();
  // 108 particles of 0.008 m^3, 10 kW/m^3 for 0.2 s at 10,000 times the speed: a sub-step more or less at the ends.
  const double in = 108 * 0.008 * 1e4 * 0.2 * 1e4;
  EXPECT_NEAR(w.totals()->heat_in, in, 0.03 * in);
  EXPECT_NEAR(w.totals()->thermal - thermal, w.totals()->heat_in, 1e-6 * in);
  EXPECT_FALSE(runs(w, "thermal.boundary"));
  EXPECT_EQ(bytes(w, "heat_region_cells"), 0u);
}

TEST(Needs, AHeatRegionThatBeginsLeavesOneState) {
  MELTSIM_NEEDS_BACKEND();
  // Nothing could melt before the region began; then a thick liquid may come, whose viscosity is implicit.
  World w = heated_late(true);
  require(w.prepare());
  EXPECT_FALSE(runs(w, "topology.melt"));
  EXPECT_FALSE(runs(w, "sph.diffuse"));
  EXPECT_EQ(bytes(w, "velocity_increment"), 0u);
  for (int k = 0; k < 130; ++k) require(w.step(0.005));
  w.synchronize();
  EXPECT_TRUE(runs(w, "sph.diffuse"));
  EXPECT_GT(bytes(w, "velocity_increment"), 0u);
  EXPECT_GT(w.totals()->melted, 0u);
  // Before it begins, while it acts, after it has ended.
  expect_one_state([] { return heated_late(true); }, 220, 0.005, {60, 120, 190});
}

// A plan that gives memory back writes nothing there: regions of more kinds than it has room for came ahead of the end of heat.
TEST(Needs, RegionsThatAreAddedAheadOfTheEndOfHeatAreNotWritten) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  World w = std::move(*World::create(d));
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {0.4, 0.4, 0.4});
  require(w.add_fluid(f));
  HeatRegionDesc r;
  r.shape = f.shape;
  r.temperature = 50;
  require(w.add_heat_region(r));
  require(w.step(1e-4));
  w.synchronize();
  for (int k = 0; k < 400; ++k) require(w.add_heat_region(r));  // 20 kB beyond the end of what there was
  require(w.set_heat_time_scale(0));
  require(w.step(1e-4));
  const StepResult rest = w.synchronize();
  EXPECT_FALSE(rest.halted) << rest.halt_reason;
  require(w.set_heat_time_scale(1));
  require(w.step(1e-4));
  EXPECT_FALSE(w.synchronize().halted);
  EXPECT_GT(w.totals()->temperature_max, 20);
}

TEST(Needs, AStageOfTheHostThatHeatsKeepsHeatRunning) {
  MELTSIM_NEEDS_BACKEND();
  if (backend() == Backend::cuda) GTEST_SKIP() << "the stage below runs on the host";
  World w = nearly_level(1.0);
  require(w.prepare());
  EXPECT_FALSE(any_runs(w, "thermal"));
  CustomStage stage;
  stage.name = "stove";
  stage.writes = {"enthalpy"};
  stage.run = [](const StageContext& c, void*) { const_cast<double*>(c.enthalpy)[0] += 1e3; };
  require(w.scheduler().insert_after("step.begin", stage));
  EXPECT_TRUE(runs(w, "thermal.exchange"));
  EXPECT_FALSE(runs(w, "thermal.level"));
  for (int k = 0; k < 100; ++k) require(w.step(0.002));
  w.synchronize();
  EXPECT_TRUE(runs(w, "thermal.exchange"));
}

TEST(Needs, ToleranceMustBeANumber) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.heat.level_tolerance = -1;
  const auto w = World::create(d);
  ASSERT_FALSE(w);
  EXPECT_NE(w.error().message.find("heat.level_tolerance"), std::string::npos);
}

// As one whose source is set to 0; and the one behind it, which moves up in the backend's table, is still the one that is set.
TEST(Needs, AHeatRegionThatIsRemovedHeatsNoMore) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<World> worlds;
  for (const bool removes : {false, true}) {
    World w = heated_late(false);
    HeatRegionDesc r;
    r.shape = Shape::box({-9, -9, -9}, {9, 9, 9});
    r.source = 5e3;
    const HeatRegionId first = *w.add_heat_region(r), second = *w.add_heat_region(r);
    for (int k = 0; k < 5; ++k) require(w.step(0.005));
    if (removes) {
      require(w.remove(first));
      EXPECT_FALSE(w.remove(first));
      EXPECT_FALSE(w.set_heat_region(first, {}, 1));
    } else {
      require(w.set_heat_region(first, {}, 0));
    }
    require(w.set_heat_region(second, {}, 1e4));
    for (int k = 0; k < 5; ++k) require(w.step(0.005));
    if (removes) {
      require(w.remove(second));
      const double in = w.totals()->heat_in;
      require(w.step(0.005));
      EXPECT_EQ(w.totals()->heat_in, in);
      EXPECT_FALSE(runs(w, "thermal.boundary"));
    } else {
      require(w.set_heat_region(second, {}, 0));
      require(w.step(0.005));
      EXPECT_TRUE(runs(w, "thermal.boundary"));
    }
    worlds.push_back(std::move(w));
  }
  EXPECT_EQ(*worlds[0].state_hash(), *worlds[1].state_hash());
  EXPECT_GT(worlds[1].totals()->heat_in, 0);
  EXPECT_EQ(worlds[0].totals()->heat_in, worlds[1].totals()->heat_in);
}

// One that lies across a periodic face heats what one in the middle heats: its part beyond the face was cut off.
TEST(Needs, AHeatRegionGoesOnBehindPeriodicFaces) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<double> heat;
  for (const Vec3d at : {Vec3d{0.6, 0.3, 0.6}, Vec3d{0, 0.3, 0.6}, Vec3d{1.2, 0.3, 0.6}, Vec3d{1.15, 0.3, 0},
                         Vec3d{0.6, 0.3, 1.2}}) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.domain.bounded = true;
    d.domain.max = {1.2, 1, 1.2};
    for (const std::size_t face : {0u, 1u, 4u, 5u}) d.domain.faces[face] = Face::periodic;
    World w = std::move(*World::create(d));
    FluidDesc f;
    f.material = *w.add_material({});
    f.shape = Shape::box({0, 0, 0}, {1.2, 0.6, 1.2});
    require(w.add_fluid(f));
    HeatRegionDesc r;
    r.shape = Shape::box(at - Vec3d{0.3, 0.2, 0.2}, at + Vec3d{0.3, 0.2, 0.2});
    r.source = 1e5;
    require(w.add_heat_region(r));
    require(w.step(0.01));
    heat.push_back(w.totals()->heat_in);
  }
  const double exact = 1e5 * 0.6 * 0.4 * 0.4 * 0.01;
  for (const double in : heat)
    EXPECT_NEAR(in, exact, 1e-3 * exact);  // whole cells of liquid at rest; float volumes
}

}  // namespace
}  // namespace meltsim_test
