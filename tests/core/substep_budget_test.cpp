// SPDX-License-Identifier: Apache-2.0
// Counting out sub-steps by their cost, with a clock that is made up.
#include "world/substep_budget.hpp"

#include <gtest/gtest.h>

#include <random>

namespace meltsim {
namespace {

using core::next_batch;
using core::SubstepCost;

/// A frame of `budget` on a machine on which nothing runs ahead: as WorldImpl::Limit asks, one sub-step at a time.
struct Frame {
  double time = 0;
  int substeps = 0;
};
template <class Draw>
Frame frame_of(SubstepCost& cost, double budget, const Draw& draw) {
  Frame f;
  do {
    const double c = draw();
    f.time += c;
    ++f.substeps;
    cost.learn(c, 1);
  } while (next_batch(cost, budget - f.time, 0) != 0);
  return f;
}

// Sub-steps of 1 ms +- 10 %, budgets of 2 to 50 of them: 99 of 100 frames within 1.05 budgets, never more than 2 over in a row,
// and at least 0.7 of the budget is used less the sub-step that may be left out. Long enough to see a hundredth.
TEST(SubstepBudget, FramesKeepToItAndUseIt) {
  for (const double budget : {2e-3, 5e-3, 16e-3, 50e-3}) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> draw(0.9e-3, 1.1e-3);
    SubstepCost cost;
    int over = 0, row = 0, longest = 0;
    double used = 0;
    const int frames = 2000;
    for (int i = 0; i < frames; ++i) {
      const Frame f = frame_of(cost, budget, [&] { return draw(random); });
      used += f.time;
      const bool late = f.time > 1.05 * budget;
      over += late ? 1 : 0;
      row = late ? row + 1 : 0;
      longest = std::max(longest, row);
    }
    EXPECT_LE(over, frames / 100) << budget;
    EXPECT_LE(longest, 2) << budget;
    EXPECT_GT(used / frames, 0.7 * (budget - 1.1e-3)) << budget;
  }
}

// A machine that becomes three times slower in the middle: frames are late while the mean follows, 16 sub-steps of weight
// 1/8, a few frames of this budget, and then no more. That it becomes quick again is seen at once.
TEST(SubstepBudget, FollowsAMachineThatSlowsDown) {
  SubstepCost cost;
  const double budget = 10e-3;
  const auto at = [](double c) { return [c] { return c; }; };
  for (int i = 0; i < 50; ++i) EXPECT_LE(frame_of(cost, budget, at(0.5e-3)).time, budget);
  int late = 0;
  for (int i = 0; i < 50; ++i) late += frame_of(cost, budget, at(1.5e-3)).time > 1.05 * budget ? 1 : 0;
  EXPECT_LE(late, 1);
  EXPECT_LE(frame_of(cost, budget, at(1.5e-3)).time, budget);
  const Frame quick = frame_of(cost, budget, at(0.5e-3));
  EXPECT_LE(quick.time, budget);
  EXPECT_GE(quick.substeps, 15);
}

TEST(SubstepBudget, StarvedTakesOneSubStepAFrame) {
  SubstepCost cost;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(frame_of(cost, 1e-3, [] { return 10e-3; }).substeps, 1);
}

TEST(SubstepBudget, OneSubStepIsTriedWhereNothingIsKnown) {
  const SubstepCost cost;
  EXPECT_EQ(next_batch(cost, 1, 0), 1u);
  EXPECT_EQ(next_batch(cost, 1, 1), 0u);  // it is under way
  EXPECT_EQ(next_batch(cost, 0, 0), 0u);
}

// What is under way counts: 8 of 10 ms are left for sub-steps of 1 ms; a quarter of what fits beside those is enqueued.
TEST(SubstepBudget, SubStepsUnderWayCount) {
  SubstepCost cost;
  for (int i = 0; i < 100; ++i) cost.learn(1e-3, 1);
  EXPECT_NEAR(cost.mean(), 1e-3, 1e-9);
  EXPECT_EQ(next_batch(cost, 8.5e-3, 0), 2u);
  EXPECT_EQ(next_batch(cost, 8.5e-3, 4), 1u);
  EXPECT_EQ(next_batch(cost, 8.5e-3, 8), 0u);
  EXPECT_EQ(next_batch(cost, 1000, 0), 64u);  // however much there is time for
}

// The first sub-steps of a World record graphs and allocate: 50 ms once must not starve the frames after it.
TEST(SubstepBudget, ADearFirstSubStepIsForgotten) {
  SubstepCost cost;
  cost.learn(50e-3, 1);
  EXPECT_EQ(next_batch(cost, 16e-3, 0), 0u);
  EXPECT_EQ(frame_of(cost, 16e-3, [] { return 0.9e-3; }).substeps, 17);
}

}  // namespace
}  // namespace meltsim
