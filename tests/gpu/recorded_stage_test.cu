// SPDX-License-Identifier: Apache-2.0
// Stages of a host that are recorded into the graph of a sub-step: the bits of stages that the host enqueues in every sub-step.
#include <gtest/gtest.h>

#include "gpu/melting_scene.hpp"
#include "meltsim/cuda_interop.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;
namespace interop = meltsim::cuda_interop;
using meltsim::CustomStage;
using meltsim::StageClock;
using meltsim::StageContext;

struct Host {
  int calls = 0;
  double* clocked = nullptr;  ///< on the device: time that has passed, summed from the clock
};

unsigned blocks(std::uint64_t n) { return static_cast<unsigned>((n + 127) / 128); }

template <class T>
__global__ void gust(meltsim::DeviceSpan<meltsim::Vec3<T>> acceleration, const std::uint32_t* tag,
                     const StageClock* clock) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < acceleration.size && meltsim::is_fluid(tag[i]))
    acceleration.data[i].x += static_cast<T>(30 * (clock->time + clock->length));
}
template <class T>
__global__ void brake(meltsim::DeviceSpan<meltsim::Vec4<T>> velocity) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < velocity.size) velocity.data[i].z *= T(0.99);
}
__global__ void pass(double* clocked, const StageClock* clock) { *clocked += clock->length; }

void gust_stage(const StageContext& c, void* user) {
  ++static_cast<Host*>(user)->calls;
  gust<float>
      <<<blocks(c.particles), 128, 0, interop::stream(c)>>>(interop::acceleration<float>(c), c.tag, c.clock);
}
void brake_stage(const StageContext& c, void*) {
  brake<float><<<blocks(c.particles), 128, 0, interop::stream(c)>>>(interop::velocity<float>(c));
}
void pass_stage(const StageContext& c, void* user) {
  pass<<<1, 1, 0, interop::stream(c)>>>(static_cast<Host*>(user)->clocked, c.clock);
}

CustomStage stage(const char* name, meltsim::CustomStageFunction run, Host& host, bool recorded,
                  std::vector<std::string> reads, std::vector<std::string> writes) {
  CustomStage s;
  s.name = name;
  s.run = run;
  s.user = &host;
  s.recorded = recorded;
  s.reads = std::move(reads);
  s.writes = std::move(writes);
  return s;
}

void add_stages(World& w, Host& host, bool recorded) {
  succeed(w.scheduler().insert_after("sph.forces",
                                     stage("gust", gust_stage, host, recorded, {"tag"}, {"acceleration"})));
  succeed(w.scheduler().insert_after("lsm.commit",
                                     stage("brake", brake_stage, host, recorded, {}, {"velocity"})));
}

/// Steps of two lengths in turn, so that graphs are made and found again.
std::uint64_t run(World& w, int steps) {
  for (int k = 0; k < steps; ++k) succeed(w.step(k % 5 == 4 ? time_step / 2 : time_step));
  const meltsim::StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  return value_of(w.state_hash());
}

TEST(RecordedStage, GivesTheBitsOfOneThatTheHostEnqueues) {
  MELTSIM_NEEDS_GPU();
  for (const int ice : {0, 8}) {
    MeltingScene scene;
    scene.ice = ice;
    std::uint64_t hash[3];
    Host host[3];
    for (const int way : {0, 1, 2}) {  // none, enqueued, recorded
      World w = make_world(scene);
      if (way != 0) add_stages(w, host[way], way == 2);
      hash[way] = run(w, 60);
      EXPECT_EQ(w.plan().graphs > 0, way != 1);
      if (way == 2) {
        for (const meltsim::StageReport& r : w.plan().stages)
          if (r.module == "custom") {
            EXPECT_GE(r.track, 0) << r.name;
          }
      }
    }
    EXPECT_NE(hash[0], hash[1]);
    EXPECT_EQ(hash[1], hash[2]) << "ice " << ice;
    EXPECT_GE(host[1].calls, 60);
    // Once per graph: two lengths, two halves of the double buffer, with and without the stages that run every few sub-steps.
    EXPECT_LE(host[2].calls, 16);
    EXPECT_GE(host[2].calls, 2);
  }
}

// Liquid comes in: the stage is told how many particles there are.
TEST(RecordedStage, CoversParticlesThatComeIn) {
  MELTSIM_NEEDS_GPU();
  std::uint64_t hash[2];
  for (const bool recorded : {false, true}) {
    MeltingScene scene;
    World w = make_world(scene);
    meltsim::EmitterDesc jet;
    jet.material = value_of(w.add_material([] {
      meltsim::MaterialDesc m;
      m.name = "more water";
      return m;
    }()));
    jet.center = {0.8, 1.4, 0.8};
    jet.axis = {0, -1, 0};
    jet.radius = 2 * spacing;
    jet.speed = 4;
    jet.max_particles = 2000;
    value_of(w.add_emitter(jet));
    Host host;
    add_stages(w, host, recorded);
    const std::uint64_t before = value_of(w.totals()).fluid;
    hash[recorded] = run(w, 60);
    EXPECT_GT(value_of(w.totals()).fluid, before);
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(RecordedStage, ReadsTheClockOfTheSubStepThatRuns) {
  MELTSIM_NEEDS_GPU();
  MeltingScene scene;
  World w = make_world(scene);
  Host host;
  ASSERT_EQ(cudaMalloc(&host.clocked, sizeof(double)), cudaSuccess);
  ASSERT_EQ(cudaMemset(host.clocked, 0, sizeof(double)), cudaSuccess);
  succeed(w.scheduler().insert_after("step.begin", stage("pass", pass_stage, host, true, {}, {})));
  run(w, 40);
  double passed = 0;
  ASSERT_EQ(cudaMemcpy(&passed, host.clocked, sizeof passed, cudaMemcpyDeviceToHost), cudaSuccess);
  EXPECT_DOUBLE_EQ(passed, w.time());
  // Taken out, it runs no more; put in again, it does.
  succeed(w.scheduler().remove("pass"));
  run(w, 10);
  double after = 0;
  ASSERT_EQ(cudaMemcpy(&after, host.clocked, sizeof after, cudaMemcpyDeviceToHost), cudaSuccess);
  EXPECT_EQ(after, passed);
  const double before = w.time();
  succeed(w.scheduler().insert_after("step.integrate", stage("pass", pass_stage, host, true, {}, {})));
  run(w, 10);
  ASSERT_EQ(cudaMemcpy(&after, host.clocked, sizeof after, cudaMemcpyDeviceToHost), cudaSuccess);
  EXPECT_DOUBLE_EQ(after - passed, w.time() - before);
  (void)cudaFree(host.clocked);
}

__global__ void follow(const meltsim::Vec4<float>* position, const std::uint32_t* id, std::uint64_t n,
                       double* sum) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n && id[i] == 7) *sum += position[i].y;
}
void follow_stage(const StageContext& c, void* user) {
  follow<<<blocks(c.particles), 128, 0, interop::stream(c)>>>(
      static_cast<const meltsim::Vec4<float>*>(c.position), c.id, c.particles,
      static_cast<Host*>(user)->clocked);
}

// Liquid alone: forces and integration stay one sweep beside a stage that only reads, whose buffers change places then. It sees what
// one sees that the host enqueues, and leaves no trace.
TEST(RecordedStage, ThatOnlyReadsLeavesTheSweepOfLiquidAlone) {
  MELTSIM_NEEDS_GPU();
  MeltingScene scene;
  scene.ice = 0;
  double seen[2] = {};
  std::uint64_t hash[2];
  for (const bool recorded : {false, true}) {
    World w = make_world(scene);
    Host host;
    ASSERT_EQ(cudaMalloc(&host.clocked, sizeof(double)), cudaSuccess);
    ASSERT_EQ(cudaMemset(host.clocked, 0, sizeof(double)), cudaSuccess);
    succeed(w.scheduler().insert_after(
        "sph.density", stage("follow", follow_stage, host, recorded, {"position", "id"}, {})));
    bool one_sweep = false;
    for (const meltsim::FusionReport& f : w.plan().fusions)
      one_sweep = one_sweep || (f.name == "sph.advance" && f.holds);
    EXPECT_EQ(one_sweep, recorded);
    hash[recorded] = run(w, 60);
    ASSERT_EQ(cudaMemcpy(&seen[recorded], host.clocked, sizeof(double), cudaMemcpyDeviceToHost), cudaSuccess);
    (void)cudaFree(host.clocked);
  }
  World plain = make_world(scene);
  EXPECT_EQ(hash[1], run(plain, 60));
  EXPECT_EQ(hash[0], hash[1]);
  EXPECT_NE(seen[0], 0);
  EXPECT_EQ(seen[0], seen[1]);
}

TEST(RecordedStage, IsTimedLikeOthers) {
  MELTSIM_NEEDS_GPU();
  MeltingScene scene;
  World w = make_world(scene);
  Host host;
  add_stages(w, host, true);
  succeed(w.scheduler().enable_timings(true, 8));
  run(w, 40);
  for (const meltsim::StageReport& r : w.plan().stages)
    if (r.module == "custom") {
      EXPECT_GT(r.median_ms, 0) << r.name;
    }
}

void waiting_stage(const StageContext& c, void*) { (void)cudaStreamSynchronize(interop::stream(c)); }
void allocating_stage(const StageContext& c, void*) {
  void* p = nullptr;
  if (cudaMalloc(&p, 16) == cudaSuccess) (void)cudaFree(p);
  (void)cudaGetLastError();
  (void)c;
}

// It halts by name, the device is as well as before, and a World made afterwards knows nothing of it.
TEST(RecordedStage, ThatCannotBeRecordedHaltsByName) {
  MELTSIM_NEEDS_GPU();
  for (const auto run_it : {waiting_stage, allocating_stage}) {
    MeltingScene scene;
    World w = make_world(scene);
    Host host;
    succeed(w.scheduler().insert_after("sph.forces", stage("waiter", run_it, host, true, {}, {})));
    (void)w.step(time_step);
    const meltsim::StepResult r = w.synchronize();
    EXPECT_TRUE(r.halted);
    EXPECT_NE(r.halt_reason.find("custom stage \"waiter\": recorded:"), std::string::npos) << r.halt_reason;
    EXPECT_NE(r.halt_reason.find("recorded = false"), std::string::npos) << r.halt_reason;
    (void)cudaGetLastError();
    World other = make_world(scene);
    succeed(other.scheduler().insert_after("sph.forces", stage("waiter", run_it, host, false, {}, {})));
    run(other, 5);
  }
}

}  // namespace
