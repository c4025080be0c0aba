// SPDX-License-Identifier: Apache-2.0
// Flow curves against their limits, and the fitted velocity gradient against fields that it must give exactly.
#include "meltsim/physics/flow_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/strain_rate.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;

using Vec3d = Vec3<double>;
constexpr double none = std::numeric_limits<double>::infinity();

// tau = mu gd is tau_y + K gd^n where exp(-m gd) is nothing: 1e-12 at m gd = 30.
TEST(FlowCurve, IsHerschelBulkleyWhereItYields) {
  for (const double n : {0.3, 0.5, 1.0, 1.5, 2.5})
    for (const double rate : {0.3, 1.0, 7.0}) {
      const FlowCurve<double> c{40, n, 100, none};
      const double tau = 40 + 3 * std::pow(rate, n);
      EXPECT_NEAR(flow_viscosity(c, 3.0, rate) * rate, tau, 1e-12 * tau) << n << ", " << rate;
    }
}

// Without yield stress and with n = 1 the consistency is the viscosity, to the last bit.
TEST(FlowCurve, OfANewtonianLiquidIsItsViscosity) {
  for (const double rate : {0.0, 1e-9, 1.0, 1e6})
    EXPECT_EQ(flow_viscosity(FlowCurve<double>{0, 1, 100, none}, 0.37, rate), 0.37);
}

// At rest tau_y m + K m^(1-n), continuous there, and never above it for n <= 1: what steps are made for. Both
// branches of (1 - exp(-x))/x meet at x = 1e-3: their second order, 1e-6/6, is what is left.
TEST(FlowCurve, IsBoundedAtRest) {
  for (const double n : {0.4, 1.0}) {
    const FlowCurve<double> c{40, n, 100, none};
    const double rest = flow_viscosity(c, 3.0, 0.0);
    EXPECT_NEAR(rest, 4000 + 3 * std::pow(100, 1 - n), 1e-9);
    EXPECT_EQ(rest, largest_flow_viscosity(c, 3.0));
    double before = rest;
    for (double rate = 1e-8; rate < 1e4; rate *= 1.01) {
      const double mu = flow_viscosity(c, 3.0, rate);
      EXPECT_LE(mu, before * (1 + 2e-7)) << rate;
      EXPECT_GE(mu, least_flow_viscosity(c, 3.0, 1e4) * (1 - 1e-12));
      before = mu;
    }
  }
  // In single precision, too: nothing is infinite or 0/0.
  EXPECT_EQ(flow_viscosity(FlowCurve<float>{40, 1, 100, static_cast<float>(none)}, 0.0f, 0.0f), 4000.0f);
}

TEST(FlowCurve, ThickeningCountsRatesUpToALimit) {
  const double limit = largest_flow_rate(1.5, 20, 0.01);
  EXPECT_EQ(limit, 200);
  EXPECT_EQ(largest_flow_rate(1, 20, 0.01), none);
  const FlowCurve<double> c{0, 1.5, 100, limit};
  EXPECT_EQ(flow_viscosity(c, 2.0, 1e5), flow_viscosity(c, 2.0, limit));
  EXPECT_NEAR(largest_flow_viscosity(c, 2.0), 2 * std::sqrt(200), 1e-12);
  EXPECT_NEAR(least_flow_viscosity(c, 2.0, limit), 2 * std::sqrt(0.01), 1e-12);
}

/// The fit at the middle of a jittered lattice, cut off by a plane if `half`.
Mat3<double> fitted(const Mat3<double>& A, bool half, std::uint32_t seed) {
  const auto k = make_kernel<double>(0.25, 0.1);
  test_support::Random random(seed);
  GradientSum<double> s;
  for (int z = -3; z <= 3; ++z)
    for (int y = half ? 0 : -3; y <= 3; ++y)
      for (int x = -3; x <= 3; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3d at = Vec3d{x * 0.1, y * 0.1, z * 0.1} + random.vector(0.02);
        const double r2 = dot(at, at), r = std::sqrt(r2);
        if (r < k.support) add_neighbour(s, 1e-3 * kernel_laplacian(k, r, r2), -at, -(A * at));
      }
  return velocity_gradient(s);
}

// Exact for a linear field, at a surface, too, but for least_moment: 0.1 % inside, where M is 1, 1 % where little of it is left.
TEST(StrainRate, OfALinearFieldIsExact) {
  test_support::Random random(3);
  for (int n = 0; n < 50; ++n) {
    Mat3<double> A;
    for (auto& row : A.m)
      for (double& a : row) a = random.uniform(-1, 1);
    for (const bool half : {false, true}) {
      const Mat3<double> found = fitted(A, half, static_cast<std::uint32_t>(n));
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(found.m[i][j], A.m[i][j], half ? 0.01 : 0.003);
    }
  }
}

// What turns or swells does not shear; a shear of 1/s is 1/s in any direction.
TEST(StrainRate, CountsShearAlone) {
  Mat3<double> spin, swell = identity3<double>(), shear;
  spin.m[0][1] = 2, spin.m[1][0] = -2;
  EXPECT_EQ(shear_rate(spin), 0);
  EXPECT_NEAR(shear_rate(swell), 0, 1e-15);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (i != j) {
        shear = {};
        shear.m[i][j] = -1;
        EXPECT_EQ(shear_rate(shear), 1);
      }
  // Uniaxial extension at e: sqrt(3) e (any text on rheology).
  Mat3<double> pull;
  pull.m[0][0] = 1, pull.m[1][1] = pull.m[2][2] = -0.5;
  EXPECT_NEAR(shear_rate(pull), std::sqrt(3.0), 1e-15);
}

// A thread of particles has a rate along itself and none across; alone, none at all.
TEST(StrainRate, OfThreadsAndSingleParticlesIsFinite) {
  EXPECT_EQ(shear_rate(velocity_gradient(GradientSum<double>{})), 0);
  const auto k = make_kernel<float>(0.25, 0.1);
  GradientSum<float> s;
  for (const float x : {-0.2f, -0.1f, 0.1f, 0.2f})
    add_neighbour(s, 1e-3f * kernel_laplacian(k, std::fabs(x), x * x), Vec3<float>{-x, 0, 0},
                  Vec3<float>{0, -3 * x, 0});
  const Mat3<float> A = velocity_gradient(s);
  EXPECT_NEAR(A.m[1][0], 3, 0.01);
  EXPECT_EQ(A.m[1][1], 0);
  EXPECT_EQ(A.m[1][2], 0);
}

// A parabola beside a wall: with the wall's weight the slope is that at the particle. Without it neighbours on one side alone
// would find one 6 % less, in the first layer; the weight of the ghosts alone leaves 3 %.
TEST(StrainRate, OfAParabolaAtAWallIsCentred) {
  const auto k = make_kernel<double>(0.25, 0.1);
  const auto flow = [](double y) { return y - 0.5 * y * y; };
  for (const double depth : {0.05, 0.15}) {
    GradientSum<double> s;
    for (int z = -3; z <= 3; ++z)
      for (int layer = 0; layer < 6; ++layer)
        for (int x = -3; x <= 3; ++x) {
          const Vec3d at{x * 0.1, 0.05 + layer * 0.1 - depth, z * 0.1};
          const double r2 = dot(at, at), r = std::sqrt(r2);
          if (r2 > 1e-9 && r < k.support)
            add_neighbour(s, 1e-3 * kernel_laplacian(k, r, r2), -at,
                          Vec3d{flow(depth) - flow(depth + at.y), 0, 0});
        }
    const Vec3d normal{0, 1, 0};
    add_neighbour(s, wall_weight(s.skew, normal, depth, 0.0), normal * depth, Vec3d{flow(depth), 0, 0});
    EXPECT_NEAR(velocity_gradient(s).m[0][1], 1 - depth, 0.002) << depth;
  }
  // One particle thick, a film has the ghosts' weight.
  EXPECT_EQ(wall_weight(Vec3d{}, Vec3d{0, 1, 0}, 0.05, 7.0), 7);
}

}  // namespace
