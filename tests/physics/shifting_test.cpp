// SPDX-License-Identifier: Apache-2.0
// Particle shifting: what a pair adds, lattices, the surface, the limit.
#include "meltsim/physics/shifting.hpp"

#include <gtest/gtest.h>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double dx = 0.2, support = 0.5, cell = dx * dx * dx;
const SphKernel<double> kernel = make_kernel<double>(support, dx);
const double inv_w_dx = 1 / kernel_value(kernel, dx);

/// G at the origin of the lattice with these spacings.
Vec3<double> lattice_g(Vec3<double> spacings, Vec3<double> moved = {}) {
  Vec3<double> g;
  for (int x = -6; x <= 6; ++x)
    for (int y = -6; y <= 6; ++y)
      for (int z = -6; z <= 6; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3<double> d = moved - Vec3<double>{x * spacings.x, y * spacings.y, z * spacings.z};
        if (length(d) < support) g += shift_term(kernel, inv_w_dx, cell, length(d), d);
      }
  return g;
}

// Against V (1 + R (W/W(dx))^4) times minus the slope of the published kernel, written out; the gradient's
// own lattice gain (0.979 at 2.5 dx) is the kernel's and tested there. 1e-12: a power and a dozen roundings.
TEST(Shifting, TermIsTheKernelsSlopeTimesTheRepulsion) {
  Random random(5);
  const double pi = 3.14159265358979323846, gain = lattice_gradient_gain(support, dx);
  const auto bump = [](double r) { return std::pow(1 - r / support, 4) * (1 + 4 * r / support); };
  for (int k = 0; k < 100; ++k) {
    const Vec3<double> d = random.vector(0.28);
    const double r = length(d);
    const double slope = 210 / (pi * std::pow(support, 5)) * std::pow(1 - r / support, 3) / gain;
    const double repulsion = 1 + 2 * std::pow(bump(r) / bump(dx), 4);
    const Vec3<double> g = shift_term(kernel, inv_w_dx, 0.7 * cell, r, d),
                       e = d * (0.7 * cell * slope * repulsion);
    EXPECT_NEAR(length(g - e), 0, 1e-12 * length(e));
  }
}

// Every lattice is in balance, strained ones too. A particle beside its site is sent back, harder where the
// lattice is squeezed: that is what breaks strings. 1e-12: sums of hundreds of terms of order 1/dx.
TEST(Shifting, LatticesAreInBalance) {
  EXPECT_LT(length(lattice_g({dx, dx, dx})), 1e-12 / dx);
  EXPECT_LT(length(lattice_g({0.7 * dx, dx / 0.7, dx})), 1e-12 / dx);
  const double home = lattice_g({dx, dx, dx}, {0.1 * dx, 0, 0}).x;
  const double squeezed = lattice_g({0.7 * dx, dx / 0.7, dx}, {0.07 * dx, 0, 0}).x;
  EXPECT_LT(home, 0);
  EXPECT_LT(squeezed, home);
}

TEST(Shifting, OffAtTheSurfaceAndLimited) {
  EXPECT_EQ(shift_share(0.80), 0);  // outermost layer of a lattice
  EXPECT_NEAR(shift_share(0.95), 0.5, 1e-12);
  EXPECT_EQ(shift_share(1.0), 1);
  EXPECT_EQ(shift_share(1.3), 1);
  const Vec3<double> g{0.01, 0.02, -0.02};
  const Vec3<double> small = shift_displacement(kernel, dx, 30.0, 1e-3, 1.0, g);
  EXPECT_NEAR(length(small - g * (0.1 * 30 * 1e-3 * support)), 0, 1e-15);
  const Vec3<double> large = shift_displacement(kernel, dx, 30.0, 1e-3, 1.0, g * 1e6);
  EXPECT_NEAR(length(large), 0.05 * dx, 1e-12);
  EXPECT_NEAR(dot(large, g) / (length(large) * length(g)), 1, 1e-12);
}

}  // namespace
