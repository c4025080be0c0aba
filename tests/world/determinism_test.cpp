// SPDX-License-Identifier: Apache-2.0
// The same bits whatever the number of threads, the order of building, or the run.
#include <set>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

std::uint64_t hash_after(int threads, Precision precision) {
  WorldDesc d = describe();
  d.threads = threads;
  d.precision = precision;
  Scene s = ice_in_water(d);
  // Long enough for the block to hit the water, melt in part and be re-sorted many times.
  for (int k = 0; k < 120; ++k) EXPECT_TRUE(s.world.step(0.005));
  EXPECT_FALSE(s.world.synchronize().halted);
  return *s.world.state_hash();
}

TEST(Determinism, BitsDoNotDependOnTheNumberOfThreads) {
  MELTSIM_NEEDS_BACKEND();
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 3, 8}) hashes.insert(hash_after(threads, Precision::single_precision));
  EXPECT_EQ(hashes.size(), 1u);
  EXPECT_EQ(hash_after(1, Precision::double_precision), hash_after(3, Precision::double_precision));
}

TEST(Determinism, TwoWorldsInOneProcessDoNotTouchEachOther) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe()), b = ice_in_water(describe());
  for (int k = 0; k < 30; ++k) {
    require(a.world.step(0.005));
    if (k < 10) require(b.world.step(0.005));
  }
  for (int k = 10; k < 30; ++k) require(b.world.step(0.005));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
}

TEST(Determinism, ReadingBackChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe()), b = ice_in_water(describe());
  for (int k = 0; k < 20; ++k) {
    require(a.world.step(0.005));
    require(b.world.step(0.005));
    b.world.synchronize();
    require(b.world.totals());
    require(b.world.particles());
    require(b.world.pieces());
    require(b.world.lattice());
    b.world.plan();
  }
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
}

}  // namespace
}  // namespace meltsim_test
