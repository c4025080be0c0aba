// SPDX-License-Identifier: Apache-2.0
// Only what a scene needs runs, and only that has memory.
#include <algorithm>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

bool runs(const Plan& p, const std::string& stage) {
  for (const StageReport& s : p.stages)
    if (s.name == stage) return s.runs;
  ADD_FAILURE() << "no stage " << stage;
  return false;
}

std::uint64_t bytes(const Plan& p, const std::string& channel) {
  for (const ChannelReport& c : p.channels)
    if (c.name == channel) return c.bytes;
  ADD_FAILURE() << "no channel " << channel;
  return 0;
}

TEST(Plan, AnEmptyWorldStepsAndHasNoBuffers) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(describe());
  ASSERT_TRUE(w);
  require(w->step(0.01));
  require(w->step(1e3));
  EXPECT_FALSE(w->synchronize().halted);
  for (const ChannelReport& c : w->plan().channels) EXPECT_EQ(c.bytes, 0u) << c.name;
  EXPECT_EQ(w->totals()->mass, 0.0);
}

TEST(Plan, WaterAloneHasNoLatticeNoTopologyNoHeat) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.block = 0;
  Scene s = ice_in_water(describe(), scene);
  const Plan p = s.world.plan();
  for (const StageReport& r : p.stages) {
    if (r.module == "lsm" || r.module == "topology" || r.module == "thermal") {
      EXPECT_FALSE(r.runs) << r.name;
      EXPECT_FALSE(r.reason.empty());
    }
  }
  EXPECT_TRUE(runs(p, "sph.density"));
  for (const char* c : {"vertex_id", "region_mask", "neighbour_mask", "region_fit", "site_vertex",
                        "heat_operand", "vertex_of_id", "piece"})
    EXPECT_EQ(bytes(p, c), 0u) << c;
}

bool holds(const Plan& p, const std::string& fusion) {
  for (const FusionReport& f : p.fusions)
    if (f.name == fusion) return f.holds;
  ADD_FAILURE() << "no fusion " << fusion;
  return false;
}

void do_nothing(const StageContext&, void*) {}

// A CPU runs stages one by one, in the order of the table; beside a stage of the host's a GPU does so, too.
TEST(Plan, SaysHowASubStepIsCarriedOut) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.block = 0;
  Scene s = ice_in_water(describe(), scene);
  const bool gpu = s.world.backend() == Backend::cuda;
  const Plan water = s.world.plan();
  EXPECT_EQ(holds(water, "sph.advance"), gpu);
  EXPECT_TRUE(holds(water, "step.count_ahead"));
  EXPECT_NE(water.to_string().find("step.count_ahead"), std::string::npos);
  for (const StageReport& r : water.stages) {
    const bool on_a_track = gpu && r.runs && r.name != "step.begin";
    EXPECT_EQ(r.track >= 0, on_a_track) << r.name;
  }
  CustomStage own;
  own.name = "nothing";
  own.run = do_nothing;
  require(s.world.scheduler().insert_after("sph.forces", own));
  const Plan beside = s.world.plan();
  for (const FusionReport& f : beside.fusions) EXPECT_FALSE(f.holds) << f.name;
  for (const StageReport& r : beside.stages) EXPECT_EQ(r.track, -1) << r.name;
  require(s.world.scheduler().remove("nothing"));
  // Recorded, it joins the track of the stage that it follows. Integration in one sweep with the forces leaves it no place between
  // the two; cells are counted ahead unless it moves particles.
  own.recorded = true;
  own.writes = {"acceleration"};
  require(s.world.scheduler().insert_after("sph.forces", own));
  const Plan recorded = s.world.plan();
  EXPECT_FALSE(holds(recorded, "sph.advance"));
  EXPECT_TRUE(holds(recorded, "step.count_ahead"));
  for (const StageReport& r : recorded.stages)
    EXPECT_EQ(r.track >= 0, gpu && r.runs && r.name != "step.begin") << r.name;
  require(s.world.scheduler().remove("nothing"));
  own.writes = {"velocity"};
  require(s.world.scheduler().insert_after("sph.forces", own));
  EXPECT_FALSE(holds(s.world.plan(), "step.count_ahead"));
  require(s.world.scheduler().remove("nothing"));
  own.writes = {};
  require(s.world.scheduler().insert_after("sph.density", own));
  EXPECT_EQ(holds(s.world.plan(), "sph.advance"), gpu);
  require(s.world.scheduler().remove("nothing"));
  Scene mixed = ice_in_water(describe());
  EXPECT_FALSE(holds(mixed.world.plan(), "sph.advance"));
}

TEST(Plan, ASolidAloneHasNoLiquidStages) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.water = false;
  Scene s = ice_in_water(describe(), scene);
  const Plan p = s.world.plan();
  EXPECT_FALSE(runs(p, "sph.density"));
  EXPECT_FALSE(runs(p, "topology.melt"));  // uniform temperature below melting
  EXPECT_TRUE(runs(p, "lsm.regions"));
  EXPECT_FALSE(runs(p, "lsm.contact"));  // one body that cannot come apart
}

TEST(Plan, WhenAllHasMeltedTheLatticeIsGivenBack) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  EXPECT_GT(bytes(s.world.plan(), "region_mask"), 0u);
  melt(s.world, 0.005, 10);
  EXPECT_EQ(s.world.synchronize().solid, 0u);
  const Plan p = s.world.plan();
  EXPECT_EQ(bytes(p, "region_mask"), 0u);
  EXPECT_FALSE(runs(p, "lsm.regions"));
  EXPECT_EQ(s.world.totals()->melted, 27u);
  require(s.world.step(0.005));  // and goes on
  EXPECT_EQ(s.world.synchronize().melted, 27u);
}

/// What a scene comes to, and what that costs.
struct Cost {
  double dt = 0;
  int heat_stages = 0;
  std::uint64_t stages = 0, bytes = 0, hash = 0;
};

Cost cost_of(World& w) {
  Cost c;
  require(w.prepare());
  c.dt = w.stable_dt();
  c.heat_stages = w.resolved().heat_stages;
  const Plan p = w.plan();
  for (const StageReport& s : p.stages) c.stages += s.runs ? 1u : 0u;
  for (const ChannelReport& ch : p.channels) c.bytes += ch.bytes;
  for (int k = 0; k < 3; ++k) require(w.step(c.dt));
  c.hash = *w.state_hash();
  return c;
}

TEST(Plan, AMaterialThatNothingIsMadeOfCostsNothing) {
  MELTSIM_NEEDS_BACKEND();
  const auto build = [](std::vector<MaterialDesc> unused) {
    Scene s = ice_in_water(describe());
    for (const MaterialDesc& m : unused) require(s.world.add_material(m));
    return cost_of(s.world);
  };
  MaterialDesc honey, conductor, oil, steel;
  honey.name = "honey";
  honey.viscosity = 1e4;
  conductor.name = "conductor";
  conductor.conductivity = 4e6;
  oil.name = "oil";
  oil.viscosity_points = {{0, 1.0}, {50, 0.1}};
  steel.name = "steel";
  steel.density = 1e6;  // would coarsen the units of exact sums
  const Cost plain = build({});
  for (const MaterialDesc& m : {honey, conductor, oil, steel}) {
    const Cost with = build({m});
    EXPECT_EQ(with.dt, plain.dt) << m.name;
    EXPECT_EQ(with.heat_stages, plain.heat_stages) << m.name;
    EXPECT_EQ(with.stages, plain.stages) << m.name;
    // One row in the table of materials.
    EXPECT_LE(with.bytes, plain.bytes + 512) << m.name;
    EXPECT_EQ(with.hash, plain.hash) << m.name;
  }
}

TEST(Plan, WhatMeltsIntoAThickLiquidOrIsEmittedCounts) {
  MELTSIM_NEEDS_BACKEND();
  const auto dt_with = [](double viscosity, double temperature, bool emit) {
    WorldDesc d = describe();
    d.viscosity = Viscosity::explicit_;  // which shows in the step
    auto w = World::create(d);
    EXPECT_TRUE(w);
    MaterialDesc lava, stone;
    lava.name = "lava";
    lava.viscosity = viscosity;
    const MaterialId liquid = *w->add_material(lava);
    stone.name = "stone";
    stone.melts_into = liquid;
    stone.melting_point = 500;
    const MaterialId solid = *w->add_material(stone);
    MaterialDesc water;
    water.name = "water";
    FluidDesc pool;
    pool.shape = Shape::box({0, 0, 0}, {1, 1, 1});
    pool.material = *w->add_material(water);
    pool.temperature = 20;
    require(w->add_fluid(pool));
    SolidDesc block;
    block.shape = Shape::box({0, 2, 0}, {0.6, 2.6, 0.6});
    block.material = solid;
    block.temperature = temperature;
    require(w->add_solid(block));
    if (emit) {
      EmitterDesc e;
      e.material = liquid;
      e.center = {3, 3, 3};
      e.radius = 0.3;
      e.until = 1;
      e.temperature = 20;
      require(w->add_emitter(e));
    }
    require(w->prepare());
    return w->stable_dt();
  };
  // At one temperature and without a source nothing can melt, and nobody emits.
  EXPECT_EQ(dt_with(1e4, 20, false), dt_with(1e-3, 20, false));
  EXPECT_LT(dt_with(1e4, 400, false), 0.5 * dt_with(1e-3, 400, false));
  EXPECT_LT(dt_with(1e4, 20, true), 0.5 * dt_with(1e-3, 20, true));
}

TEST(Plan, AHeatRegionIsHeldWhereParticlesCanBe) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.domain = DomainDesc{};
  d.domain.bounded = true;
  d.domain.min = {0, 0, 0};
  d.domain.max = {2, 2, 2};
  auto w = World::create(d);
  ASSERT_TRUE(w);
  MaterialDesc water;
  water.name = "water";
  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {2, 1, 2});
  pool.material = *w->add_material(water);
  require(w->add_fluid(pool));
  HeatRegionDesc hot;
  hot.shape = Shape::box({-100, -100, -100}, {100, 100, 100});  // 1e9 cells
  hot.source = 1e3;
  require(w->add_heat_region(hot));
  // 10 cells along each axis, one more on each side, a bit each.
  EXPECT_LE(bytes(w->plan(), "heat_region_cells"), 12u * 12u * 12u / 8u + 4u);
  const double before = w->totals()->thermal;
  require(w->step(0.001));
  // 2 x 1 x 2 m at 1 kW/m^3 for a millisecond.
  EXPECT_NEAR(w->totals()->thermal - before, 4.0, 1e-4);
  hot.name = "elsewhere";
  hot.shape = Shape::box({5, 5, 5}, {6, 6, 6});
  const auto refused = w->add_heat_region(hot);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("of the domain"), std::string::npos) << refused.error().message;
}

TEST(Plan, ManyBodiesAreAddedOneByOne) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(describe());
  ASSERT_TRUE(w);
  MaterialDesc water, ice;
  water.name = "water";
  ice.name = "ice";
  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {20, 0.8, 20});  // 100 x 4 x 100 particles
  pool.material = *w->add_material(water);
  require(w->add_fluid(pool));
  SolidDesc block;
  block.material = *w->add_material(ice);
  // 2500 bodies of 8, each in the place of 8 particles of water. If each cost what is there already, this would be 2500
  // times 40,000 particles.
  for (int z = 0; z < 50; ++z)
    for (int x = 0; x < 50; ++x) {
      block.shape = Shape::box({0.4 * x, 0.4, 0.4 * z}, {0.4 * x + 0.4, 0.8, 0.4 * z + 0.4});
      require(w->add_solid(block));
    }
  const auto p = w->particles();
  ASSERT_TRUE(p);
  ASSERT_EQ(p->id.size(), 40000u);  // ids have no gaps
  EXPECT_EQ(p->id.back(), 39999u);
  const auto totals = w->totals();
  EXPECT_EQ(totals->solid, 20000u);
  EXPECT_EQ(totals->fluid, 20000u);
  block.shape = Shape::box({0, 0.4, 0}, {0.4, 0.8, 0.4});
  const auto refused = w->add_solid(block);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("overlaps body \"body1\""), std::string::npos)
      << refused.error().message;
  require(w->step(1e-4));
  EXPECT_FALSE(w->synchronize().halted);
}

TEST(Plan, CustomStagesRunWhereTheyWerePut) {
  MELTSIM_NEEDS_BACKEND();
  if (backend() == Backend::cuda) GTEST_SKIP() << "the stage below runs on the host";
  Scene s = ice_in_water(describe());
  int calls = 0;
  CustomStage stage;
  stage.name = "count";
  stage.user = &calls;
  stage.run = [](const StageContext& c, void* user) {
    if (c.particles > 0 && c.acceleration != nullptr) ++*static_cast<int*>(user);
  };
  require(s.world.scheduler().insert_after("sph.forces", stage));
  EXPECT_FALSE(s.world.scheduler().insert_after("sph.forces", stage));  // the name is taken
  stage.name = "other";
  EXPECT_FALSE(s.world.scheduler().insert_after("sph.force", stage));
  stage.reads = {"pressure_of_air"};
  EXPECT_FALSE(s.world.scheduler().insert_after("sph.forces", stage));
  require(s.world.step(0.001));
  EXPECT_EQ(calls, 1);
  require(s.world.scheduler().remove("count"));
  require(s.world.step(0.001));
  EXPECT_EQ(calls, 1);
}

TEST(Plan, AModuleSwitchedOffLeavesThePlan) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  require(s.world.scheduler().enable("thermal", false));
  EXPECT_FALSE(runs(s.world.plan(), "thermal.exchange"));
  EXPECT_FALSE(s.world.scheduler().enable("spatial", false));
  const auto before = s.world.totals()->thermal;
  for (int k = 0; k < 5; ++k) require(s.world.step(0.005));
  EXPECT_EQ(s.world.totals()->thermal, before);
  require(s.world.scheduler().enable("thermal", true));
  EXPECT_TRUE(runs(s.world.plan(), "thermal.exchange"));
}

}  // namespace
}  // namespace meltsim_test
