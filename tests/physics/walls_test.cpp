// SPDX-License-Identifier: Apache-2.0
// The wall table against quadrature that knows nothing of it: box [0, 4]^3, dx = 0.2 m, H = 2.5 dx.
#include "meltsim/physics/walls.hpp"

#include <gtest/gtest.h>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double dx = 0.2, support = 0.5, table_cell = (support + 0.5 * dx) / (wall_table_points - 1);

class Walls : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    table().resize(wall_table_size);
    make_wall_table(support, dx, table().data());
  }
  static std::vector<WallNode<double>>& table() {
    static std::vector<WallNode<double>> t;
    return t;
  }
  static WallBox<double> box(std::uint32_t faces = 63u) {
    WallBox<double> b;
    b.max = {4, 4, 4};
    b.faces = faces;
    b.support = support;
    b.half_spacing = 0.5 * dx;
    b.nodes_per_length = 1 / table_cell;
    return b;
  }
  static WallSums<double> at(Vec3<double> x, std::uint32_t faces = 63u) {
    return wall_sums(box(faces), table().data(), x);
  }
};

/// d sigma/d d the walls were calibrated with; another value means another pressure in tanks.
constexpr double stretch = 2.5;

/// Stretched distance, as the header has it.
double sigma(double d) { return minimum(stretch * d - (stretch - 1) * 0.5 * dx, support); }

struct Outside {
  double w = 0, l = 0;
};

/// Integrals of W and L over {x > a or y > b or z > c}: everything minus the inside, midpoints fitted to it.
Outside outside(double a, double b, double c) {
  const auto k = make_kernel<double>(support, dx);
  const auto box_integral = [&](double p, double q, double r) {
    constexpr int n = 64;  // midpoint rule on the C1 kernel: 1e-4
    const double u = (p + support) / n, v = (q + support) / n, w = (r + support) / n;
    Outside sum;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int m = 0; m < n; ++m) {
          const double x = (i + 0.5) * u - support, y = (j + 0.5) * v - support, z = (m + 0.5) * w - support;
          const double r2 = x * x + y * y + z * z;
          if (r2 >= support * support) continue;
          sum.w += kernel_value(k, std::sqrt(r2));
          sum.l += kernel_laplacian(k, std::sqrt(r2), r2);
        }
    return Outside{sum.w * u * v * w, sum.l * u * v * w};
  };
  const Outside all = box_integral(support, support, support), in = box_integral(a, b, c);
  return {all.w - in.w, all.l - in.l};
}

/// What makes a plane at dx/2 complete a lattice.
double scale() { return lattice_half_space(support, dx) / outside(0.5 * dx, support, support).w; }

// The header promises 0.5 % of trilinear error. Relative to the first layer's share (lambda vanishes far
// out), resp. its Lw; a corner has three interpolated axes: three times that.
TEST_F(Walls, EqualQuadratureAtPlaneEdgeAndCorner) {
  const double s = scale(), far = 2.0;
  const double lambda = lattice_half_space(support, dx);
  const double traction = s * outside(0.5 * dx, support, support).l;
  const double near[] = {0.045, 0.07, 0.1, 0.133, 0.19};
  for (const double d : near) {
    const Outside plane = outside(sigma(d), support, support);
    for (const Vec3<double>& x :
         {Vec3<double>{d, far, far}, Vec3<double>{far, 4 - d, far}, Vec3<double>{far, far, d}}) {
      EXPECT_NEAR(at(x).lambda, s * plane.w, 0.005 * lambda) << "plane " << d;
      EXPECT_NEAR(at(x).laplacian, s * plane.l, 0.005 * traction) << "plane " << d;
    }
  }
  for (const double d : {0.07, 0.1, 0.16}) {
    const double e = 0.12;
    const Outside edge = outside(sigma(d), sigma(e), support);
    EXPECT_NEAR(at({d, e, far}).lambda, s * edge.w, 0.01 * lambda) << "edge " << d;
    EXPECT_NEAR(at({far, 4 - d, 4 - e}).lambda, s * edge.w, 0.01 * lambda) << "edge " << d;
    EXPECT_NEAR(at({far, 4 - d, 4 - e}).laplacian, s * edge.l, 0.01 * traction) << "edge " << d;
    const Outside corner = outside(sigma(d), sigma(e), sigma(0.1));
    EXPECT_NEAR(at({d, 4 - e, 0.1}).lambda, s * corner.w, 0.015 * lambda) << "corner " << d;
    EXPECT_NEAR(at({d, 4 - e, 0.1}).laplacian, s * corner.l, 0.015 * traction) << "corner " << d;
  }
}

// The scale is made with the same interpolation, so a plane is exact; edges and corners inherit what the
// continuum integral differs from a lattice's sum there: 0.5 and 1.4 % of phi.
TEST_F(Walls, FirstLayerReadsOne) {
  const auto k = make_kernel<double>(support, dx);
  const auto liquid = [&](int low_x, int low_y, int low_z) {
    double phi = 0;
    for (int z = low_z; z <= 3; ++z)
      for (int y = low_y; y <= 3; ++y)
        for (int x = low_x; x <= 3; ++x)
          phi += dx * dx * dx * kernel_value(k, dx * std::sqrt(double(x * x + y * y + z * z)));
    return phi;
  };
  EXPECT_NEAR(liquid(0, -3, -3) + at({0.1, 2, 2}).lambda, 1.0, 1e-12);
  EXPECT_NEAR(liquid(0, 0, -3) + at({0.1, 0.1, 2}).lambda, 1.0, 0.01);
  EXPECT_NEAR(liquid(0, 0, 0) + at({0.1, 0.1, 0.1}).lambda, 1.0, 0.015);
}

// The push is tabulated as central differences over two cells of the table; interpolation commutes with
// them, so differences of lambda over the same length (in d: shorter by the stretch) are equal to rounding.
// Distances keep both nodes beside sigma off the table's ends.
TEST_F(Walls, PushIsMinusTheSlopeOfLambda) {
  test_support::Random random(21);
  const double h = table_cell / stretch;
  double largest = 0;
  for (int n = 0; n < 2000; ++n) {
    Vec3<double> x{random.uniform(0.04, 0.2), random.uniform(0.04, 0.2), random.uniform(0.04, 0.2)};
    if (n % 3 == 1) x.y = 2;
    if (n % 5 == 1) x.z = 2;
    if (n & 1) x.x = 4 - x.x;
    const WallSums<double> s = at(x);
    const Vec3<double> force = wall_pressure_force(0.008, 1e4, s);
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Vec3<double> high = x, low = x;
      high.*axis += h;
      low.*axis -= h;
      const double slope = (at(high).lambda - at(low).lambda) / (2 * h);
      ASSERT_NEAR(s.push.*axis * stretch, -slope, 1e-10);
      ASSERT_NEAR(force.*axis, -0.008 * 1e4 * slope, 1e-8);
      largest = maximum(largest, std::fabs(slope));
    }
  }
  EXPECT_GT(largest, 1.0);  // something was compared
}

TEST_F(Walls, PushPointsInwards) {
  EXPECT_GT(at({0.1, 2, 2}).push.x, 0);
  EXPECT_LT(at({3.9, 2, 2}).push.x, 0);
  EXPECT_GT(at({2, 0.1, 2}).push.y, 0);
  EXPECT_LT(at({2, 2, 3.9}).push.z, 0);
}

TEST_F(Walls, OutOfReachAndMissingFacesAddNothing) {
  EXPECT_FALSE(at({2, 2, 2}).any);
  EXPECT_EQ(at({2, 2, 2}).lambda, 0.0);
  EXPECT_FALSE(at({0.1, 2, 2}, 62u).any);  // no wall at -x
  EXPECT_EQ(at({0.1, 2, 2}, 62u).lambda, 0.0);
  EXPECT_NEAR(at({2, 0.1, 2}, 4u).lambda, at({0.1, 2, 2}, 1u).lambda, 1e-12);
  EXPECT_NEAR(at({0.1, 3.9, 2}, 1u).lambda, at({0.1, 2, 2}).lambda, 1e-12);
}

// Beyond the wall the table ends at sigma = -dx/2: values stay finite and do not fall.
TEST_F(Walls, FiniteBehindTheWall) {
  for (const double d : {0.0, -0.05, -1.0}) {
    const WallSums<double> s = at({d, 2, 2});
    EXPECT_TRUE(std::isfinite(s.lambda) && finite(s.push));
    EXPECT_GE(s.lambda, at({0.1, 2, 2}).lambda);
  }
}

TEST_F(Walls, NoSlipTractionIsOfTheFluidsFormula) {
  const WallSums<double> s = at({0.1, 2, 2});
  const Vec3<double> f = wall_viscous_force(0.3, 0.008, s, Vec3<double>{0, 2, 0});
  EXPECT_DOUBLE_EQ(f.y, 0.3 * 0.008 * s.laplacian * 2);
  EXPECT_EQ(f.x, 0.0);
}

}  // namespace
