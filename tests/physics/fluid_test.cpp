// SPDX-License-Identifier: Apache-2.0
// Equation of state and pair forces of the liquid.
#include "meltsim/physics/fluid.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "meltsim/physics/artificial_viscosity.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double density = 1000, sound = 30, stiffness = density * sound * sound / 7;

template <class T>
bool negatives(Vec3<T> a, Vec3<T> b) {
  return a.x == -b.x && a.y == -b.y && a.z == -b.z;
}

TEST(Tait, ZeroAtRestAndBelow) {
  EXPECT_EQ(tait_pressure(stiffness, 1.0), 0.0);
  EXPECT_EQ(tait_pressure(static_cast<float>(stiffness), 1.0f), 0.0f);
  for (const double phi : {0.0, 0.3, 0.999999}) EXPECT_EQ(tait_pressure(stiffness, phi), 0.0);
}

// With tension (lowest phi 0) the curve goes on below rest density; its slope there is c^2 too, to 7 e/2 + 15
// e^2.
TEST(Tait, PullsOnlyWhenAsked) {
  const double e = 1e-4;
  EXPECT_EQ(tait_pressure(stiffness, 1 - e), 0.0);
  EXPECT_NEAR(tait_pressure(stiffness, 1 - e, 0.0) / (-density * sound * sound * e), 1.0, 4e-4);
  EXPECT_DOUBLE_EQ(tait_pressure(stiffness, 0.3, 0.5), tait_pressure(stiffness, 0.5, 0.0));
}

// phi^7 at 1.1 by the standard library; 1e-13: a dozen roundings.
TEST(Tait, SeventhPower) {
  EXPECT_NEAR(tait_pressure(stiffness, 1.1) / (stiffness * (std::pow(1.1, 7) - 1)), 1.0, 1e-13);
  EXPECT_DOUBLE_EQ(pressure_term(5.0, 2.0), 1.25);
}

// dP/drho = c^2 at rest. One-sided (it is clamped below): second order, step 1e-5, so 1e-8 and rounding.
TEST(Tait, SlopeIsTheSquaredSoundSpeed) {
  const double e = 1e-5;
  const double slope = (4 * tait_pressure(stiffness, 1 + e) - tait_pressure(stiffness, 1 + 2 * e)) / (2 * e);
  EXPECT_NEAR(slope / density / (sound * sound), 1.0, 1e-6);
}

TEST(PressureForce, Antisymmetric) {
  Random random(2);
  const auto k = make_kernel<float>(0.5, 0.2);
  for (int i = 0; i < 10000; ++i) {
    const auto x = cast<float>(random.vector(0.3));
    const auto vi = static_cast<float>(random.uniform(1e-3, 1e-2)), vj = 0.37f * vi + 1e-3f;
    const auto ti = static_cast<float>(random.uniform(0, 1e5)),
               tj = static_cast<float>(random.uniform(0, 1e5));
    const float f = kernel_gradient_factor(k, length(x));
    ASSERT_TRUE(negatives(pressure_force(vi, vj, ti, tj, f, x), pressure_force(vj, vi, tj, ti, f, -x)));
  }
}

/// Internal energy whose derivative is P/phi^2: B (phi^6/6 + 1/phi), constant where the pressure is clamped.
double energy_density(double phi) {
  const double p = maximum(phi, 1.0);
  return stiffness * (std::pow(p, 6) / 6 + 1 / p);
}

/// Forces are this many times minus the gradient of sum V e(phi): grad W has a lattice correction of its own.
/// The derivative of (1-q)^4 (1+4q) is -20 q (1-q)^3 / H.
double force_per_gradient(const SphKernel<double>& k) { return k.grad_scale * k.support2 / (20 * k.w_scale); }

struct Cloud {
  SphKernel<double> kernel = make_kernel<double>(0.5, 0.2);
  std::vector<Vec3<double>> x;
  std::vector<double> volume;
  double phi(std::size_t i) const {
    double sum = 0;
    for (std::size_t j = 0; j < x.size(); ++j) sum += volume[j] * kernel_value(kernel, length(x[i] - x[j]));
    return sum;
  }
  double energy() const {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += volume[i] * energy_density(phi(i));
    return sum;
  }
};

// 60 particles of unequal volumes in a cube of 1.5 H, compressed, so that nearly all have a pressure. Central
// differences with 1e-6 m: 1e-9 of truncation, 1e-15 E/1e-6 of rounding; 1e-5 of the rms force holds both.
TEST(PressureForce, IsMinusTheGradientOfTheEnergy) {
  Random random(3);
  Cloud c;
  for (int i = 0; i < 60; ++i) {
    c.x.push_back(random.vector(0.37));
    c.volume.push_back(random.uniform(0.006, 0.012));
  }
  std::vector<double> term;
  int pressed = 0;
  for (std::size_t i = 0; i < c.x.size(); ++i) {
    const double phi = c.phi(i);
    term.push_back(pressure_term(tait_pressure(stiffness, phi), phi));
    pressed += phi > 1 ? 1 : 0;
  }
  ASSERT_GT(pressed, 20);
  std::vector<Vec3<double>> force(c.x.size());
  double square = 0;
  for (std::size_t i = 0; i < c.x.size(); ++i) {
    for (std::size_t j = 0; j < c.x.size(); ++j) {
      const Vec3<double> d = c.x[i] - c.x[j];
      force[i] += pressure_force(c.volume[i], c.volume[j], term[i], term[j],
                                 kernel_gradient_factor(c.kernel, length(d)), d);
    }
    square += dot(force[i], force[i]);
  }
  const double rms = std::sqrt(square / static_cast<double>(c.x.size())), e = 1e-6;
  for (std::size_t i = 0; i < c.x.size(); i += 6) {
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Cloud high = c, low = c;
      high.x[i].*axis += e;
      low.x[i].*axis -= e;
      EXPECT_NEAR(force[i].*axis, -force_per_gradient(c.kernel) * (high.energy() - low.energy()) / (2 * e),
                  1e-5 * rms);
    }
  }
}

TEST(ViscousForce, AntisymmetricAndZeroForEqualVelocities) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const auto v = cast<float>(random.vector(3));
    const auto vi = static_cast<float>(random.uniform(1e-3, 1e-2)), vj = 2e-3f;
    const auto l = static_cast<float>(random.uniform(0, 1e4));
    ASSERT_TRUE(negatives(viscous_force(0.2f, vi, vj, l, v), viscous_force(0.2f, vj, vi, l, -v)));
  }
  EXPECT_EQ(length(viscous_force(0.2f, 1.0f, 1.0f, 5.0f, Vec3<float>{})), 0.0f);
}

// u = y^2 on the lattice: the force per volume is mu u'' = 2 mu, to rounding thanks to the correction.
TEST(ViscousForce, DeliversTheLaplacian) {
  const auto k = make_kernel<double>(0.5, 0.2);
  const double mu = 0.3, volume = 0.008;
  Vec3<double> force{};
  for (int z = -3; z <= 3; ++z)
    for (int y = -3; y <= 3; ++y)
      for (int x = -3; x <= 3; ++x) {
        const Vec3<double> d{0.2 * x, 0.2 * y, 0.2 * z};
        force += viscous_force(mu, volume, volume, kernel_laplacian(k, length(d), dot(d, d)),
                               Vec3<double>{d.y * d.y, 0, 0});
      }
  EXPECT_NEAR(force.x / volume, 2 * mu, 1e-11);
}

TEST(PairViscosity, HarmonicAndSymmetric) {
  EXPECT_DOUBLE_EQ(pair_viscosity(1.0, 3.0), 1.5);
  EXPECT_DOUBLE_EQ(pair_viscosity(0.2, 0.2), 0.2);
  EXPECT_EQ(pair_viscosity(0.0, 3.0), 0.0);
  EXPECT_EQ(pair_viscosity(0.0, 0.0), 0.0);
  Random random(5);
  for (int i = 0; i < 10000; ++i) {
    const auto a = static_cast<float>(random.uniform(0, 2)), b = static_cast<float>(random.uniform(0, 2));
    ASSERT_EQ(pair_viscosity(a, b), pair_viscosity(b, a));
    ASSERT_EQ(pair_viscosity(a, b, true), pair_viscosity(b, a, true));
  }
}

TEST(PairViscosity, OfTwoThatYieldTheGeometricMean) {
  EXPECT_DOUBLE_EQ(pair_viscosity(1.0, 4.0, true), 2);
  EXPECT_DOUBLE_EQ(pair_viscosity(30.0, 30.0, true), 30);
  EXPECT_EQ(pair_viscosity(0.0, 3.0, true), 0.0);
}

// Monaghan (1992), eq. 4.2 without the square, in masses: m_i m_j alpha c mu/rho grad W, mu = h v.x/(r^2 +
// 0.01 h^2). Central means parallel to x: the cross product is rounding.
TEST(ArtificialViscosity, MonaghansOnApproachOnly) {
  Random random(6);
  const auto k = make_kernel<double>(0.5, 0.2);
  const double alpha = 0.05, h = 0.25, vi = 0.008, vj = 0.011;
  int approaching = 0;
  for (int i = 0; i < 10000; ++i) {
    const Vec3<double> x = random.vector(0.25), v = random.vector(2);
    const double r2 = dot(x, x), f = kernel_gradient_factor(k, std::sqrt(r2)), vx = dot(v, x);
    const double pi = artificial_pressure(alpha, sound, density, approach_speed(k, r2, vx));
    const Vec3<double> on_i = pressure_force(vi, vj, pi, 0.0, f, x),
                       on_j = pressure_force(vj, vi, pi, 0.0, f, -x);
    ASSERT_TRUE(negatives(on_i, on_j));
    if (vx >= 0) {
      ASSERT_EQ(length(on_i), 0.0);
      continue;
    }
    ++approaching;
    const double mu = h * vx / (r2 + 0.01 * h * h);
    const Vec3<double> expected = x * (-(vi * density) * (vj * density) * alpha * sound * mu / density * f);
    ASSERT_LE(length(on_i - expected), 1e-12 * length(expected));
    ASSERT_LE(length(cross(on_i, x)), 1e-12 * length(on_i) * length(x));
    ASSERT_LT(dot(on_i, v), 0.0);  // takes energy out
  }
  EXPECT_GT(approaching, 4000);
}

// A pair that nothing presses and that hardly approaches is not held; pressed a little, it is held by as much; one that comes fast is
// held by all of it, pressed or not: mu = 1 m/s is above alpha c/beta = 0.05 30/4.
TEST(ArtificialViscosity, IsAtMostPressureAndWhatStopsAnImpact) {
  EXPECT_EQ(bounded_artificial_pressure(5.0, 3.0, density, 0.0), 3.0);
  EXPECT_EQ(bounded_artificial_pressure(5.0, -3.0, density, 0.0), 3.0);  // it pulls
  EXPECT_EQ(bounded_artificial_pressure(2.0, 3.0, density, 0.0), 2.0);
  EXPECT_EQ(bounded_artificial_pressure(5e9, 3.0, density, 0.5), 3.0 + artificial_impact * density * 0.25);
  const auto k = make_kernel<double>(0.5, 0.2);
  const Vec3<double> x{0.2, 0, 0};
  const auto along = [&](double term, double speed) {
    return liquid_factors(k, 0.05, sound,
                          LiquidPair<double>{0.008, 0.008, term, term, 0, density, x, {-speed, 0, 0}}, 0.04)
        .along;
  };
  const double f = kernel_gradient_factor(k, 0.2), slow = 1e-3, fast = 1;
  const auto all = [&](double speed) {
    return pressure_factor(0.008, 0.008, 0.0,
                           artificial_pressure(0.05, sound, density, approach_speed(k, 0.04, -0.2 * speed)),
                           f);
  };
  EXPECT_LT(along(0, slow), 0.01 * all(slow));
  EXPECT_NEAR(along(0.1, slow), pressure_factor(0.008, 0.008, 0.2, 0.2, f),
              0.05 * std::abs(along(0.1, slow)));
  EXPECT_DOUBLE_EQ(along(0, fast), all(fast));
}

/// Shear stress over rho and shear rate [m^2/s] of a lattice of spacing 1 that moves with v = u (w.x), u and w of length 1.
double viscosity_in_shear(double support, Vec3<double> u, Vec3<double> w) {
  const auto k = make_kernel<double>(support, 1);
  const int n = static_cast<int>(support);
  double stress = 0;
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const Vec3<double> x_ij{-1.0 * x, -1.0 * y, -1.0 * z};
        const double r2 = dot(x_ij, x_ij);
        if (r2 == 0 || r2 >= support * support) continue;
        const double pi =
            artificial_pressure(0.05, sound, density, approach_speed(k, r2, dot(u * dot(w, x_ij), x_ij)));
        const Vec3<double> force =
            pressure_force(1.0, 1.0, pi, 0.0, kernel_gradient_factor(k, std::sqrt(r2)), x_ij);
        stress += 0.5 * dot(force, u) * dot(x_ij, w);
      }
  return -stress / density;
}

// Against the sum of all pair forces. A lattice is no isotropic liquid: stress along its axes and along its diagonals differ by
// 30 % at 2.5 spacings and by 1 % at 6; their mean over all directions, 3 to 2 in a cubic crystal, is within 1 % at both.
TEST(ArtificialViscosity, ActsLikeAKinematicViscosity) {
  const double h = std::sqrt(0.5);
  for (const double support : {2.5, 4.0, 6.0}) {
    const double wanted = artificial_kinematic_viscosity(0.05, sound, support);
    const double axes = viscosity_in_shear(support, {1, 0, 0}, {0, 1, 0}),
                 diagonals = viscosity_in_shear(support, {h, h, 0}, {h, -h, 0});
    EXPECT_NEAR((3 * axes + 2 * diagonals) / 5 / wanted, 1, 0.02) << support;
  }
  EXPECT_NEAR(viscosity_in_shear(6, {1, 0, 0}, {0, 1, 0}) / artificial_kinematic_viscosity(0.05, sound, 6), 1,
              0.02);
}

TEST(Forces, CoincidentPairsAreFiniteAndZero) {
  const auto k = make_kernel<float>(0.5, 0.2);
  const float f = kernel_gradient_factor(k, 0.0f);
  const Vec3<float> zero{}, v{1, 2, 3};
  EXPECT_EQ(length(pressure_force(1.0f, 1.0f, 1e5f, 1e5f, f, zero)), 0.0f);
  EXPECT_EQ(artificial_pressure(0.05f, 30.0f, 1e3f, approach_speed(k, 0.0f, 0.0f)), 0.0f);
  EXPECT_EQ(length(viscous_force(0.2f, 1.0f, 1.0f, kernel_laplacian(k, 0.0f, 0.0f), v)), 0.0f);
}

}  // namespace
