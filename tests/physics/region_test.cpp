// SPDX-License-Identifier: Apache-2.0
// One region of shape matching: rigid motion is a fixed point, deformation does not move the centre.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <limits>
#include <vector>

#include "meltsim/physics/shape_matching.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double dx = 0.2;

/// Members of a region as the library sees them: positions rounded where they are, then differences.
template <class T>
struct Region {
  std::vector<Vec3<double>> rest;
  std::vector<Vec3<T>> u, q, v;
  std::vector<T> mass;
  RegionSums<T> sums;

  /// `shape`: lattice points; vertex = the first. Placed at R q + offset, moving with velocity + spin x.
  Region(const std::vector<Vec3<double>>& shape, const Quat<double>& rotation, Vec3<double> offset,
         Vec3<double> velocity, Vec3<double> spin, double mass_of_one = 8)
      : rest(shape) {
    const Mat3<double> r = to_matrix(rotation);
    const auto place = [&](std::size_t i) { return cast<T>(r * (shape[i] - shape[0]) + offset); };
    const auto speed = [&](std::size_t i) {
      return cast<T>(velocity + cross(spin, r * (shape[i] - shape[0])));
    };
    for (std::size_t i = 0; i < shape.size(); ++i) {
      u.push_back(place(i) - place(0));
      v.push_back(speed(i) - speed(0));
      q.push_back(cast<T>(shape[i] - shape[0]));
      mass.push_back(static_cast<T>(mass_of_one / (1.0 + static_cast<double>(i % 3))));  // unequal |R|
      add_member(sums, mass[i], u[i], q[i], v[i]);
    }
  }
};

std::vector<Vec3<double>> box(int nx, int ny, int nz, double spacing = dx) {
  std::vector<Vec3<double>> p;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) p.push_back({x * spacing, y * spacing, z * spacing});
  return p;
}

template <class T>
class RegionFitTest : public testing::Test {
 protected:
  static constexpr bool is_double = sizeof(T) == 8;
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(RegionFitTest, Scalars);

// max(1e-5 dx, 4 ulp(x)) in single precision, 1e-11 dx in double: what rounding of positions at 100 m leaves.
TYPED_TEST(RegionFitTest, RigidMotionIsAFixedPoint) {
  using T = TypeParam;
  Random random(51);
  for (int n = 0; n < 60; ++n) {
    const double offset = n % 3 == 0 ? 0 : n % 3 == 1 ? 10 : 100;
    const double ulp = offset * 2 * static_cast<double>(std::numeric_limits<T>::epsilon());
    const double tolerance = this->is_double ? 1e-11 * dx : std::max(1e-5 * dx, 4 * ulp);
    Quat<double> q = random.rotation();
    if (n % 4 == 1) q = {0, 1, 0, 0};  // half turns
    if (n % 4 == 2) q = {0, 0, 0.6, 0.8};
    const auto shape = n % 5 == 0 ? box(1, 1, 5) : n % 5 == 1 ? box(3, 1, 3) : box(5, 4, 3);
    const Region<T> r(shape, q, random.vector(offset), {}, {});
    const RegionFit<T> f = fit_region(r.sums, Quat<T>{});
    for (std::size_t i = 0; i < shape.size(); ++i)
      ASSERT_LE(static_cast<double>(length(goal_displacement(f, r.q[i], r.u[i]))), tolerance)
          << n << ", offset " << offset;
  }
}

// 1e-4 and 1e-11 of the speed: spin and velocity come from differences of rounded positions.
TYPED_TEST(RegionFitTest, RigidVelocityHasNoDefect) {
  using T = TypeParam;
  Random random(52);
  for (int n = 0; n < 40; ++n) {
    const Vec3<double> velocity = random.vector(3), spin = random.vector(5);
    const auto shape = n % 4 == 0 ? box(1, 1, 5) : n % 4 == 1 ? box(3, 1, 3) : box(4, 4, 3);
    const Region<T> r(shape, random.rotation(), {}, velocity, spin);
    const RegionFit<T> f = fit_region(r.sums, Quat<T>{});
    const double tolerance = this->is_double ? 1e-11 : 1e-4;
    for (std::size_t i = 0; i < shape.size(); ++i)
      ASSERT_LE(static_cast<double>(length(rigid_velocity_defect(f, r.u[i], r.v[i]))), tolerance) << n;
    const bool solid = n % 4 > 1;  // a bar cannot show its twist
    ASSERT_TRUE(!solid || length(cast<double>(f.spin) - spin) <= tolerance * 5) << n;
  }
}

// A lattice of dx = 1e-4 and 1e-7 m with the masses of density 1000: nothing may be lost in small numbers.
TYPED_TEST(RegionFitTest, SmallScales) {
  using T = TypeParam;
  Random random(53);
  for (const double scale : {1e-4, 1e-7}) {
    const Vec3<double> spin = random.vector(5);
    const Quat<double> q = random.rotation();
    const auto shape = box(3, 4, 3, scale);
    const Region<T> r(shape, q, {}, {}, spin, 1000 * scale * scale * scale);
    const RegionFit<T> f = fit_region(r.sums, Quat<T>{});
    const double tolerance = this->is_double ? 1e-10 : 1e-4;
    for (std::size_t i = 0; i < shape.size(); ++i)
      EXPECT_LE(static_cast<double>(length(goal_displacement(f, r.q[i], r.u[i]))), tolerance * scale);
    EXPECT_LE(length(cast<double>(f.spin) - spin), tolerance * 10) << scale;
  }
}

// Weighted displacements and defects of one region sum to zero, and defects carry no angular momentum: shape
// matching may not push. Random deformation of half a spacing; rounding only (1e-5, 1e-12 of the parts).
TYPED_TEST(RegionFitTest, DeformationKeepsMomentum) {
  using T = TypeParam;
  Random random(54);
  for (int n = 0; n < 40; ++n) {
    const auto shape = box(3, 3, 3);
    Region<T> r(shape, random.rotation(), {}, {}, {});
    r.sums = {};
    for (std::size_t i = 0; i < shape.size(); ++i) {
      r.u[i] += cast<T>(random.vector(0.5 * dx));
      r.v[i] = cast<T>(random.vector(2));
      add_member(r.sums, r.mass[i], r.u[i], r.q[i], r.v[i]);
    }
    const RegionFit<T> f = fit_region(r.sums, Quat<T>{});
    Vec3<double> moved{}, pushed{}, turned{};
    double parts = 0, push_parts = 0;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const double m = static_cast<double>(r.mass[i]);
      const Vec3<double> g = cast<double>(goal_displacement(f, r.q[i], r.u[i]));
      const Vec3<double> d = cast<double>(rigid_velocity_defect(f, r.u[i], r.v[i]));
      moved += g * m;
      pushed += d * m;
      turned += cross(cast<double>(r.u[i]), d) * m;
      parts += length(g) * m;
      push_parts += length(d) * m;
    }
    const double tolerance = this->is_double ? 1e-12 : 1e-5;
    ASSERT_LE(length(moved), tolerance * parts);
    ASSERT_LE(length(pushed), tolerance * push_parts);
    ASSERT_LE(length(turned), tolerance * push_parts);  // arms are below a metre
  }
}

TYPED_TEST(RegionFitTest, SingleMember) {
  using T = TypeParam;
  const Region<T> r(box(1, 1, 1), {}, {5, 5, 5}, {1, 2, 3}, {});
  const Quat<T> previous{T(0.6), T(0.8), T(0), T(0)};
  const RegionFit<T> f = fit_region(r.sums, previous);
  EXPECT_EQ(f.rotation.x, T(0.8));
  EXPECT_EQ(length(goal_displacement(f, r.q[0], r.u[0])), T(0));
  EXPECT_EQ(length(rigid_velocity_defect(f, r.u[0], r.v[0])), T(0));
}

// Random changes of velocity: after the correction neither momentum nor spin is left; also of a rod, whose
// own axis has no inertia, and of one particle. 1e-11: double sums with arms of a metre.
TEST(ResidualCorrection, LeavesNoMomentumAndNoSpin) {
  Random random(55);
  for (int n = 0; n < 40; ++n) {
    const auto shape = n % 4 == 0 ? box(1, 1, 6) : n % 4 == 1 ? box(1, 1, 1) : box(4, 3, 3);
    const Vec3<double> away = random.vector(1);
    std::vector<Vec3<double>> dv;
    std::vector<double> mass;
    RigidResidual r;
    for (const auto& p : shape) {
      const Vec3<double> u = p + away;
      const double m = random.uniform(1, 9);
      mass.push_back(m);
      dv.push_back(random.vector(1));
      r.mass += m;
      r.momentum += dv.back() * m;
      r.spin += cross(u, dv.back()) * m;
      r.first += u * m;
      add_outer(r.second, m, u, u);
    }
    Vec3<double> momentum{}, spin{};
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const Vec3<double> u = shape[i] + away, left = dv[i] + residual_correction(r, u);
      momentum += left * mass[i];
      spin += cross(u, left) * mass[i];
    }
    EXPECT_LE(length(momentum), 1e-11 * r.mass) << n;
    EXPECT_LE(length(spin), 1e-11 * r.mass) << n;
  }
  EXPECT_EQ(length(residual_correction(RigidResidual{}, Vec3<double>{1, 2, 3})), 0.0);
}

// A chain of means of means, applied to a long wave: B B u - u = -(w(w+1)/3) k^2 u up to (w k)^2. Written as
// the filters are, sums over sites.
TEST(Modulus, WaveSpeedEqualsTwoBoxFilters) {
  for (int w = 1; w <= 8; ++w) {
    const double k = 1e-3;  // 2 pi/k = 6283 sites: (w k)^2 < 1e-4
    double once = 0;
    for (int s = -w; s <= w; ++s) once += std::cos(k * s) / (2 * w + 1);
    EXPECT_NEAR((1 - once * once) / (k * k) / region_wave_speed2(w), 1, 1e-4) << w;
  }
}

/// The first eigenvalue above 0 of I - G, by a library: G of bar_wave_speed2.
double first_mode(int w, int n) {
  const auto regions = [&](int k) { return std::min(k + w, n - 1) - std::max(k - w, 0) + 1; };
  Eigen::MatrixXd goals = Eigen::MatrixXd::Zero(n, n);
  for (int r = 0; r < n; ++r) {
    Eigen::VectorXd share = Eigen::VectorXd::Zero(n);
    for (int k = std::max(r - w, 0); k <= std::min(r + w, n - 1); ++k) share[k] = 1.0 / regions(k);
    goals += share * share.transpose() / share.sum();
  }
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(n, n) - goals;
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(rest).eigenvalues()[1];
}

// Against eigenvalues of the whole matrix: 1e-4 is what twelve rounds of the power method leave. Where each region holds all of the
// bar exactly n^2/pi^2; a long bar has the speed of an endless one.
TEST(Modulus, ShortBarsHaveTheSpeedOfTheirFirstMode) {
  constexpr double pi = 3.14159265358979323846;
  for (int w = 1; w <= most_half_width; ++w) {
    for (const int n : {2, 3, 4, 6, 9, 16, 30, most_short_sites})
      EXPECT_NEAR(bar_wave_speed2(w, n) / (n * n * first_mode(w, n) / (pi * pi)), 1, 1e-4) << w << " " << n;
    EXPECT_NEAR(bar_wave_speed2(w, w + 1), (w + 1) * (w + 1) / (pi * pi), 1e-9);
    EXPECT_NEAR(bar_wave_speed2(w, most_short_sites) / region_wave_speed2(w), 1, 0.021);
    EXPECT_EQ(bar_wave_speed2(w, most_short_sites + 1), region_wave_speed2(w));
    EXPECT_EQ(bar_wave_speed2(w, 1), region_wave_speed2(w));  // has no modes
  }
}

// alpha that was chosen for E delivers E, at any step and width; a step twice as long needs four times alpha.
TEST(Modulus, StiffnessDeliversIt) {
  const double density = 917, spacing = 0.05, E = 3e7, rate = E / (density * spacing * spacing);
  for (int w = 1; w <= 8; ++w)
    for (const double dt : {1e-5, 1e-4, 3e-3}) {
      const double speed2 = region_wave_speed2(w), alpha = modulus_stiffness(rate, speed2, dt);
      EXPECT_NEAR(shape_modulus(alpha, speed2, density, spacing, dt) / E, 1, 1e-12);
      EXPECT_NEAR(modulus_stiffness(rate, speed2, 2 * dt) / alpha, 4, 1e-12);
    }
}

// The smallest width that reaches it, never below the material's own, never above the largest.
TEST(Modulus, HalfWidthIsTheSmallestThatReaches) {
  for (const double dt : {1e-4, 1e-3, 2e-3, 4e-3}) {
    const double rate = 1.44e6;  // w(w+1)/3 >= 1.44 at 1 ms
    const int w = modulus_half_width(rate, 1, 8, dt, region_wave_speed2);
    EXPECT_LE(modulus_stiffness(rate, region_wave_speed2(w), dt), 1.0);
    if (w > 1) {
      EXPECT_GT(modulus_stiffness(rate, region_wave_speed2(w - 1), dt), 1.0);
    }
  }
  EXPECT_EQ(modulus_half_width(1.44e6, 1, 8, 1e-3, region_wave_speed2), 2);
  EXPECT_EQ(modulus_half_width(1.44e6, 5, 8, 1e-3, region_wave_speed2), 5);
  EXPECT_EQ(modulus_half_width(1.44e6, 1, 8, 1, region_wave_speed2), 8);
}

// shape_modulus of the two is the same.
TEST(ShapeVelocity, AStiffnessOfAShorterStepKeepsTheModulus) {
  EXPECT_EQ(stiffness_of_step(0.7, 1e-3, 1e-3), 0.7);
  for (const double dt : {1e-3, 2.5e-4, 1e-9})
    EXPECT_NEAR(shape_modulus(stiffness_of_step(0.7, dt, 1e-3), 2.0, 900, 0.1, dt) /
                    shape_modulus(0.7, 2.0, 900, 0.1, 1e-3),
                1, 1e-12);
}

TEST(ShapeVelocity, StiffnessOverStepAndDamping) {
  const Vec3<double> v = shape_velocity(0.5, 0.1, 0.01, Vec3<double>{0.02, 0, 0}, Vec3<double>{0, 3, 0});
  EXPECT_DOUBLE_EQ(v.x, 1.0);
  EXPECT_DOUBLE_EQ(v.y, 0.3);
}

}  // namespace
