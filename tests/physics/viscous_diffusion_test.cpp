// SPDX-License-Identifier: Apache-2.0
// Viscosity as diffusion of velocity: its conductance against the explicit pair force, and how many stages a sub-step takes.
#include "meltsim/physics/viscous_diffusion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/integrate.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double solid = resistivity_of_solid;

// The same number as mu V V L of fluid.hpp, which is rounded elsewhere: a few units in the last place of double.
TEST(ViscousDiffusion, ConductanceIsTheExplicitPairForce) {
  const auto k = make_kernel<double>(0.25, 0.1);
  test_support::Random random(1);
  for (int n = 0; n < 200; ++n) {
    const double mu_i = std::exp(random.uniform(-7, 9)), mu_j = std::exp(random.uniform(-7, 9));
    const double vi = random.uniform(0.5, 2), vj = random.uniform(0.5, 2), r = random.uniform(0.01, 0.25);
    const auto l = laplacian_quotient(k, r, r * r);
    const auto expected = [&](double mu) {
      return viscous_factor(mu, vi, vj, kernel_laplacian(k, r, r * r));
    };
    const auto near = [](double a, double b) { EXPECT_NEAR(a, b, 1e-14 * std::fabs(b)); };
    near(viscous_conductance(vi, vj, l, 1 / mu_i, 1 / mu_j), expected(pair_viscosity(mu_i, mu_j)));
    // A body is a liquid of infinite viscosity, as in coupling_force.
    near(viscous_conductance(vi, vj, l, 1 / mu_i, solid), expected(no_slip_viscosity(mu_i)));
    near(viscous_conductance(vi, vj, l, solid, 1 / mu_j), expected(no_slip_viscosity(mu_j)));
  }
}

// To the last bit, in single precision too: else momentum would not stay.
TEST(ViscousDiffusion, ConductanceIsSymmetric) {
  const auto k = make_kernel<float>(0.25, 0.1);
  test_support::Random random(2);
  for (int n = 0; n < 1000; ++n) {
    const auto number = [&](double low, double high) {
      return static_cast<float>(random.uniform(low, high));
    };
    const float r = number(0.01, 0.25), vi = number(0.5, 2), vj = number(0.5, 2);
    const float ri = n % 3 == 0 ? -1.0f : number(1e-4, 1e3), rj = n % 5 == 1 ? -1.0f : number(1e-4, 1e3);
    const auto l = laplacian_quotient(k, r, r * r);
    ASSERT_EQ(viscous_conductance(vi, vj, l, ri, rj), viscous_conductance(vj, vi, l, rj, ri));
  }
}

TEST(ViscousDiffusion, BodiesAndInviscidLiquidExchangeNothing) {
  const auto l = laplacian_quotient(make_kernel<double>(0.25, 0.1), 0.1, 0.01);
  const double none = std::numeric_limits<double>::infinity();
  EXPECT_EQ(viscous_conductance(1.0, 1.0, l, solid, solid), 0.0);
  EXPECT_EQ(viscous_conductance(1.0, 1.0, l, none, 0.5), 0.0);
  EXPECT_EQ(viscous_conductance(1.0, 1.0, l, none, solid), 0.0);
  EXPECT_EQ(viscous_conductance(1.0, 1.0, l, none, none), 0.0);
  // Beside a particle of a body or a removed volume of 0 nothing becomes a NaN.
  EXPECT_EQ(viscous_conductance(1.0, 0.0, l, 0.5, solid), 0.0);
}

// What a pair with a body adds to the bound of the stages is what the same pair of liquid adds: it counts once, not twice.
TEST(ViscousDiffusion, BodiesCountTowardsTheBoundLikeLiquid) {
  const auto l = laplacian_quotient(make_kernel<double>(0.25, 0.1), 0.1, 0.01);
  for (const double r : {1e-3, 0.5, 1e4}) {
    const double liquid = viscous_conductance(1.0, 1.0, l, r, r) * bound_share(r, r);
    EXPECT_DOUBLE_EQ(viscous_conductance(1.0, 1.0, l, r, solid) * bound_share(r, solid), liquid);
    EXPECT_DOUBLE_EQ(viscous_conductance(1.0, 1.0, l, solid, r) * bound_share(solid, r), liquid);
  }
}

// lambda over 2 is the rate at which viscous_dt is the limit, times the head room.
TEST(ViscousDiffusion, LambdaFollowsFromTheExplicitBound) {
  EXPECT_DOUBLE_EQ(viscous_lambda(10, 1000, 200), 2 * viscous_margin / viscous_dt(0.01, 200));
}

TEST(ViscousDiffusion, StagesReachAndAreFew) {
  for (double z = 0.01; z < 1e7; z *= 1.13) {
    const ViscousStages v = viscous_stages(z);
    ASSERT_EQ(v.supersteps, std::round(v.supersteps)) << z;
    ASSERT_GE(v.supersteps * stage_reach(v.stages), z * (1 - 1e-11)) << z;
    ASSERT_LE(v.stages, most_viscous_stages) << z;
    ASSERT_TRUE(v.stages == 1 || v.stages % 2 == 0) << z;  // first order
    if (z <= stage_reach(single_viscous_stages)) {
      ASSERT_EQ(v.supersteps, 1) << z;
    } else if (z <= 2 * stage_reach(most_viscous_stages)) {
      ASSERT_EQ(v.supersteps, 2) << z;
    } else {  // one super-step fewer would not reach
      ASSERT_LT((v.supersteps - 1) * stage_reach(most_viscous_stages), z) << z;
    }
    if (v.stages > 2) {
      ASSERT_LT(stage_reach(v.stages - 2), z / v.supersteps) << z;
    }
  }
}

// What is left of a mode, from slow ones to those at the reach: beyond single_viscous_stages never negative, so that a
// sudden load does not overshoot, and of stiff modes little. 0.173: R of six stages falls to -0.4147, the first minimum of
// the Legendre polynomial P_6, of more stages to less.
TEST(ViscousDiffusion, TwoSuperStepsDoNotOvershoot) {
  for (const double z : {43.0, 300.0, 5000.0}) {
    const ViscousStages v = viscous_stages(z);
    for (int k = 1; k <= 400; ++k) {
      const double mode = z * k / 400;
      double left = 1;
      for (int n = 0; n < static_cast<int>(v.supersteps); ++n) {
        double d1 = 0, d2 = 0;
        for (int j = 1; j <= v.stages; ++j) {
          const double d = next_increment(
              stage_factors(j, v.stages, mode / v.supersteps, true, true), -(1 + d1), [&] { return d1; },
              [&] { return d2; }, [] { return 0.0; });
          d2 = d1;
          d1 = d;
        }
        left *= 1 + d1;
      }
      ASSERT_GE(left, 0) << mode;
      if (mode > 4) {
        ASSERT_LE(left, 0.173) << mode;
      }
    }
  }
}

}  // namespace
