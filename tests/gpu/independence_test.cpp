// SPDX-License-Identifier: Apache-2.0
// Runs repeat bit for bit, and Worlds know nothing of each other.
#include <thread>

#include "gpu/melting_scene.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;

TEST(Repeatability, RunsOnTheGpuGiveTheSameBits) {
  MELTSIM_NEEDS_GPU();
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    MeltingScene scene;
    scene.precision = precision;
    scene.second_ice = 3;
    World first = make_world(scene);
    const std::uint64_t expected = hash_after(first, 60);
    for (int k = 0; k < 2; ++k) {
      World again = make_world(scene);
      EXPECT_EQ(hash_after(again, 60), expected);
    }
  }
}

TEST(Repeatability, TimingsAndReadBackChangeNothing) {
  MELTSIM_NEEDS_GPU();
  World plain = make_world({});
  World watched = make_world({});
  ASSERT_TRUE(watched.scheduler().enable_timings(true, 1));
  for (int k = 0; k < 4; ++k) {
    step(watched, 5);
    value_of(watched.particles());
  }
  EXPECT_EQ(hash_after(plain, 20), hash_after(watched, 0));
  double total = 0;
  for (const meltsim::StageReport& stage : watched.plan().stages) total += stage.median_ms;
  EXPECT_GT(total, 0.0) << "timings are on, so the plan reports them";
}

TEST(Independence, TwoWorldsOnTwoThreadsGiveTheBitsOfOne) {
  MELTSIM_NEEDS_GPU();
  MeltingScene other;
  other.side = 12;
  other.ice = 6;
  World alone = make_world({}), other_alone = make_world(other);
  const std::uint64_t expected = hash_after(alone, 40), other_expected = hash_after(other_alone, 40);
  std::uint64_t got = 0, other_got = 0;
  std::thread first([&] {
    World world = make_world({});
    got = hash_after(world, 40);
  });
  std::thread second([&] {
    World world = make_world(other);
    other_got = hash_after(world, 40);
  });
  first.join();
  second.join();
  EXPECT_EQ(got, expected);
  EXPECT_EQ(other_got, other_expected);
}

TEST(Independence, AWorldMayMoveToAnotherThread) {
  MELTSIM_NEEDS_GPU();
  World world = make_world({}), reference = make_world({});
  step(world, 3);
  std::uint64_t got = 0;
  std::thread other([&] { got = hash_after(world, 3); });
  other.join();
  EXPECT_EQ(got, hash_after(reference, 6));
}

// Run under compute-sanitizer by benchmarks/gpu_suite.sh: small, short, every stage.
TEST(Sanitizer, SmallSceneForAFewSteps) {
  MELTSIM_NEEDS_GPU();
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    MeltingScene scene;
    scene.precision = precision;
    scene.side = 9;
    scene.ice = 3;
    scene.second_ice = 2;
    scene.pieces_interval = 1;
    scene.heat_time_scale = 2e5;  // something melts
    World world = make_world(scene);
    hash_after(world, 4);
    value_of(world.lattice());
    scene.ice = scene.second_ice = 0;  // water alone takes another way
    World water = make_world(scene);
    hash_after(water, 4);
    for (const meltsim::StageReport& stage : water.plan().stages)
      EXPECT_TRUE(!stage.runs || (stage.name.rfind("thermal", 0) != 0 && stage.name.rfind("lsm", 0) != 0))
          << stage.name;
  }
}

// Threads that take two particles at once do so where there are so many and the support is short.
TEST(Sanitizer, ManyOfWaterAtAShortSupport) {
  MELTSIM_NEEDS_GPU();
  MeltingScene scene;
  scene.side = 66;
  scene.support = 2;
  scene.ice = 0;
  World water = make_world(scene);
  hash_after(water, 1);
  EXPECT_GE(value_of(water.particles()).id.size(), 200000u);
}

}  // namespace
