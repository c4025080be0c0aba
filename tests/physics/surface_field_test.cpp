// SPDX-License-Identifier: Apache-2.0
// The field of lattices whose surface is known, and ellipsoids against Eigen. dx = 1.
#include "meltsim/physics/surface_field.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

/// phi beside a half lattice whose last layer is z = 0, by the plain sum.
double half_space_phi(const SurfaceField<double>& f, Vec3<double> x) {
  double sum = 0;
  for (int k = -5; k <= 0; ++k)
    for (int j = -5; j <= 5; ++j)
      for (int i = -5; i <= 5; ++i) {
        const double r = length(x - Vec3<double>{double(i), double(j), double(k)});
        if (r < f.kernel.support) sum += kernel_value(f.kernel, r);
      }
  return sum;
}

// The level is the mean over the plane half a spacing above; between particles the surface dips. Slope of phi
// there: 0.66 per dx, so 0.008 of phi are 0.012 dx of height.
TEST(SurfaceField, LatticeEndsHalfASpacingBeyondItsLastLayer) {
  const auto f = make_surface_field<double>(1, false);
  EXPECT_NEAR(f.level, 0.5, 0.02);
  double mean = 0;
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b) {
      const double phi = half_space_phi(f, {(a + 0.5) / 8, (b + 0.5) / 8, 0.5});
      EXPECT_NEAR(phi, f.level, 0.008);
      mean += phi / 64;
    }
  EXPECT_NEAR(mean, f.level, 1e-3);  // 16 samples of it against 64
  EXPECT_LT(half_space_phi(f, {0.3, 0.2, 0.7}), f.level - 0.1);
  EXPECT_GT(half_space_phi(f, {0.3, 0.2, 0.3}), f.level + 0.1);
}

// A ball of the volume of a spacing, and nothing gained where a surface is plane.
TEST(SurfaceField, GainSuitsWhatStandsAlone) {
  for (const bool anisotropic : {false, true}) {
    const auto f = make_surface_field<double>(1, anisotropic);
    const double radius = std::cbrt(3 / (4 * 3.14159265358979323846));
    EXPECT_NEAR(surface_gain(f, f.self) * kernel_value(f.kernel, radius), f.level, 1e-12);
    const double plane = 1 - lattice_half_space(f.kernel.support, 1);
    EXPECT_EQ(surface_gain(f, plane), 1);
    EXPECT_EQ(surface_gain(f, 1.0), 1);
    EXPECT_LT(plane, f.full_sum);
    EXPECT_GT(1.0, f.full_sum);
    double last = surface_gain(f, f.self);
    for (double s = f.self; s < 1; s += 0.01) {
      EXPECT_LE(surface_gain(f, s), last);
      last = surface_gain(f, s);
    }
  }
}

Eigen::Matrix3d matrix(const Ellipsoid<double>& e) {
  Eigen::Matrix3d m;
  m << e.xx, e.xy, e.zx, e.xy, e.yy, e.yz, e.zx, e.yz, e.zz;
  return m;
}

ShapeSums<double> sums_of(const SphKernel<double>& k, const std::vector<Vec3<double>>& offsets) {
  ShapeSums<double> s;
  for (const auto& d : offsets) add_neighbour(s, k, d, dot(d, d));
  return s;
}

// Clouds squeezed along random directions; 1e-9 is what Jacobi's and Eigen's eigenvectors of a 3x3 agree to.
TEST(Ellipsoid, HasTheCovariancesAxes) {
  Random random(3);
  const auto f = make_surface_field<double>(1, true);
  int flat = 0;
  for (int n = 0; n < 200; ++n) {
    const auto rotation = random.rotation();
    const double squeeze[3] = {1, random.uniform(0.2, 1), random.uniform(0.05, 1)};
    std::vector<Vec3<double>> offsets;
    for (int k = 0; k < 60; ++k) {
      const auto d = random.vector(2);
      offsets.push_back(rotate(rotation, Vec3<double>{d.x * squeeze[0], d.y * squeeze[1], d.z * squeeze[2]}));
    }
    const Ellipsoid<double> e = make_ellipsoid(sums_of(f.kernel, offsets), f.full);
    ASSERT_EQ(e.trust, 1);
    Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double weight = 0;
    for (const auto& d : offsets) {
      const double q = length(d) / f.kernel.support;
      if (q >= 1) continue;
      const Eigen::Vector3d v(d.x, d.y, d.z);
      const double w = 1 - q * q * q;
      weight += w;
      mean += w * v;
      c += w * v * v.transpose();
    }
    mean /= weight;
    c = (c / weight - mean * mean.transpose()) / f.full.spread;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(c);
    const Eigen::Vector3d axes = solver.eigenvalues().cwiseMax(ellipsoid_least).cwiseMin(1.0);
    const Eigen::Matrix3d expected =
        solver.eigenvectors() * axes.cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
    EXPECT_LT((matrix(e) - expected).norm(), 1e-9);
    EXPECT_NEAR(e.det, expected.determinant(), 1e-9);
    const auto d = random.vector(1);
    EXPECT_NEAR(ellipsoid_distance2(e.xx, e.yy, e.zz, e.xy, e.yz, e.zx, d),
                (expected * Eigen::Vector3d(d.x, d.y, d.z)).squaredNorm(), 1e-9);
    flat += e.det > 1.3 ? 1 : 0;
  }
  EXPECT_GT(flat, 50);
}

// Inside a lattice a ball; at its surface flat along the normal; a few neighbours make no ellipsoid.
TEST(Ellipsoid, IsABallInsideAndWhereThereIsLittle) {
  const auto f = make_surface_field<double>(1, true);
  const auto inside = make_ellipsoid(half_lattice_shape(f.kernel.support, 1, 9), f.full);
  EXPECT_NEAR(inside.det, 1, 1e-12);
  const auto top = make_ellipsoid(half_lattice_shape(f.kernel.support, 1, 0), f.full);
  EXPECT_GT(top.zz, 1.4);
  EXPECT_NEAR(top.xx, 1, 1e-12);
  EXPECT_NEAR(top.yz, 0, 1e-12);
  const auto pair = make_ellipsoid(sums_of(f.kernel, {{0, 0, 0}, {1, 0, 0}}), f.full);
  EXPECT_EQ(pair.det, 1);
  EXPECT_EQ(pair.trust, 0);
  const auto coincident = make_ellipsoid(sums_of(f.kernel, std::vector<Vec3<double>>(40)), f.full);
  EXPECT_NEAR(coincident.det, std::pow(ellipsoid_least, -3), 1e-9);
}

// Every particle keeps its volume: the integral of det G W(|G d|), by cells of H/40.
TEST(Ellipsoid, KernelKeepsItsIntegral) {
  const auto f = make_surface_field<double>(1, true);
  const auto k = uncorrected_kernel<double>(f.kernel.support);
  const auto e = make_ellipsoid(half_lattice_shape(f.kernel.support, 1, 0), f.full);
  const double h = k.support / 40;
  double sum = 0;
  for (int z = -40; z < 40; ++z)
    for (int y = -40; y < 40; ++y)
      for (int x = -40; x < 40; ++x) {
        const Vec3<double> d{(x + 0.5) * h, (y + 0.5) * h, (z + 0.5) * h};
        const double r2 = ellipsoid_distance2(e.xx, e.yy, e.zz, e.xy, e.yz, e.zx, d);
        if (r2 < k.support2) sum += e.det * kernel_value(k, std::sqrt(r2));
      }
  EXPECT_NEAR(sum * h * h * h, 1, 1e-4);
}

TEST(Mesh, EdgeIsCrossedWhereALineIs) {
  EXPECT_DOUBLE_EQ(edge_crossing(1.0, -3.0), 0.25);
  EXPECT_DOUBLE_EQ(edge_crossing(0.5, 0.0), 1);
  // From either side the same place.
  EXPECT_NEAR(edge_crossing(0.3, -0.4) + edge_crossing(0.4, -0.3), 1, 1e-15);
}

// A wave of which the mean of a vertex's neighbours is (1 - k) of it is multiplied by (1 - in k)(1 - out k):
// bumps from vertex to vertex (k = 2) go, long waves stay to a thousandth.
TEST(Mesh, FilterTakesOutBumpsAndKeepsWaves) {
  const auto gain = [](double k) {
    const Vec3<double> x{1, 0, 0}, in = smoothed(x, x * (1 - k), smooth_in);
    return smoothed(in, in * (1 - k), smooth_out).x;
  };
  EXPECT_NEAR(gain(0), 1, 1e-15);
  EXPECT_NEAR(gain(0.05), 1, 1e-3);
  EXPECT_NEAR(gain(2), 0, 1e-15);
  for (double k = 0; k <= 2; k += 0.01) EXPECT_LE(std::fabs(gain(k)), 1.001);
}

}  // namespace
