// SPDX-License-Identifier: Apache-2.0
// A step that is interrupted ends between two sub-steps and leaves a World to go on with.
#include <csignal>
#include <stdexcept>
#include <string>
#include <utility>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

Scene pool() { return ice_in_water(describe(), {}); }

/// Interrupts from within a step, at its n-th sub-step: on CUDA stages of the host's run while it enqueues, too.
struct Interrupter {
  World* world = nullptr;
  int left = 0;
  bool by_signal = false;
  static World* of_signal;
  static void on_signal(int) { of_signal->interrupt(); }
  static void run(const StageContext&, void* user) {
    auto& self = *static_cast<Interrupter*>(user);
    if (--self.left != 0) return;
    if (!self.by_signal) return self.world->interrupt();
    of_signal = self.world;
    const auto before = std::signal(SIGUSR1, on_signal);
    std::raise(SIGUSR1);
    std::signal(SIGUSR1, before);
  }
};
World* Interrupter::of_signal = nullptr;

TEST(Interrupt, EndsTheNextStepBeforeItsFirstSubStepAndNoOther) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = pool();
  const auto hash = *s.world.state_hash();
  s.world.interrupt();
  s.world.interrupt();       // the same request
  require(s.world.step(0));  // does nothing, and keeps it
  const Status status = s.world.step(1e-3);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::interrupted);
  EXPECT_NE(status.error().message.find("after 0 of "), std::string::npos) << status.error().message;
  EXPECT_EQ(*s.world.state_hash(), hash);
  EXPECT_EQ(s.world.time(), 0.0);
  require(s.world.step(1e-3));
  EXPECT_FALSE(s.world.synchronize().halted);
}

// A step that is refused was none, and the request holds for the one after it.
TEST(Interrupt, WaitsWhereAStepIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = pool();
  s.world.interrupt();
  const Status refused = s.world.step(1e9);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::step_too_large) << refused.error().message;
  const Status status = s.world.step(1e-3);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::interrupted) << status.error().message;
  require(s.world.step(1e-3));
}

// From a stage and from a signal's handler. The sub-steps before count: the state is that of as many steps of that length.
TEST(Interrupt, KeepsTheSubStepsBefore) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool by_signal : {false, true}) {
    Scene s = pool(), reference = pool();
    Interrupter interrupter{&s.world, 3, by_signal};
    require(
        s.world.scheduler().insert_after("step.integrate", {"stop", Interrupter::run, &interrupter, {}, {}}));
    require(s.world.prepare());
    const int n = 5;
    const double dt = 0.9 * n * s.world.stable_dt();  // takes n sub-steps
    const Status status = s.world.step(dt);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::interrupted);
    EXPECT_NE(status.error().message.find("after 3 of 5"), std::string::npos) << status.error().message;
    EXPECT_EQ(s.world.steps(), 3u);
    EXPECT_NEAR(s.world.time(), 3 * dt / n, 1e-12);
    for (int k = 0; k < 3; ++k) require(reference.world.step(dt / n));
    EXPECT_EQ(*s.world.state_hash(), *reference.world.state_hash());
    const StepResult r = s.world.synchronize();
    EXPECT_FALSE(r.halted);
    EXPECT_EQ(r.steps, 3u);
    require(s.world.step(dt / n));
    EXPECT_EQ(s.world.steps(), 4u);
  }
}

// A sub-step that takes long is given up on the CPU, wherever it is; on a GPU it is enqueued by then, and counts.
TEST(Interrupt, WithinASubStepLeavesTheOneBefore) {
  MELTSIM_NEEDS_BACKEND();
  const std::uint64_t kept = backend() == Backend::cuda ? 3 : 2;
  for (const auto& [stage, recycle] :
       {std::pair{"step.begin", false}, std::pair{"sph.density", true}, std::pair{"thermal.operands", false},
        std::pair{"lsm.balance", true}}) {
    Scene s = pool(), reference = pool();
    EmitterDesc e;
    e.material = s.water;
    e.center = {1.8, 2.0, 1.8};
    e.radius = 0.3;
    e.speed = 40;  // a layer in most sub-steps: that of the one that is given up, too, comes again
    e.until = 1;
    e.recycle = recycle;
    require(s.world.add_emitter(e));
    e.material = reference.water;
    require(reference.world.add_emitter(e));
    Interrupter interrupter{&s.world, 3, false};
    require(s.world.scheduler().insert_after(stage, {"stop", Interrupter::run, &interrupter, {}, {}}));
    require(s.world.prepare());
    const int n = 5;
    const double dt = 0.9 * n * s.world.stable_dt();
    const Status status = s.world.step(dt);
    ASSERT_FALSE(status) << stage;
    EXPECT_EQ(status.error().code, ErrorCode::interrupted) << status.error().message;
    EXPECT_EQ(s.world.steps(), kept) << stage;
    for (std::uint64_t k = 0; k < kept; ++k) require(reference.world.step(dt / n));
    EXPECT_EQ(*s.world.state_hash(), *reference.world.state_hash()) << stage;
    EXPECT_NEAR(s.world.time(), reference.world.time(), 1e-12);
    EXPECT_FALSE(s.world.synchronize().halted) << stage;
    for (int k = 0; k < 4; ++k) {
      require(s.world.step(dt / n));
      require(reference.world.step(dt / n));
    }
    EXPECT_EQ(*s.world.state_hash(), *reference.world.state_hash()) << stage;
    EXPECT_EQ(s.world.synchronize().fluid, reference.world.synchronize().fluid) << stage;
  }
}

/// Throws at its n-th call.
struct Thrower {
  int left = 0;
  bool of_unknown_type = false;
  static void run(const StageContext&, void* user) {
    auto& self = *static_cast<Thrower*>(user);
    if (--self.left != 0) return;
    if (self.of_unknown_type) throw 7;
    throw std::runtime_error("no such file");
  }
};

// The World goes on as if the step had ended there. Ahead of step.integrate the sub-step is given up, behind it it counts: the stage of this
// test changes nothing, so that nothing is missing. CUDA cannot give up what it records, and calls the stage in the first sub-step alone.
TEST(Interrupt, AStageThatThrowsEndsTheStepAndIsNamed) {
  MELTSIM_NEEDS_BACKEND();
  for (const char* after : {"sph.density", "lsm.balance", "step.integrate", "topology.melt"})
    for (const bool recorded : {false, true}) {
      const bool once = recorded && backend() == Backend::cuda;
      const bool ahead = std::string(after) == "sph.density" || std::string(after) == "lsm.balance";
      const std::uint64_t kept = once ? 1 : ahead ? 2 : 3;
      Scene s = pool(), reference = pool();
      Thrower thrower{once ? 1 : 3, recorded};
      CustomStage stage{"reader", Thrower::run, &thrower, {}, {}};
      stage.recorded = recorded;
      require(s.world.scheduler().insert_after(after, stage));
      require(s.world.prepare());
      const int n = 5;
      const double dt = 0.9 * n * s.world.stable_dt();
      const Status status = s.world.step(dt);
      ASSERT_FALSE(status) << after;
      EXPECT_EQ(status.error().code, ErrorCode::internal);
      const char* what = recorded ? "an exception of unknown type" : "no such file";
      EXPECT_NE(status.error().message.find("custom stage \"reader\" threw: " + std::string(what)),
                std::string::npos)
          << status.error().message;
      EXPECT_NE(status.error().message.find("after " + std::to_string(kept) + " of 5"), std::string::npos)
          << status.error().message;
      EXPECT_EQ(s.world.steps(), kept) << after;
      EXPECT_FALSE(s.world.synchronize().halted) << after;
      for (std::uint64_t k = 0; k < kept; ++k) require(reference.world.step(dt / n));
      EXPECT_NEAR(s.world.time(), reference.world.time(), 1e-12);
      EXPECT_EQ(*s.world.state_hash(), *reference.world.state_hash()) << after;
      for (int k = 0; k < 4; ++k) {
        require(s.world.step(dt / n));
        require(reference.world.step(dt / n));
      }
      EXPECT_EQ(*s.world.state_hash(), *reference.world.state_hash()) << after;
    }
}

}  // namespace
}  // namespace meltsim_test
