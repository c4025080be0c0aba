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
