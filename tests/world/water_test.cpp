// SPDX-License-Identifier: Apache-2.0
// Liquid alone, where a GPU works out forces and the end of the sub-step in one sweep: the same bits as stage by stage,
// with emitters and open faces, at sizes where sums are shared out and where they are not; and a World that halts keeps
// its last good state.
#include "scenes.hpp"

namespace meltsim_test {
namespace {

struct Water {
  Precision precision = Precision::single_precision;
  double side = 1.6, depth = 0.8;  ///< [m], at a spacing of 0.1
  bool jet = false;                ///< from above, and the roof is open to splashes
  bool roofless = false;           ///< liquid may leave above
  bool periodic = false;           ///< in z
  double sound_speed = 30;
  Vec3d velocity, gravity{0, -9.81, 0};
};

World make_water(const Water& water) {
  WorldDesc d = describe();
  d.precision = water.precision;
  d.spacing = 0.1;
  d.sound_speed = water.sound_speed;
  d.gravity = water.gravity;
  d.domain.bounded = true;
  d.domain.max = {water.side, water.side, water.side};
  if (water.jet || water.roofless) d.domain.faces[3] = Face::open;
  if (water.periodic) d.domain.faces[4] = d.domain.faces[5] = Face::periodic;
  World w = *World::create(d);
  MaterialDesc m;
  m.viscosity = 0.2;
  const MaterialId id = *w.add_material(m);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {water.side, water.depth, water.side});
  f.material = id;
  f.velocity = water.velocity;
  require(w.add_fluid(f));
  if (water.jet) {
    EmitterDesc jet;
    jet.material = id;
    jet.center = {0.5 * water.side, water.side - 0.15, 0.5 * water.side};
    jet.axis = {0, 1, 0};  // out of the roof
    jet.radius = 0.25;
    jet.speed = 10;  // through the nozzle, two spacings long, and out within 0.05 s
    jet.until = 1;
    require(w.add_emitter(jet));
  }
  require(w.prepare());
  return w;
}

class WaterAlone : public testing::TestWithParam<Precision> {
 protected:
  void SetUp() override { MELTSIM_NEEDS_BACKEND(); }
};
INSTANTIATE_TEST_SUITE_P(Precisions, WaterAlone,
                         testing::Values(Precision::single_precision, Precision::double_precision),
                         [](const auto& which) {
                           return which.param == Precision::single_precision ? "single" : "double";
                         });

// Timings make stages run one by one. 2,048 particles, with a jet that leaves again, and on a GPU one more than 200,000,
// from where sums are not shared out.
TEST_P(WaterAlone, IsTheSameStageByStage) {
  std::vector<Water> scenes(3);
  scenes[1].jet = true;
  scenes[2].periodic = true;
  if (backend() == Backend::cuda) {
    scenes.emplace_back();
    scenes.back().side = 7;
    scenes.back().depth = 4.2;  // 205,800
  }
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    scenes[k].precision = GetParam();
    scenes[k].velocity = {0.5, 0, 0.3};
    World plain = make_water(scenes[k]), timed = make_water(scenes[k]), now_and_then = make_water(scenes[k]),
          sampled = make_water(scenes[k]);
    require(sampled.scheduler().enable_timings(true, 3));
    require(timed.scheduler().enable_timings(true, 1));
    for (int n = 0; n < 12; ++n) {
      require(now_and_then.scheduler().enable_timings(n % 3 == 1, 1));
      for (World* w : {&plain, &timed, &now_and_then, &sampled}) require(w->step(4e-3));
    }
    const StepResult r = plain.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    EXPECT_EQ(scenes[k].jet, r.removed != 0) << "scene " << k;
    EXPECT_EQ(*plain.state_hash(), *timed.state_hash()) << "scene " << k;
    EXPECT_EQ(*plain.state_hash(), *now_and_then.state_hash()) << "scene " << k;
    EXPECT_EQ(*plain.state_hash(), *sampled.state_hash()) << "scene " << k;
  }
}

// The plan says how timings were taken. A whole sub-step is only timed where stages are not.
TEST_P(WaterAlone, SaysHowItWasTimed) {
  Water water;
  water.precision = GetParam();
  World w = make_water(water);
  EXPECT_EQ(w.plan().timings_every, 0);
  EXPECT_EQ(w.scheduler().enable_timings(true, 0).error().code, ErrorCode::invalid_argument);
  for (const int every : {3, 1}) {
    require(w.scheduler().enable_timings(true, every));
    for (int n = 0; n < 6; ++n) require(w.step(4e-3));
    w.synchronize();
    const Plan plan = w.plan();
    EXPECT_EQ(plan.timings_every, every);
    EXPECT_GT(plan.substep_ms, 0);  // of the sampled ones, also later
    for (const StageReport& stage : plan.stages)
      if (stage.name == "sph.forces") {
        EXPECT_GT(stage.median_ms, 0);
      }
    EXPECT_NE(plan.to_string().find("one sub-step in " + std::to_string(every)), std::string::npos);
  }
  require(w.scheduler().enable_timings(false));
  EXPECT_EQ(w.plan().timings_every, 0);
}

// Falls up with 1000 m/s^2: after 60 ms and 1.8 m it moves by 0.36 m in a sub-step of 6 ms, more than H, 0.25 m.
TEST_P(WaterAlone, ThatHaltsKeepsItsLastGoodState) {
  for (int steps = 60; steps <= 62; ++steps)
    for (const bool timed : {false, true}) {
      Water water;
      water.precision = GetParam();
      water.sound_speed = 5;
      water.side = 3;
      water.depth = 0.6;
      water.gravity = {0, 1000, 0};
      water.roofless = true;
      World w = make_water(water);
      for (int k = 0; k < steps; ++k) require(w.step(1e-3));
      const auto good = *w.state_hash();
      const double time = w.time();
      require(w.scheduler().enable_timings(timed, 1));
      require(w.step(6e-3));
      require(w.scheduler().enable_timings(!timed, 1));
      require(w.step(6e-3));  // enqueued behind it, does nothing
      EXPECT_EQ(*w.state_hash(), good);
      EXPECT_FALSE(w.step(6e-3));  // by now it is known
      const StepResult r = w.synchronize();
      EXPECT_TRUE(r.halted);
      EXPECT_NE(r.halt_reason.find("sub-step " + std::to_string(steps + 1)), std::string::npos)
          << r.halt_reason;
      EXPECT_EQ(*w.state_hash(), good) << steps << " steps before, timed " << timed;
      EXPECT_EQ(w.time(), time);
    }
}

}  // namespace
}  // namespace meltsim_test
