// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "stepper.hpp"

namespace runner {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

TEST(Stepper, AFrameIsCutIntoEqualSteps) {
  EXPECT_DOUBLE_EQ(fixed_frame_dt(0, 0.04, 0.005), 0.005);
  EXPECT_DOUBLE_EQ(fixed_frame_dt(0, 0.04, 0.003), 0.04 / 14);
  EXPECT_DOUBLE_EQ(fixed_frame_dt(0, 0.04, 1), 0.04);
}

TEST(Stepper, FixedFramesEndExactlyWhereTheyShould) {
  // 100,000 frames of 8 steps: rounding must neither add nor lose a step.
  double now = 0;
  long steps = 0;
  for (int frame = 1; frame <= 100000; ++frame) {
    const double end = frame / 25.0;
    while (now < end) {
      const Batch batch = fixed_batch(now, end, 0.005);
      ASSERT_GT(batch.steps, 0);
      steps += batch.steps;
      now = batch.end;
    }
    ASSERT_EQ(now, end);
  }
  EXPECT_EQ(steps, 800000);
}

TEST(Stepper, AdaptiveStepsAreEqualAndLandOnTheTarget) {
  const Batch all = adaptive_batch(1, 1.04, 0.011);
  EXPECT_EQ(all.steps, 4);
  EXPECT_NEAR(all.dt, 0.01, 1e-15);
  EXPECT_EQ(all.end, 1.04);
  const Batch some = adaptive_batch(0, 0.04, 0.001);
  EXPECT_EQ(some.steps, adaptive_steps_per_batch);
  EXPECT_NEAR(some.end, 0.008, 1e-15);
}

TEST(Stepper, TimesAreReachedWhateverTheirSize) {
  EXPECT_TRUE(reached(3 * 0.1, 0.3));
  EXPECT_TRUE(reached(0.3, 3 * 0.1));
  EXPECT_FALSE(reached(1.2e-8, 1.3e-8));
  EXPECT_FALSE(reached(1e6 - 1e-6, 1e6));
}

TEST(Stepper, NothingLimitsTheStepOfAnEmptyWorld) {
  const Batch batch = adaptive_batch(0, 0.04, inf);
  EXPECT_EQ(batch.steps, 1);
  EXPECT_EQ(batch.end, 0.04);
  EXPECT_EQ(automatic_dt(inf, 0.04), 0.04);
  EXPECT_DOUBLE_EQ(automatic_dt(0.003, 0.04), 0.04 / 14);
}

}  // namespace
}  // namespace runner
