// SPDX-License-Identifier: Apache-2.0
// A step enqueues and nothing else: it can be captured into a CUDA graph on the host's stream.
#include <cuda_runtime_api.h>

#include "gpu/melting_scene.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;

class Capture : public ::testing::TestWithParam<cudaStreamCaptureMode> {
 protected:
  void SetUp() override {
    MELTSIM_NEEDS_GPU();
    ASSERT_EQ(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), cudaSuccess);
  }
  void TearDown() override {
    if (stream_ != nullptr) {
      EXPECT_EQ(cudaStreamDestroy(stream_), cudaSuccess);
    }
  }
  cudaStream_t stream_ = nullptr;
};

// Two sub-steps a graph: the state is double-buffered, so only an even number ends where it began. Pieces are
// searched for in every step, so that every graph holds the same stages.
TEST_P(Capture, StepsReplayAsTheyRun) {
  MeltingScene scene;
  scene.pieces_interval = 1;
  scene.side = 10;
  scene.ice = 4;
  World direct = make_world(scene);
  scene.stream = stream_;
  World captured = make_world(scene);

  // Captured before anything ran: no step needs a first one to warm up.
  cudaGraph_t graph = nullptr;
  ASSERT_EQ(cudaStreamBeginCapture(stream_, GetParam()), cudaSuccess);
  step(captured, 2);
  const auto refused = captured.request({});  // a graph cannot hold a reading
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, meltsim::ErrorCode::invalid_argument);
  ASSERT_EQ(cudaStreamEndCapture(stream_, &graph), cudaSuccess)
      << "something in the step waited or allocated";
  std::size_t nodes = 0;
  ASSERT_EQ(cudaGraphGetNodes(graph, nullptr, &nodes), cudaSuccess);
  RecordProperty("nodes_per_step", static_cast<int>(nodes / 2));
  EXPECT_GT(nodes, 20u);

  cudaGraphExec_t replay = nullptr;
  ASSERT_EQ(cudaGraphInstantiate(&replay, graph, 0), cudaSuccess);
  ASSERT_EQ(cudaGraphLaunch(replay, stream_), cudaSuccess);
  const std::uint64_t direct_two = hash_after(direct, 2);
  EXPECT_EQ(hash_after(captured, 0), direct_two);
  const std::uint64_t direct_four = hash_after(direct, 2);
  ASSERT_EQ(cudaGraphLaunch(replay, stream_), cudaSuccess);
  ASSERT_EQ(cudaStreamSynchronize(stream_), cudaSuccess);
  EXPECT_NE(direct_four, direct_two);
  // The World believes that what it last read back is current: a step of its own makes it look again.
  EXPECT_EQ(hash_after(captured, 2), hash_after(direct, 2));
  EXPECT_EQ(cudaGraphExecDestroy(replay), cudaSuccess);
  EXPECT_EQ(cudaGraphDestroy(graph), cudaSuccess);
}

INSTANTIATE_TEST_SUITE_P(Modes, Capture,
                         ::testing::Values(cudaStreamCaptureModeGlobal, cudaStreamCaptureModeThreadLocal));

// One graph per kind of sub-step, whatever melts and however many particles there are: two halves of the
// double buffer, with and without the search for pieces (every 16th, so always on the same half), and eight
// sizes that a growing number of particles goes through.
TEST(Graphs, SurviveMeltingAndEmitters) {
  MELTSIM_NEEDS_GPU();
  MeltingScene scene;
  scene.latent_heat = 1e4;
  scene.heat_time_scale = 2e5;
  World world = make_world(scene);
  meltsim::MaterialDesc hot;
  hot.name = "jet";
  const double wide = scene.side * spacing;
  meltsim::EmitterDesc jet;
  jet.material = value_of(world.add_material(hot));
  jet.center = {0.5 * wide, 0.9 * wide, 0.5 * wide};
  jet.axis = {0, -1, 0};
  jet.radius = 1.2 * spacing;
  jet.speed = 1;
  jet.until = 1;
  jet.temperature = 90;
  ASSERT_TRUE(world.add_emitter(jet));
  step(world, 40);
  const auto before = world.synchronize();
  const std::uint64_t graphs = world.plan().graphs;
  EXPECT_GE(graphs, 2u);
  step(world, 400);
  const auto after = world.synchronize();
  ASSERT_FALSE(after.halted) << after.halt_reason;
  EXPECT_GT(after.fluid + after.solid, before.fluid + before.solid) << "the jet does not run";
  EXPECT_GT(after.melted, before.melted) << "nothing melts";
  EXPECT_LE(world.plan().graphs, 3u * 8u);
}

// The host's stream orders the World's work: what the host enqueued before is waited for, and the legacy
// default stream is not involved.
TEST(HostStream, GivesTheSameBitsAsItsOwn) {
  MELTSIM_NEEDS_GPU();
  cudaStream_t stream = nullptr;
  ASSERT_EQ(cudaStreamCreate(&stream), cudaSuccess);
  {
    MeltingScene scene;
    World own = make_world(scene);
    scene.stream = stream;
    World host = make_world(scene);
    EXPECT_EQ(hash_after(own, 5), hash_after(host, 5));
  }
  EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
}

TEST(Device, OrdinalOutOfRangeNamesTheRange) {
  MELTSIM_NEEDS_GPU();
  meltsim::WorldDesc desc;
  desc.backend = Backend::cuda;
  desc.device = 4711;
  const auto world = World::create(desc);
  ASSERT_FALSE(world.ok());
  EXPECT_EQ(world.error().code, meltsim::ErrorCode::no_device);
  EXPECT_NE(world.error().message.find("4711"), std::string::npos) << world.error().message;
}

TEST(Device, TheHostsErrorsAndDeviceStayAsTheyWere) {
  MELTSIM_NEEDS_GPU();
  World world = make_world({});
  int before = -1, after = -2;
  ASSERT_EQ(cudaGetDevice(&before), cudaSuccess);
  hash_after(world, 3);
  ASSERT_EQ(cudaGetDevice(&after), cudaSuccess);
  EXPECT_EQ(before, after);
  EXPECT_EQ(cudaGetLastError(), cudaSuccess);
}

}  // namespace
