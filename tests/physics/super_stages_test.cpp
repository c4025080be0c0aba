// SPDX-License-Identifier: Apache-2.0
// Runge-Kutta-Legendre stages on y' = -lambda y, where one super-step multiplies y by a polynomial R(z),
// z = tau lambda. s up to 65, the default maximum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "meltsim/physics/diffusion.hpp"

namespace {

using namespace meltsim::physics;

/// R(z), the way the solver runs: on increments d_j = Y_j - Y_0.
double amplification(int s, double z) {
  double d1 = 0, d2 = 0;  // d_{j-1}, d_{j-2}
  for (int j = 1; j <= s; ++j) {
    const double d = next_increment(
        stage_factors(j, s, z, true, true), -(1 + d1), [&] { return d1; }, [&] { return d2; },
        [] { return -1.0; });
    d2 = d1;
    d1 = d;
  }
  return 1 + d1;
}

TEST(SuperStages, OneStageIsEuler) {
  for (const double z : {0.0, 0.3, 1.0}) EXPECT_DOUBLE_EQ(amplification(1, z), 1 - z);
}

// P_2(1 - z/3), the second Legendre polynomial shifted to [0, 6].
TEST(SuperStages, TwoStagesAreRkl1) {
  for (const double z : {0.0, 0.3, 1.0, 3.0, 6.0})
    EXPECT_NEAR(amplification(2, z), 1 - z + z * z / 6, 1e-14) << z;
}

// R = P_s(1 - 2 z/(s^2 + s)), P_s the Legendre polynomial: Meyer et al. (2014), eq. (12). What is left of the start is
// never less than nothing by more than 1/2, and M(Y_0) has no negative weight.
TEST(SuperStages, EvenStagesAreRkl1) {
  for (int s = 2; s <= 64; s += 2) {
    for (int k = 0; k <= 40; ++k) {
      const double x = 1 - k / 20.0, z = stage_reach(s) * k / 40;
      double p0 = 1, p1 = x;
      for (int n = 2; n <= s; ++n) {
        const double p = ((2 * n - 1) * x * p1 - (n - 1) * p0) / n;
        p0 = p1;
        p1 = p;
      }
      EXPECT_NEAR(amplification(s, z), p1, 1e-10) << s << " " << z;
      EXPECT_GE(p1, -0.5) << s;
    }
    for (int j = 1; j <= s; ++j) EXPECT_EQ(super_stage(j, s).gamma_rate, 0) << s;
  }
}

// Second order: R = 1 - z + z^2/2 + O(z^3) with a third-order coefficient below 1/6.
TEST(SuperStages, SecondOrder) {
  for (int s = 3; s <= 65; s += 2)
    for (const double z : {1e-2, 1e-3})
      EXPECT_NEAR(amplification(s, z), 1 - z + 0.5 * z * z, z * z * z / 6) << s;
}

// The same over a fixed time: halving the step divides the error by four (3.5: higher orders still show).
TEST(SuperStages, ErrorFallsByFour) {
  for (const int s : {3, 9, 33}) {
    const double coarse = std::fabs(std::pow(amplification(s, 0.1), 10) - std::exp(-1.0));
    const double fine = std::fabs(std::pow(amplification(s, 0.05), 20) - std::exp(-1.0));
    EXPECT_GT(coarse / fine, 3.5) << s;
    EXPECT_LT(coarse / fine, 4.6) << s;
  }
}

// |R| <= 1 on all of [0, reach]; 1e-10 for the rounding of 65 stages. Just beyond it must grow: the reach is
// not understated.
TEST(SuperStages, StableUpToTheReach) {
  for (int s = 1; s <= 65; ++s) {
    const double reach = stage_reach(s);
    for (int k = 0; k <= 400; ++k)
      ASSERT_LE(std::fabs(amplification(s, reach * k / 400)), 1 + 1e-10)
          << s << " stages, z " << reach * k / 400;
    double beyond = 0;
    for (int k = 1; k <= 20; ++k)
      beyond = std::max(beyond, std::fabs(amplification(s, reach * (1 + 0.01 * k))));
    EXPECT_GT(beyond, 1.0) << s;
  }
}

TEST(SuperStages, CountIsTheSmallestThatReaches) {
  for (const bool first_order : {false, true}) {
    const int first = first_order ? 4 : 5;
    for (double z = 0.01; z < 3000; z *= 1.037) {
      const int s = stage_count(z, first_order);
      EXPECT_GE(stage_reach(s), z);
      if (z <= 2) {
        EXPECT_EQ(s, 1) << z;
      } else if (z <= 6) {
        EXPECT_EQ(s, 2) << z;
      } else {
        EXPECT_EQ(s % 2, first % 2) << z;
        EXPECT_GE(s, first);
        EXPECT_TRUE(s == first || stage_reach(s - 2) < z) << z;
      }
    }
    EXPECT_EQ(stage_count(stage_reach(1), first_order), 1);
    EXPECT_EQ(stage_count(stage_reach(2), first_order), 2);
    for (int s = first; s <= 65; s += 2) EXPECT_EQ(stage_count(stage_reach(s), first_order), s);
  }
}

TEST(SuperStages, MostIsOneThatIsGiven) {
  for (int most = 2; most <= 66; ++most)
    for (const bool first_order : {false, true}) {
      const int s = most_stages(most, first_order);
      EXPECT_LE(s, most);
      EXPECT_GE(s, std::max(2, most - 1));
      EXPECT_TRUE(s == 2 || (s % 2 == 0) == first_order) << most;
      if (s == 3) continue;  // two reach as far as three
      EXPECT_EQ(stage_count(stage_reach(s), first_order), s);
    }
}

}  // namespace
