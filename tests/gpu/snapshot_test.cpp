// SPDX-License-Identifier: Apache-2.0
// Snapshots do not know which backend wrote them.
#include "gpu/melting_scene.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;

class SnapshotAcross : public ::testing::TestWithParam<std::tuple<Backend, Backend, Precision>> {
 protected:
  void SetUp() override { MELTSIM_NEEDS_GPU(); }
};

TEST_P(SnapshotAcross, RestoresWithTheSameHash) {
  MeltingScene scene;
  scene.side = 10;
  scene.ice = 4;
  scene.precision = std::get<2>(GetParam());
  scene.backend = std::get<0>(GetParam());
  World from = make_world(scene);
  const std::uint64_t hash = hash_after(from, 10);
  const std::vector<std::uint8_t> bytes = value_of(from.snapshot());

  scene.backend = std::get<1>(GetParam());
  World to = make_world(scene);
  hash_after(to, 3);  // it has a state of its own
  succeed(to.restore(bytes.data(), bytes.size()));
  EXPECT_EQ(value_of(to.state_hash()), hash);
  EXPECT_EQ(to.steps(), from.steps());
  EXPECT_EQ(value_of(to.snapshot()), bytes);

  // On one backend going on is as if nothing had happened.
  if (std::get<0>(GetParam()) == std::get<1>(GetParam())) {
    EXPECT_EQ(hash_after(to, 10), hash_after(from, 10));
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, SnapshotAcross,
                         ::testing::Combine(::testing::Values(Backend::cpu, Backend::cuda),
                                            ::testing::Values(Backend::cpu, Backend::cuda),
                                            ::testing::Values(Precision::single_precision,
                                                              Precision::double_precision)),
                         [](const auto& info) {
                           return name_of(std::get<0>(info.param)) + "To" + name_of(std::get<1>(info.param)) +
                                  name_of(std::get<2>(info.param));
                         });

}  // namespace
