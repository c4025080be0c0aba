// SPDX-License-Identifier: Apache-2.0
// Diffusive exchange with a plane wall against quadrature and against linear profiles on the lattice.
#include "meltsim/physics/wall_exchange.hpp"

#include <gtest/gtest.h>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double dx = 0.2;

/// Integral of L s over the half-space s > d in spherical shells (midpoint rule, 4000 shells: 1e-6), L
/// without epsilon: a shell of radius r > d contributes L pi r (r^2 - d^2) dr.
double half_space(double support, double d) {
  const auto k = uncorrected_kernel<double>(support);
  constexpr int n = 4000;
  const double dr = (support - d) / n;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double r = d + (i + 0.5) * dr, b = 1 - r / support;
    sum += k.laplacian_scale * b * b * b * 3.14159265358979323846 * r * (r * r - d * d) * dr;
  }
  return sum;
}

// Without stretch and with scale pi C H^4 the bracket is the integral.
TEST(WallExchange, IsTheIntegralOverTheOutside) {
  const double support = 0.5, c = uncorrected_kernel<double>(support).laplacian_scale;
  WallExchange<double> e;
  e.support = support;
  e.inv_support = 1 / support;
  e.stretch = 1;  // no correction
  e.scale = 3.14159265358979323846 * c * support * support * support * support;
  e.smallest_distance = 0.001;
  for (const double d : {0.02, 0.1, 0.2, 0.33, 0.45})
    EXPECT_NEAR(wall_area(e, d) / half_space(support, d), 1.0, 1e-5) << d;
}

/// Net viscous force per V mu and unit shear rate on layer m (from 1) of a half-filled lattice v = y, and the
/// wall's part of it. The wall rests at y = 0, layers at (m - 1/2) dx.
struct Layer {
  double net = 0, wall = 0;
};
Layer layer(double support, int m) {
  const auto k = make_kernel<double>(support, dx);
  const auto e = make_wall_exchange<double>(support, dx);
  const int n = static_cast<int>(support / dx) + 1;
  const double y = (m - 0.5) * dx;
  Layer out;
  for (int b = maximum(-n, 1 - m); b <= n; ++b)
    for (int a = -n; a <= n; ++a)
      for (int c = -n; c <= n; ++c) {
        const double r2 = dx * dx * double(a * a + b * b + c * c);
        out.net += dx * dx * dx * kernel_laplacian(k, std::sqrt(r2), r2) * dx * b;
      }
  out.wall = wall_area(e, y) / wall_depth(e, y) * (0.0 - y);
  out.net += out.wall;
  return out;
}

// Two conditions, two parameters: exact where the lattice has two layers in reach (bisection and sums: 1e-12
// of 1/dx). Wider supports have a third layer; 0.5 % of the wall's traction there, see the header.
TEST(WallExchange, LinearProfileOnTheLatticeIsInEquilibrium) {
  for (const double ratio : {1.5, 2.0, 2.5, 3.0, 4.0}) {
    double traction = 0;
    for (int m = 1; m <= 5; ++m) {
      const Layer l = layer(ratio * dx, m);
      const double tolerance = ratio <= 2.5 ? 1e-11 : 0.005;
      EXPECT_NEAR(l.net * dx, 0.0, tolerance) << "H/dx " << ratio << " layer " << m;
      traction -= l.wall * dx;  // per wall area: V/dx^2 each
    }
    EXPECT_NEAR(traction, 1.0, ratio <= 2.5 ? 1e-11 : 0.005) << "H/dx " << ratio;
  }
}

TEST(WallExchange, BoundedAtTheWallAndZeroBeyondReach) {
  const auto e = make_wall_exchange<float>(0.5, dx);
  EXPECT_EQ(wall_depth(e, -0.1f), 0.05f);
  EXPECT_EQ(wall_depth(e, 0.3f), 0.3f);
  EXPECT_TRUE(std::isfinite(wall_area(e, -0.1f)));
  EXPECT_EQ(wall_area(e, 0.5f), 0.0f);
  EXPECT_EQ(wall_area(e, 3.0f), 0.0f);
  float last = wall_area(e, 0.05f);
  for (float d = 0.06f; d < 0.5f; d += 0.01f) {
    const float now = wall_area(e, d);
    EXPECT_GE(now, 0.0f);
    EXPECT_LE(now, last);
    last = now;
  }
}

}  // namespace
