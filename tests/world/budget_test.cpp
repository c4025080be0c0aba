// SPDX-License-Identifier: Apache-2.0
// Steps within a budget of wall time. Nothing here depends on how long anything takes: a budget of a picosecond has room
// for no sub-step, infinity for all, and what lies between is held by its accounts. How sub-steps are counted out by their
// cost is tested in tests/core/substep_budget_test.cpp, with times that are made up.
#include <cmath>
#include <limits>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double none = 1e-9;  // [ms]; no sub-step is as quick
constexpr double all = std::numeric_limits<double>::infinity();

/// Melting ice in water with a jet: a layer of it is due at times that rounding of the clock may shift.
Scene jet_on_ice() {
  Scene s = ice_in_water(describe(), {});
  EmitterDesc e;
  e.material = s.water;
  e.center = {1.8, 2.0, 1.8};
  e.radius = 0.3;
  e.speed = 10;
  e.until = 1;
  require(s.world.add_emitter(e));
  require(s.world.prepare());
  return s;
}

// The two parts of dt add up to it, but for the rounding of each; time() and steps() say the same.
TEST(Budget, WhatWasSimulatedAndWhatIsOwedAddUpToWhatWasAskedFor) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = jet_on_ice();
  const double dt = 7.3 * s.world.stable_dt();  // eight sub-steps
  for (const double budget : {none, 0.01, 0.3, 3.0, all}) {
    const double before = s.world.time();
    const std::uint64_t steps = s.world.steps();
    const Result<TimedStep> r = s.world.step_within(dt, budget);
    require(r);
    EXPECT_EQ(r->planned, 8u);
    EXPECT_GE(r->substeps, 1u);
    EXPECT_LE(r->substeps, r->planned);
    EXPECT_EQ(s.world.steps() - steps, r->substeps);
    EXPECT_NEAR(r->simulated + r->owed, dt, 1e-15 * dt);
    EXPECT_NEAR(s.world.time() - before, r->simulated, 1e-15);
    EXPECT_NEAR(r->simulated, dt * static_cast<double>(r->substeps) / 8, 1e-15 * dt);
    EXPECT_EQ(r->owed == 0, r->substeps == r->planned);
    EXPECT_GT(r->wall_ms, 0);
    EXPECT_EQ(r->over_budget, r->wall_ms > budget);
    if (budget == none) {
      EXPECT_EQ(r->substeps, 1u);
      EXPECT_TRUE(r->over_budget);
    }
    if (budget == all) {
      EXPECT_EQ(r->owed, 0);
      EXPECT_FALSE(r->over_budget);
    }
  }
}

TEST(Budget, WithoutEndIsAStep) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = jet_on_ice(), b = jet_on_ice();
  const double dt = 0.013;
  for (int i = 0; i < 4; ++i) {
    const Result<TimedStep> r = a.world.step_within(dt, all);
    require(r);
    EXPECT_EQ(r->simulated, dt);
    require(b.world.step(dt));
  }
  EXPECT_EQ(a.world.time(), b.world.time());
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
}

// Whatever the machine came to under a budget, the same numbers of sub-steps give the same bits, and the same clock.
TEST(Budget, IsRepeatedToTheBitByItsNumbersOfSubSteps) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = jet_on_ice(), b = jet_on_ice();
  const double dt = 9.6 * a.world.stable_dt();
  std::vector<std::uint64_t> taken;
  for (int i = 0; i < 24; ++i) {
    const Result<TimedStep> r = a.world.step_within(dt, i % 3 == 0 ? none : 0.2 * (i % 5 + 1));
    require(r);
    taken.push_back(r->substeps);
  }
  for (const std::uint64_t n : taken) {
    const Result<TimedStep> r = b.world.step_part(dt, n);
    require(r);
    EXPECT_EQ(r->substeps, n);
  }
  EXPECT_EQ(a.world.time(), b.world.time());
  EXPECT_EQ(a.world.steps(), b.world.steps());
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
}

// One sub-step of the eight or more that each call asks for: time falls behind by the rest, and what is simulated is what an
// unhurried run has at that time, to the bit, since its sub-steps are as long. 300 of them: the block has met the water.
TEST(Budget, StarvedItFallsBehindAndStaysStable) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe(), {}), b = ice_in_water(describe(), {});
  require(a.world.prepare());
  const double dt = 8 * a.world.stable_dt() * (1 - 1e-12);
  double owed = 0;
  for (int i = 0; i < 300; ++i) {
    const Result<TimedStep> r = a.world.step_within(dt, none);
    require(r);
    ASSERT_EQ(r->substeps, 1u);
    ASSERT_EQ(r->planned, 8u);
    owed += r->owed;
    require(b.world.step(dt / 8));
  }
  EXPECT_NEAR(a.world.time() + owed, 300 * dt, 1e-12 * 300 * dt);
  const StepResult r = a.world.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_FALSE(r.courant_exceeded);
  EXPECT_GT(a.world.totals()->kinetic, 0);
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
}

TEST(Budget, PartsStopWhereTheyAreToldTo) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = jet_on_ice();
  const auto hash = *s.world.state_hash();
  const double dt = 4.5 * s.world.stable_dt();  // five sub-steps
  const Result<TimedStep> nothing = s.world.step_part(dt, 0), part = s.world.step_part(dt, 3),
                          more = s.world.step_part(dt, 1000);
  require(nothing);
  require(part);
  require(more);
  EXPECT_EQ(nothing->substeps, 0u);
  EXPECT_EQ(nothing->owed, dt);
  EXPECT_EQ(part->substeps, 3u);
  EXPECT_EQ(more->substeps, 5u);
  EXPECT_EQ(more->owed, 0);
  EXPECT_EQ(s.world.steps(), 8u);
  EXPECT_NE(*s.world.state_hash(), hash);
}

TEST(Budget, RefusesWhatIsNone) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = jet_on_ice();
  const auto hash = *s.world.state_hash();
  for (const double budget : {0.0, -1.0, std::nan("")}) {
    const Result<TimedStep> r = s.world.step_within(1e-3, budget);
    ASSERT_FALSE(r);
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find("milliseconds: must be above 0"), std::string::npos)
        << r.error().message;
  }
  for (const double dt : {-1.0, std::nan(""), all}) EXPECT_FALSE(s.world.step_within(dt, 16));
  const Result<TimedStep> nothing = s.world.step_within(0, 16);
  require(nothing);
  EXPECT_EQ(nothing->substeps, 0u);
  EXPECT_EQ(s.world.steps(), 0u);
  EXPECT_EQ(*s.world.state_hash(), hash);
}

// A host that fell behind adds what it owes: the budget bounds the sub-steps of a call, not max_substeps. A step without one is refused.
TEST(Budget, BoundsTheSubStepsItself) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.max_substeps = 3;
  Scene s = ice_in_water(d, {});
  const double dt = 9.5 * s.world.stable_dt();
  EXPECT_FALSE(s.world.step(dt));
  EXPECT_FALSE(s.world.step_within(dt, all));
  const Result<TimedStep> starved = s.world.step_within(dt, none);
  require(starved);
  EXPECT_EQ(starved->planned, 10u);
  EXPECT_EQ(starved->substeps, 1u);
  const Result<TimedStep> part = s.world.step_part(dt, 2);
  require(part);
  EXPECT_EQ(part->substeps, 2u);
  require(s.world.step(0.2 * dt));
}

TEST(Budget, IsInterruptedLikeAStep) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = jet_on_ice();
  s.world.interrupt();
  const Result<TimedStep> r = s.world.step_within(0.01, all);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, ErrorCode::interrupted);
  require(s.world.step_within(0.01, all));
  EXPECT_EQ(s.world.time(), 0.01);
}

}  // namespace
}  // namespace meltsim_test
