// SPDX-License-Identifier: Apache-2.0
// Liquid beside a solid. dx = 0.2 m, H = 2.5 dx: the defaults.
#include "meltsim/physics/coupling.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double dx = 0.2, support = 0.5, cell = dx * dx * dx;

// Value and slope join at S*; at the knee, 1.2 S*, the value does and the slope falls to the paper's.
TEST(SolidShare, IsContinuous) {
  const auto c = make_coupling<double>(support, dx);
  const double s = c.face_sum, e = 1e-9 * s, knee = 1.2 * s;
  EXPECT_EQ(solid_share(c, 0.0), 0.0);
  EXPECT_EQ(solid_share_slope(c, 0.0), 0.0);
  for (const double at : {s, knee})
    EXPECT_NEAR(solid_share(c, at - e), solid_share(c, at + e), 1e-8 * c.face_share);
  EXPECT_NEAR(solid_share_slope(c, s - e), solid_share_slope(c, s + e), 1e-8 * solid_share_slope(c, s));
  EXPECT_DOUBLE_EQ(solid_share(c, s), c.face_share);
  EXPECT_NEAR(solid_share(c, 3 * s), 3.3 * c.face_share, 1e-12);  // 3 + 1.5 * 0.2
  EXPECT_NEAR(solid_share_slope(c, 3 * s), c.face_share / s, 1e-12);
}

// Central differences, step 1e-5 S*: 1e-9. No point of the scan is that near to the knee.
TEST(SolidShare, SlopeIsTheFiniteDifference) {
  const auto c = make_coupling<double>(support, dx);
  const double e = 1e-5 * c.face_sum;
  for (double x = 0.05; x < 3; x += 0.0371) {
    const double s = x * c.face_sum;
    const double slope = (solid_share(c, s + e) - solid_share(c, s - e)) / (2 * e);
    EXPECT_NEAR(solid_share_slope(c, s), slope, 1e-7 * slope) << x;
  }
}

/// A block of solid with a flat top at z = 0, wide and deep enough (4 cells beyond H) that its middle sees a
/// half-space. visit(point) in units of dx.
template <class Visit>
void for_block(int depth, int half_width, const Visit& visit) {
  for (int z = 0; z > -depth; --z)
    for (int y = -half_width; y <= half_width; ++y)
      for (int x = -half_width; x <= half_width; ++x) visit(x, y, z);
}

/// S* at (0, 0, dx) with every V_k summed particle by particle.
double brute_face_sum() {
  const auto k = make_kernel<double>(support, dx);
  double sum = 0;
  for_block(3, 3, [&](int x, int y, int z) {
    const double w = kernel_value(k, dx * std::sqrt(double(x * x + y * y + (z - 1) * (z - 1))));
    if (w == 0) return;
    double own = 0;
    for_block(8, 7, [&](int a, int b, int c) {
      own +=
          kernel_value(k, dx * std::sqrt(double((a - x) * (a - x) + (b - y) * (b - y) + (c - z) * (c - z))));
    });
    sum += w / own;
  });
  return sum;
}

TEST(MakeCoupling, EqualsTheSumOverABlock) {
  const auto c = make_coupling<double>(support, dx);
  EXPECT_NEAR(c.face_sum, brute_face_sum(), 1e-12);  // the same sum in another order
  EXPECT_NEAR(c.face_sum, 0.249, 5e-4);              // the header's number
  EXPECT_EQ(c.face_share, lattice_half_space(support, dx));
}

// Liquid above plus the solid's share: exactly what a lattice of liquid alone would read.
TEST(MakeCoupling, FirstLayerOnAFlatSolidReadsOne) {
  const auto c = make_coupling<double>(support, dx);
  const auto k = make_kernel<double>(support, dx);
  double phi = solid_share(c, brute_face_sum());
  for (int z = 0; z <= 3; ++z)
    for (int y = -3; y <= 3; ++y)
      for (int x = -3; x <= 3; ++x)
        phi += cell * kernel_value(k, dx * std::sqrt(double(x * x + y * y + z * z)));
  EXPECT_NEAR(phi, 1.0, 1e-12);
}

// dx^3 inside a lattice (the kernel is corrected on it); alone, 4.7 times that would be, twice it is.
TEST(SolidVolume, IsTheSpacingCubedInsideAndBounded) {
  const auto k = make_kernel<double>(support, dx);
  double sum = 0;
  for (int z = -3; z <= 3; ++z)
    for (int y = -3; y <= 3; ++y)
      for (int x = -3; x <= 3; ++x) sum += kernel_value(k, dx * std::sqrt(double(x * x + y * y + z * z)));
  EXPECT_NEAR(solid_volume(sum, cell), cell, 1e-12 * cell);
  EXPECT_DOUBLE_EQ(solid_volume(0.6 / cell, cell), cell / 0.6);
  EXPECT_DOUBLE_EQ(solid_volume(kernel_value(k, 0.0), cell), 2 * cell);
}

constexpr double stiffness = 1000.0 * 30 * 30 / 7;
double energy_density(double phi) {  // derivative P/phi^2
  const double p = maximum(phi, 1.0);
  return stiffness * (std::pow(p, 6) / 6 + 1 / p);
}

struct Mixed {
  SphKernel<double> kernel = make_kernel<double>(support, dx);
  CouplingShare<double> share = make_coupling<double>(support, dx);
  std::vector<Vec3<double>> liquid, solid;
  double liquid_volume = 1.3 * cell, solid_volume = 1.2 * cell;
  double solid_sum(std::size_t i) const {
    double s = 0;
    for (const auto& k : solid) s += solid_volume * kernel_value(kernel, length(liquid[i] - k));
    return s;
  }
  double phi(std::size_t i) const {
    double p = physics::solid_share(share, solid_sum(i));
    for (const auto& j : liquid) p += liquid_volume * kernel_value(kernel, length(liquid[i] - j));
    return p;
  }
  double energy() const {
    double e = 0;
    for (std::size_t i = 0; i < liquid.size(); ++i) e += liquid_volume * energy_density(phi(i));
    return e;
  }
};

// Moving a solid particle (its volume held) must cost what the forces on it say; both branches of s occur.
// Differences with 1e-6 m, see the liquid's test of the same kind: 1e-5 of the rms force.
TEST(CouplingForce, IsMinusTheGradientOfTheEnergy) {
  Random random(11);
  Mixed m;
  for (int i = 0; i < 40; ++i) m.liquid.push_back(random.vector(0.35) + Vec3<double>{0, 0.2, 0});
  for (int i = 0; i < 40; ++i) m.solid.push_back(random.vector(0.35) - Vec3<double>{0, 0.2, 0});
  int curved = 0, linear = 0;
  std::vector<Vec3<double>> force(m.solid.size());
  double square = 0;
  for (std::size_t i = 0; i < m.liquid.size(); ++i) {
    const double s = m.solid_sum(i), phi = m.phi(i);
    const double term = pressure_term(tait_pressure(stiffness, phi), phi);
    if (phi > 1 && s > 0) ++(s < m.share.face_sum ? curved : linear);
    for (std::size_t k = 0; k < m.solid.size(); ++k) {
      CouplingPair<double> p{};
      p.fluid_volume = m.liquid_volume;
      p.solid_volume = m.solid_volume;
      p.fluid_term = solid_share_slope(m.share, s) * term;
      p.x_ik = m.liquid[i] - m.solid[k];
      force[k] += -coupling_force(m.kernel, 0.0, 30.0, p, dot(p.x_ik, p.x_ik));
    }
  }
  ASSERT_GT(curved, 3);
  ASSERT_GT(linear, 3);
  for (const auto& f : force) square += dot(f, f);
  const double rms = std::sqrt(square / static_cast<double>(force.size())), e = 1e-6;
  for (std::size_t k = 0; k < m.solid.size(); k += 4)
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Mixed high = m, low = m;
      high.solid[k].*axis += e;
      low.solid[k].*axis -= e;
      EXPECT_NEAR(force[k].*axis, -(high.energy() - low.energy()) / (2 * e), 1e-5 * rms);
    }
}

// The liquid forms x_i - x_k, the solid -(x_k - x_i): subtraction rounds the same both ways.
TEST(CouplingForce, IsTheSameToTheBitFromBothSides) {
  Random random(12);
  const auto k = make_kernel<float>(support, dx);
  for (int n = 0; n < 10000; ++n) {
    const auto xi = cast<float>(random.vector(50)), vi = cast<float>(random.vector(3));
    const auto xk = xi + cast<float>(random.vector(0.25)), vk = cast<float>(random.vector(3));
    const auto term = static_cast<float>(random.uniform(0, 1e5));
    const CouplingPair<float> seen_by_liquid{0.008f, 0.01f, term, 0.2f, 1e3f, xi - xk, vi - vk};
    const CouplingPair<float> seen_by_solid{0.008f, 0.01f, term, 0.2f, 1e3f, -(xk - xi), vi - vk};
    const auto a = seen_by_liquid.x_ik, b = xk - xi;
    const Vec3<float> f = coupling_force(k, 0.05f, 30.0f, seen_by_liquid, dot(a, a));
    const Vec3<float> g = -coupling_force(k, 0.05f, 30.0f, seen_by_solid, dot(b, b));
    ASSERT_TRUE(f.x == -g.x && f.y == -g.y && f.z == -g.z);
  }
}

// Each part is the liquid's own formula with the other end at rest pressure.
TEST(CouplingForce, ViscousPartsAreTheLiquids) {
  const auto k = make_kernel<double>(support, dx);
  const Vec3<double> x{0.1, -0.15, 0.05}, v{-1, 2, 0.5};
  const double r2 = dot(x, x), r = std::sqrt(r2);
  const CouplingPair<double> p{0.008, 0.01, 0.0, 0.2, 900.0, x, v};
  const Vec3<double> expected = viscous_force(0.2, 0.008, 0.01, kernel_laplacian(k, r, r2), -v) +
                                artificial_viscous_force(k, 0.05, 30.0, 900.0, 0.008, 0.01,
                                                         kernel_gradient_factor(k, r), r2, dot(v, x), x);
  EXPECT_LE(length(coupling_force(k, 0.05, 30.0, p, r2) - expected), 1e-13 * length(expected));
  EXPECT_TRUE(finite(coupling_force(k, 0.05, 30.0, CouplingPair<double>{1, 1, 1, 1, 1, {}, v}, 0.0)));
}

// The spring of contact.hpp (0.15 m*/dt^2, 0.387 m*/dt) from 0.8 dx inwards, along the line of centres; the
// root of 0.15 is given with ten digits.
TEST(LeakForce, IsTheContactSpringWithoutFriction) {
  const double dt = 1e-3, m = 8.0 * 16 / 24;
  const Vec3<double> x{0.06, 0, 0.08}, v{-1, 3, 0};
  const double overlap = 0.16 - 0.1, vn = -0.6;
  const Vec3<double> f = leak_force(dx, dt, 8.0, 16.0, x, v, 0.01);
  const double expected = 0.15 * m / (dt * dt) * overlap - std::sqrt(0.15) * m / dt * vn;
  EXPECT_LE(length(f - x * (expected / 0.1)), 1e-8 * expected);
  EXPECT_EQ(length(leak_force(dx, dt, 8.0, 16.0, Vec3<double>{}, v, 0.0)), 0.0);
  EXPECT_EQ(length(leak_force(dx, dt, 8.0, 16.0, Vec3<double>{0.17, 0, 0}, Vec3<double>{}, 0.0289)), 0.0);
}

}  // namespace
