// SPDX-License-Identifier: Apache-2.0
// Surface tension: constants against integrals made here, wetting at angles whose cosine is known.
#include "meltsim/physics/surface_tension.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double pi = 3.14159265358979323846;

/// int_0^1 u^n (-w) du by the midpoint rule: 1e5 points leave 1e-10.
double moment(int n) {
  const SphKernel<double> k = uncorrected_kernel<double>(1.0);
  const int points = 100000;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const double u = (i + 0.5) / points;
    sum -= std::pow(u, n) * cohesion_shape(k, u) / points;
  }
  return sum;
}

TEST(SurfaceTension, StrengthAndPressureFollowTheIntegrals) {
  for (const double support : {1.0, 2.5e-3}) {
    const double s = cohesion_strength(0.072, support);
    EXPECT_NEAR(cohesion_gain * pi / 8 * s * std::pow(support, 6) * moment(5) / 0.072, 1, 1e-8);
    EXPECT_NEAR(2 * pi / 3 * s * std::pow(support, 5) * moment(4) / cohesion_pressure(0.072, support), 1,
                1e-8);
  }
}

TEST(SurfaceTension, PairsRepelWithinAndAttractBeyond) {
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  const double turn = 2.5 * (1 - std::cbrt(1 / cohesion_core));
  EXPECT_GT(cohesion_shape(k, 0.99 * turn), 0);
  EXPECT_LT(cohesion_shape(k, 1.01 * turn), 0);
  EXPECT_EQ(cohesion_shape(k, 2.5), 0);
  EXPECT_EQ(cohesion_factor(2.0, 3.0, cohesion_of(0.3, 0.7)),
            cohesion_factor(3.0, 2.0, cohesion_of(0.7, 0.3)));
}

// Young and Dupre: work of adhesion over twice the tension is (1 + cos theta)/2.
TEST(SurfaceTension, WettingFollowsYoung) {
  EXPECT_DOUBLE_EQ(wetting_share(0), 1);
  EXPECT_NEAR(wetting_share(60), 0.75, 1e-12);
  EXPECT_NEAR(wetting_share(90), 0.5, 1e-12);
  EXPECT_NEAR(wetting_share(180), 0, 1e-12);
  EXPECT_EQ(adhesion_of(2.0, 0.5), 2);
}

// Waves two spacings long on a deep liquid, omega^2 = sigma k^3/rho with k = pi/dx, turn by pi/sqrt(2) in that time.
TEST(SurfaceTension, StepResolvesTheShortestWaves) {
  const double dx = 1e-3, omega = std::sqrt(0.072 * std::pow(pi / dx, 3) / 1000);
  EXPECT_NEAR(capillary_dt(0.072, 1000, dx) * omega, pi / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(cohesion_sound_speed(0.072, 1000, dx), 3.75659, 1e-4);
}

}  // namespace
