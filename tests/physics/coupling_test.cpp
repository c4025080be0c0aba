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

TEST(SolidTerm, IsPressureOverPhiSquaredPerStiffness) {
  for (const double phi : {0.3, 0.8, 1.0}) EXPECT_EQ(solid_term(phi), 0.0);
  EXPECT_NEAR(5e4 * solid_term(1.02), pressure_term(tait_pressure(5e4, 1.02), 1.02), 1e-9);
}

constexpr double stiffness = 1000.0 * 30 * 30 / 7;
double energy_density(double phi) {  // derivative P/phi^2
  const double p = maximum(phi, 1.0);
  return stiffness * (std::pow(p, 6) / 6 + 1 / p);
}

struct Mixed {
  SphKernel<double> kernel = make_kernel<double>(support, dx);
  std::vector<Vec3<double>> liquid, solid;
  double liquid_volume = 1.3 * cell, solid_volume = 1.2 * cell;
  double phi(const Vec3<double>& x) const {
    double p = 0;
    for (const auto& j : liquid) p += liquid_volume * kernel_value(kernel, length(x - j));
    for (const auto& k : solid) p += solid_volume * kernel_value(kernel, length(x - k));
    return p;
  }
  double energy() const {
    double e = 0;
    for (const auto& i : liquid) e += liquid_volume * energy_density(phi(i));
    for (const auto& k : solid) e += solid_volume * energy_density(phi(k));
    return e;
  }
};

// Moving a liquid particle must cost what the forces on it say: phi of liquid and of solid change with it.
// Differences with 1e-6 m, see the liquid's test of the same kind: 1e-5 of the rms force. The factor is the
// ratio of the lattice corrections of grad W and W.
TEST(CouplingForce, IsMinusTheGradientOfTheEnergy) {
  Random random(11);
  Mixed m;
  for (int i = 0; i < 40; ++i) m.liquid.push_back(random.vector(0.35) + Vec3<double>{0, 0.2, 0});
  for (int i = 0; i < 40; ++i) m.solid.push_back(random.vector(0.35) - Vec3<double>{0, 0.2, 0});
  const double ratio = m.kernel.grad_scale * m.kernel.support2 / (20 * m.kernel.w_scale);
  const auto term = [&](const Vec3<double>& x) {
    return pressure_term(tait_pressure(stiffness, m.phi(x)), m.phi(x));
  };
  int pressed = 0;
  for (const auto& k : m.solid) pressed += solid_term(m.phi(k)) > 0 ? 1 : 0;
  ASSERT_GT(pressed, 5);
  std::vector<Vec3<double>> force(m.liquid.size());
  double square = 0;
  for (std::size_t i = 0; i < m.liquid.size(); ++i) {
    for (const auto& j : m.liquid) {
      const auto d = m.liquid[i] - j;
      force[i] += pressure_force(m.liquid_volume, m.liquid_volume, term(m.liquid[i]), term(j),
                                 kernel_gradient_factor(m.kernel, length(d)), d);
    }
    for (const auto& k : m.solid) {
      CouplingPair<double> p{};
      p.fluid_volume = m.liquid_volume;
      p.solid_volume = m.solid_volume;
      p.terms = term(m.liquid[i]) + stiffness * solid_term(m.phi(k));
      p.x_ik = m.liquid[i] - k;
      force[i] += coupling_force(m.kernel, p, dot(p.x_ik, p.x_ik));
    }
    square += dot(force[i], force[i]);
  }
  const double rms = std::sqrt(square / static_cast<double>(force.size())), e = 1e-6;
  for (std::size_t i = 0; i < m.liquid.size(); i += 4)
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Mixed high = m, low = m;
      high.liquid[i].*axis += e;
      low.liquid[i].*axis -= e;
      EXPECT_NEAR(force[i].*axis, -ratio * (high.energy() - low.energy()) / (2 * e), 1e-5 * rms);
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
    const CouplingPair<float> seen_by_liquid{0.008f, 0.01f, term, 0.2f, xi - xk, vi - vk};
    const CouplingPair<float> seen_by_solid{0.008f, 0.01f, term, 0.2f, -(xk - xi), vi - vk};
    const auto a = seen_by_liquid.x_ik, b = xk - xi;
    const Vec3<float> f = coupling_force(k, seen_by_liquid, dot(a, a));
    const Vec3<float> g = -coupling_force(k, seen_by_solid, dot(b, b));
    ASSERT_TRUE(f.x == -g.x && f.y == -g.y && f.z == -g.z);
  }
}

// The liquid's own formula with the other end at rest pressure, and twice the viscosity: the harmonic mean with a
// liquid of infinite viscosity, to rounding that of one 1e16 times as viscous. Nothing else: the pair approaches, and
// artificial viscosity would push.
TEST(CouplingForce, ViscousPartIsTheLiquids) {
  const auto k = make_kernel<double>(support, dx);
  const Vec3<double> x{0.1, -0.15, 0.05}, v{-1, 2, 0.5};
  const double r2 = dot(x, x), r = std::sqrt(r2);
  const CouplingPair<double> p{0.008, 0.01, 0.0, 0.2, x, v};
  ASSERT_GT(artificial_pressure(0.05, 30.0, 900.0, approach_speed(k, r2, dot(v, x))), 0.0);
  const Vec3<double> expected =
      viscous_force(pair_viscosity(0.2, 0.2e16), 0.008, 0.01, kernel_laplacian(k, r, r2), -v);
  EXPECT_LE(length(coupling_force(k, p, r2) - expected), 1e-13 * length(expected));
  EXPECT_TRUE(finite(coupling_force(k, CouplingPair<double>{1, 1, 1, 1, {}, v}, 0.0)));
}

// The spring of contact.hpp (0.15 m*/dt^2, 0.387 m*/dt) from 0.9 dx inwards, along the line of centres; the
// root of 0.15 is given with ten digits.
TEST(LeakForce, IsTheContactSpringWithoutFriction) {
  const double dt = 1e-3, m = 8.0 * 16 / 24;
  const Vec3<double> x{0.06, 0, 0.08}, v{-1, 3, 0};
  const double overlap = 0.18 - 0.1, vn = -0.6;
  const Vec3<double> f = leak_force(dx, dt, 8.0, 16.0, x, v, 0.01);
  const double expected = 0.15 * m / (dt * dt) * overlap - std::sqrt(0.15) * m / dt * vn;
  EXPECT_LE(length(f - x * (expected / 0.1)), 1e-8 * expected);
  EXPECT_EQ(length(leak_force(dx, dt, 8.0, 16.0, Vec3<double>{}, v, 0.0)), 0.0);
  EXPECT_EQ(length(leak_force(dx, dt, 8.0, 16.0, Vec3<double>{0.19, 0, 0}, Vec3<double>{}, 0.0361)), 0.0);
}

// Above a lattice that fills a half space: the cover of the first layer at rest, and its rate as a difference quotient. What
// slides along it by any distance keeps its cover; what comes as fast as a hundredth of sound is held in full, and what is in.
TEST(LeakShare, IsForWhatComesNearerOrIsIn) {
  const auto k = make_kernel<double>(support, dx);
  const auto cover_at = [&](Vec3<double> x, Vec3<double> v) {
    SolidCover<double> cover;
    for (int a = -4; a <= 4; ++a)
      for (int b = -3; b <= 0; ++b)
        for (int c = -4; c <= 4; ++c) {
          const Vec3<double> d = x - Vec3<double>{a * dx, b * dx, c * dx};
          if (dot(d, d) < support * support) cover.add(k, dx * dx * dx, d, v, dot(d, d));
        }
    return cover;
  };
  const Vec3<double> at{0.03, 0.75 * dx, -0.05}, v{1.5, -0.2, 0.7};
  const double h = 1e-6;
  const double rate = (cover_at(at + v * h, v).fraction - cover_at(at - v * h, v).fraction) / (2 * h);
  // W and grad W are made exact on the lattice each by a factor of its own.
  const double factors =
      kernel_gradient_factor(k, dx) * dx * 2 * h / (kernel_value(k, dx - h) - kernel_value(k, dx + h));
  EXPECT_NEAR(cover_at(at, v).rate, rate * factors, 1e-6 * std::fabs(rate));  // the quotients' error, h^2
  const double rest = cover_at({0, dx, 0}, {}).fraction;
  EXPECT_NEAR(cover_at({0.5 * dx, dx, 0.5 * dx}, {}).fraction, rest,
              0.01 * rest);  // over steps of one spacing
  const double c = 40;
  EXPECT_EQ(leak_share(cover_at(at, {4, 0, 0}), dx, c), 0.0);
  EXPECT_EQ(leak_share(cover_at(at, {4, 0.1, 0}), dx, c), 0.0);
  EXPECT_EQ(leak_share(cover_at(at, {0, -0.02 * c, 0}), dx, c), 1.0);
  EXPECT_EQ(leak_share(cover_at({0, 0.5 * dx, 0}, {}), dx, c), 1.0);  // halfway through
}

}  // namespace
