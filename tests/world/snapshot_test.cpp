// SPDX-License-Identifier: Apache-2.0
#include <random>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

TEST(Snapshot, RestoreAndContinueEqualsUninterrupted) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  for (int k = 0; k < 60; ++k) require(a.world.step(0.005));
  const auto bytes = *a.world.snapshot();
  Scene b = ice_in_water(describe());
  require(b.world.restore(bytes.data(), bytes.size()));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_EQ(a.world.steps(), b.world.steps());
  EXPECT_EQ(a.world.time(), b.world.time());
  for (int k = 0; k < 60; ++k) {
    require(a.world.step(0.005));
    require(b.world.step(0.005));
  }
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_EQ(a.world.synchronize().melted, b.world.synchronize().melted);
}

TEST(Snapshot, DamagedBytesAreRefusedAndChangeNothing) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  for (int k = 0; k < 5; ++k) require(a.world.step(0.005));
  const auto good = *a.world.snapshot();
  const auto hash = *a.world.state_hash();
  std::mt19937 random(7);
  for (int k = 0; k < 200; ++k) {  // every part of the file is hit several times
    auto bad = good;
    if (k % 3 == 0) bad.resize(random() % bad.size());
    else bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    const Status s = a.world.restore(bad.data(), bad.size());
    ASSERT_FALSE(s);
    EXPECT_FALSE(s.error().message.empty());
  }
  EXPECT_FALSE(a.world.restore(nullptr, 0));
  EXPECT_EQ(*a.world.state_hash(), hash);
  require(a.world.step(0.005));
}

TEST(Snapshot, ASnapshotOfAnotherSceneIsRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  IceScene larger;
  larger.block = 4;
  Scene b = ice_in_water(describe(), larger);
  const auto bytes = *b.world.snapshot();
  const Status s = a.world.restore(bytes.data(), bytes.size());
  ASSERT_FALSE(s);
  EXPECT_NE(s.error().message.find("lattice vertices"), std::string::npos) << s.error().message;
}

}  // namespace
}  // namespace meltsim_test
