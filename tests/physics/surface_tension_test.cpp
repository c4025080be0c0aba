// SPDX-License-Identifier: Apache-2.0
// Surface tension: what a plane layer of particles carries, constants against integrals made here, angles whose cosine is known.
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

TEST(SurfaceTension, StrengthFollowsTheIntegralAndTheInsideIsFree) {
  for (const double support : {1.0, 2.5e-3}) {
    const double s = cohesion_strength(0.072, support);
    EXPECT_NEAR(pi / 8 * s * std::pow(support, 6) * moment(5) / (cohesion_share * 0.072), 1, 1e-8);
  }
  EXPECT_NEAR(moment(4), 0, 1e-9);  // the virial; its parts are 0.01
}

TEST(SurfaceTension, PairsRepelWithinAndAttractBeyond) {
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  const double turn = 2.5 * (1 - std::cbrt(1 / cohesion_core));
  EXPECT_GT(cohesion_shape(k, 0.99 * turn), 0);
  EXPECT_LT(cohesion_shape(k, 1.01 * turn), 0);
  EXPECT_EQ(cohesion_shape(k, 2.5), 0);
  EXPECT_EQ(cohesion_of(0.3, 0.7), cohesion_of(0.7, 0.3));
}

/// S of the particle `layer` spacings below the surface of a half space on a lattice, or above the solid of a half space of liquid.
SurfaceSums<double> sums_at(int layer, bool solid, double cosine) {
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  SurfaceSums<double> sums;
  for (int x = -3; x <= 3; ++x)
    for (int y = -3; y <= 3; ++y)
      for (int z = -3; z <= 3; ++z) {
        const Vec3<double> d{-double(x), -double(y), -double(z)};  // x_i - x_j
        const double r = length(d);
        if (r >= 2.5) continue;
        const double shape = kernel_gradient_shape(k, r);
        if (y + layer >= 0) sums.add(1, 1, shape, d);
        else if (solid) sums.add_solid(1, cosine, shape, d * shape, d * shape);
      }
  return sums;
}

// The tension that a plane surface carries: pairs across a plane through it, which is the sum over layers of S_xx, because the gradient
// of a linear field is exact on the lattice. Layers half a spacing thick would give tension_gain; e leaves out 0.04 of it.
TEST(SurfaceTension, PlaneLayersCarryTheTension) {
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  double sum = 0;
  for (int layer = 0; layer < 4; ++layer) {
    const SurfaceStress<double> s = surface_stress(k, 0.072, sums_at(layer, false, 0));
    EXPECT_NEAR(s.along.y, 0, 1e-15);  // across the surface there is none
    EXPECT_NEAR(s.along.x - s.along.z, 0, 1e-15);
    EXPECT_NEAR(length(s.shear), 0, 1e-15);
    sum += s.along.x;
  }
  EXPECT_NEAR(sum / (tension_gain * 0.072), 1, 0.05);
  // Inside there is none.
  EXPECT_EQ(surface_stress(k, 0.072, sums_at(5, false, 0)).along.x, 0);
}

TEST(SurfaceTension, LayersAtASolidCarryYoungsTension) {
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  for (const double angle : {0.0, 60.0, 90.0, 120.0}) {
    double sum = 0;
    for (int layer = 0; layer < 4; ++layer)
      sum += surface_stress(k, 0.072, sums_at(layer, true, wetting_cosine(angle))).along.x;
    // Beneath its solid the liquid is filled, so that it has no free surface.
    EXPECT_NEAR(sum / (wetting_gain * 0.072), -std::cos(angle * pi / 180), 0.05) << angle;
  }
  const Vec3<double> m = wall_direction(sums_at(0, true, 0.5));
  EXPECT_NEAR(m.y, 1, 1e-12);
  EXPECT_EQ(length(wall_direction(sums_at(0, false, 0))), 0);
}

TEST(SurfaceTension, StressIsItsOwnMirror) {
  SurfaceStress<double> s;
  s.add(2.0, Vec3<double>{0.6, 0, 0.8});
  s.add(-0.5, Vec3<double>{0, 3, 4});
  const Vec3<double> n{0.48, 0.6, 0.64}, v{0.3, -0.2, 0.7};
  const auto mirrored = [&](Vec3<double> x) { return x - n * (2 * dot(n, x)); };
  const Vec3<double> expected = s * v + mirrored(s * mirrored(v));
  EXPECT_NEAR(length(mirrored_sum(s, n, v) - expected), 0, 1e-14);
  EXPECT_NEAR(length(mirrored_sum(s, Vec3<double>{}, v) - (s * v) * 2.0), 0, 1e-14);
  // Along its own plane a tension of 2, across it none.
  SurfaceStress<double> plane;
  plane.add(2.0, Vec3<double>{0, 1, 0});
  EXPECT_NEAR(length(plane * Vec3<double>{1, 5, 0} - Vec3<double>{2, 0, 0}), 0, 1e-15);
}

// Young: a solid that liquid wets wholly holds it as the liquid itself, one of 180 degrees not at all.
TEST(SurfaceTension, WettingFollowsYoung) {
  EXPECT_DOUBLE_EQ(wetting_cosine(0), 1);
  EXPECT_NEAR(wetting_cosine(60), 0.5, 1e-12);
  EXPECT_NEAR(wetting_cosine(90), 0, 1e-12);
  EXPECT_EQ(adhesion_of(2.0, wetting_cosine(0)), 2);
  EXPECT_NEAR(adhesion_of(2.0, wetting_cosine(180)), 0, 1e-12);
}

// Antonow: two liquids have the difference of their tensions, which the one of the larger tension carries.
TEST(SurfaceTension, LiquidsThatMeetHaveTheDifference) {
  const auto carried = [](double own, double other) { return own * (1 - liquid_share(own, other)); };
  EXPECT_NEAR(carried(0.07, 0.02) + carried(0.02, 0.07), 0.05, 1e-15);
  EXPECT_EQ(carried(0.07, 0.07), 0);
  EXPECT_EQ(carried(0.07, 0.0), 0.07);
}

// Waves two spacings long on a deep liquid, omega^2 = sigma k^3/rho with k = pi/dx, turn by pi/sqrt(2) in that time.
TEST(SurfaceTension, StepResolvesTheShortestWaves) {
  const double dx = 1e-3, omega = std::sqrt(0.072 * std::pow(pi / dx, 3) / 1000);
  EXPECT_NEAR(capillary_dt(0.072, 1000, dx) * omega, pi / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(tension_sound_speed(0.072, 1000, dx), 1.87830, 1e-5);
}

}  // namespace
