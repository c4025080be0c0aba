// SPDX-License-Identifier: Apache-2.0
// Runge-Kutta-Legendre stages on y' = -lambda y, where one super-step multiplies y by a polynomial R(z),
// z = tau lambda. s up to 65, the default maximum.
#include <gtest/gtest.h>

#include <cmath>

#include "meltsim/physics/heat.hpp"

namespace {

using namespace meltsim::physics;

/// R(z), the way the solver runs: on increments d_j = Y_j - Y_0.
double amplification(int s, double z) {
  double d1 = 0, d2 = 0;  // d_{j-1}, d_{j-2}
  for (int j = 1; j <= s; ++j) {
    const HeatStage c = heat_stage(j, s);
    const double d = c.mu * d1 + c.nu * d2 - c.mu_rate * z * (1 + d1) - c.gamma_rate * z;
    d2 = d1;
    d1 = d;
  }
  return 1 + d1;
}

TEST(HeatStages, OneStageIsEuler) {
  for (const double z : {0.0, 0.3, 1.0}) EXPECT_DOUBLE_EQ(amplification(1, z), 1 - z);
}

// P_2(1 - z/3), the second Legendre polynomial shifted to [0, 6].
TEST(HeatStages, TwoStagesAreRkl1) {
  for (const double z : {0.0, 0.3, 1.0, 3.0, 6.0})
    EXPECT_NEAR(amplification(2, z), 1 - z + z * z / 6, 1e-14) << z;
}

// Second order: R = 1 - z + z^2/2 + O(z^3) with a third-order coefficient below 1/6.
TEST(HeatStages, SecondOrder) {
  for (int s = 3; s <= 65; ++s)
    for (const double z : {1e-2, 1e-3})
      EXPECT_NEAR(amplification(s, z), 1 - z + 0.5 * z * z, z * z * z / 6) << s;
}

// The same over a fixed time: halving the step divides the error by four (3.5: higher orders still show).
TEST(HeatStages, ErrorFallsByFour) {
  for (const int s : {3, 9, 33}) {
    const double coarse = std::fabs(std::pow(amplification(s, 0.1), 10) - std::exp(-1.0));
    const double fine = std::fabs(std::pow(amplification(s, 0.05), 20) - std::exp(-1.0));
    EXPECT_GT(coarse / fine, 3.5) << s;
    EXPECT_LT(coarse / fine, 4.6) << s;
  }
}

// |R| <= 1 on all of [0, reach]; 1e-10 for the rounding of 65 stages. Just beyond it must grow: the reach is
// not understated.
TEST(HeatStages, StableUpToTheReach) {
  for (int s = 1; s <= 65; ++s) {
    const double reach = heat_stage_reach(s);
    for (int k = 0; k <= 400; ++k)
      ASSERT_LE(std::fabs(amplification(s, reach * k / 400)), 1 + 1e-10)
          << s << " stages, z " << reach * k / 400;
    double beyond = 0;
    for (int k = 1; k <= 20; ++k)
      beyond = std::max(beyond, std::fabs(amplification(s, reach * (1 + 0.01 * k))));
    EXPECT_GT(beyond, 1.0) << s;
  }
}

TEST(HeatStages, CountIsTheSmallestThatReaches) {
  for (double z = 0.01; z < 3000; z *= 1.037) {
    const int s = heat_stage_count(z);
    EXPECT_GE(heat_stage_reach(s), z);
    if (z <= 2) {
      EXPECT_EQ(s, 1) << z;
    } else if (z <= 6) {
      EXPECT_EQ(s, 2) << z;
    } else {
      EXPECT_EQ(s % 2, 1) << z;
      EXPECT_GE(s, 5);
      EXPECT_TRUE(s == 5 || heat_stage_reach(s - 2) < z) << z;
    }
  }
  EXPECT_EQ(heat_stage_count(heat_stage_reach(1)), 1);
  EXPECT_EQ(heat_stage_count(heat_stage_reach(2)), 2);
  for (int s = 5; s <= 65; s += 2) EXPECT_EQ(heat_stage_count(heat_stage_reach(s)), s);
}

}  // namespace
