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
  EXPECT_EQ(cohesion_of(0.3, 0.7, 1.0, 0.5), cohesion_of(0.7, 0.3, 0.5, 1.0));
  EXPECT_EQ(cohesion_of(0.3, 0.7, 0.0, 0.0), 0);  // inside
}

/// S of the particle `layer` spacings below the surface of a half space on a lattice, or above the solid of a half space of liquid.
/// Also phi, and what pairs carry of a stress along x.
struct Layer {
  SurfaceSums<double> sums;
  double phi = 0, carried = 0;
};
Layer layer_at(int layer, bool solid, double cosine, double support = 2.5) {
  const SphKernel<double> k = make_kernel<double>(support, 1.0);
  Layer at;
  const int n = int(support) + 1;
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const Vec3<double> d{-double(x), -double(y), -double(z)};  // x_i - x_j
        const double r = length(d);
        if (r >= support || (y + layer < 0 && !solid)) continue;
        const double shape = kernel_gradient_shape(k, r);
        at.sums.add(1, 1, shape, d);
        if (y + layer < 0) at.sums.add_wall(1, cosine, shape, d, d);
        at.phi += kernel_value(k, r);
        at.carried += k.grad_scale * shape * x * x;
      }
  return at;
}
SurfaceSums<double> sums_at(int layer, bool solid, double cosine) {
  return layer_at(layer, solid, cosine).sums;
}

// The tension that a plane surface carries: what pairs carry of S_xx, summed over the layers, is that of the formula at any support. The
// lattice leaves out up to 4 % (e), at 1.5 dx it is 3 % above, as phi is. Without phi as the divisor it would be 0.75 to 0.87 of it.
TEST(SurfaceTension, PlaneLayersCarryTheTensionAtAnySupport) {
  for (const double support : {1.5, 2.0, 2.5, 3.0, 4.0, 6.0}) {
    const SphKernel<double> k = make_kernel<double>(support, 1.0);
    double sum = 0;
    for (int layer = 0; layer < 7; ++layer) {
      const Layer at = layer_at(layer, false, 0, support);
      const SurfaceStress<double> s = surface_stress(k, 0.072, at.phi, at.sums);
      EXPECT_NEAR(s.along.y, 0, 1e-15);  // across the surface there is none
      EXPECT_NEAR(s.along.x - s.along.z, 0, 1e-15);
      EXPECT_NEAR(length(s.shear), 0, 1e-15);
      sum += s.along.x * at.carried;
    }
    EXPECT_NEAR(sum / (tension_gain * 0.072), 1, 0.05) << support;
  }
  // Inside there is none.
  const Layer inside = layer_at(5, false, 0);
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  EXPECT_EQ(surface_stress(k, 0.072, inside.phi, inside.sums).along.x, 0);
  EXPECT_EQ(free_share(k, inside.sums), 0);
  EXPECT_EQ(free_share(k, sums_at(0, false, 0)), 1);
  // Particles with hardly a neighbour do not get more than twice their stress.
  EXPECT_EQ(surface_stress(k, 0.072, 0.2, sums_at(0, false, 0)).along.x,
            surface_stress(k, 0.072, 0.5, sums_at(0, false, 0)).along.x);
}

// The skin takes energy out of what moves along the line between two particles, leaves their turning about each other alone, and is
// antisymmetric. At walls it is as strong as their stress.
TEST(SurfaceTension, SkinDampsAlongTheLineBetweenTwo) {
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  const Vec3<double> x{0.6, 0.8, 0}, v{0.3, 0.1, 0.2};
  const Vec3<double> f = skin_force(k, 1.0, 0.5, x, v, 1.0), back = skin_force(k, 1.0, 0.5, -x, -v, 1.0);
  EXPECT_EQ(length(f + back), 0);
  EXPECT_LT(dot(f, v), 0);
  EXPECT_NEAR(length(cross(f, x)), 0, 1e-15);
  EXPECT_NEAR(length(skin_force(k, 1.0, 0.5, x, Vec3<double>{-0.8, 0.6, 0}, 1.0)), 0, 1e-15);
  EXPECT_EQ(skin_viscosity_of(0.3, 0.7, 1.0, 0.5), skin_viscosity_of(0.7, 0.3, 0.5, 1.0));
  EXPECT_EQ(skin_viscosity_of(0.3, 0.0, 1.0, 1.0), 0);  // the other liquid has no tension
  EXPECT_NEAR(skin_viscosity(0.072, 1000, 1e-3), 0.5 * 0.268328, 1e-6);
  EXPECT_EQ(skin_share(k, sums_at(0, false, 0)), 1);
  EXPECT_NEAR(skin_share(k, sums_at(0, true, 0.5)), 0.5, 1e-12);
  EXPECT_EQ(skin_share(k, sums_at(0, true, 0)), 0);
}

TEST(SurfaceTension, LayersAtASolidCarryYoungsTension) {
  const SphKernel<double> k = make_kernel<double>(2.5, 1.0);
  for (const double angle : {0.0, 60.0, 90.0, 120.0}) {
    double sum = 0;
    for (int layer = 0; layer < 4; ++layer) {
      const Layer at = layer_at(layer, true, wetting_cosine(angle));
      sum += surface_stress(k, 0.072, at.phi, at.sums).along.x * at.carried;
    }
    // Beneath its solid the liquid is filled, so that it has no free surface.
    EXPECT_NEAR(sum / (wetting_gain * 0.072), -std::cos(angle * pi / 180), 0.05) << angle;
  }
  const Vec3<double> m = wall_direction(k, sums_at(0, true, 0.5));
  EXPECT_NEAR(m.y, 1, 1e-12);
  EXPECT_EQ(length(wall_direction(k, sums_at(0, false, 0))), 0);
}

// In units of 2^-20 m, a micrometre, single precision gives the bits that it gives in metres: sums of V x go with the fourth power of the
// spacing, and their squares left its range. A solid that has just come into reach, 0.003 H within it, made stresses of
// inf - inf from spacings of 0.1 mm on.
TEST(SurfaceTension, SmallSpacingsAreWithinSinglePrecision) {
  const auto same = [](Vec3<float> a, Vec3<float> b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  const auto stress_at = [](float unit, float inside, SphKernel<float>& k, SurfaceSums<float>& sums) {
    k = make_kernel<float>(2.5 * double(unit), double(unit));
    const float volume = unit * unit * unit, shape = inside * inside * inside;
    sums.add(volume, 1, kernel_gradient_shape(k, unit), Vec3<float>{0, -unit, 0});
    for (const Vec3<float> x : {Vec3<float>{1.5f, 2, 0}, Vec3<float>{-1.5f, 1.9f, 0.25f}}) {
      sums.add(volume, 1, shape, x * unit);
      sums.add_wall(volume, 0.866f, shape, x * unit, x * unit);
    }
    return surface_stress(k, 0.072f, 0.7f, sums);
  };
  for (const float inside : {1.0f, 0.1f, 0.003f}) {
    SphKernel<float> k, small;
    SurfaceSums<float> sums, few;
    const SurfaceStress<float> one = stress_at(1, inside, k, sums);
    for (const int power : {-7, -13, -20}) {
      const float unit = std::exp2(float(power));
      few = {};
      const SurfaceStress<float> s = stress_at(unit, inside, small, few);
      EXPECT_TRUE(same(s.along * unit, one.along)) << power << ' ' << inside;
      EXPECT_TRUE(same(s.shear * unit, one.shear)) << power << ' ' << inside;
      EXPECT_EQ(free_share(small, few), free_share(k, sums));
      EXPECT_EQ(skin_share(small, few), skin_share(k, sums));
      EXPECT_TRUE(same(wall_direction(small, few), wall_direction(k, sums)));
      EXPECT_NEAR(length(wall_direction(small, few)), 1, 1e-6);
    }
  }
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
