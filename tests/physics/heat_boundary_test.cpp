// SPDX-License-Identifier: Apache-2.0
// Heat through a surface, the surface of a lattice body, and properties that depend on temperature.
#include <gtest/gtest.h>

#include <cmath>

#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/heat_boundary.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;

SurfaceCondition<double> exchange(double flux, double convection, double emissivity, double ambient) {
  return {ambient, flux, convection, emissivity, SurfaceHeat::exchange};
}

// Closed forms in double: rounding, 1e-14.
TEST(SurfaceHeat, HeldSurfaceConductsOverTheDepth) {
  const SurfaceCondition<double> c{50, 0, 0, 0, SurfaceHeat::held};
  const auto r = surface_heat(c, 0.25, 0.05, 2.0, 20.0);
  EXPECT_DOUBLE_EQ(r.conductance, 0.25 * 2.0 / 0.05);
  EXPECT_DOUBLE_EQ(r.rate, 10.0 * 30);
}

TEST(SurfaceHeat, FilmAndDepthAreInSeries) {
  const auto r = surface_heat(exchange(7, 40, 0, -10), 0.25, 0.05, 2.0, 20.0);
  EXPECT_DOUBLE_EQ(r.conductance, 0.25 / (1 / 40.0 + 0.05 / 2.0));  // 40 and 40 in series: 20
  EXPECT_NEAR(r.rate, 0.25 * 7 - 0.25 * 20 * 30, 1e-12);
  EXPECT_EQ(surface_heat(exchange(7, 40, 0, -10), 0.25, 0.05, 0.0, 20.0).rate,
            0.25 * 7);  // an insulator's skin
}

TEST(SurfaceHeat, RadiationIsTheDifferenceOfFourthPowers) {
  for (const double t : {-50.0, 20.0, 900.0}) {
    const double a = t + 273.15, b = 25 + 273.15;
    EXPECT_NEAR(radiation_coefficient(0.7, t, 25.0) * (t - 25),
                0.7 * 5.670374419e-8 * (std::pow(a, 4) - std::pow(b, 4)), 1e-9 * std::pow(a, 4) * 5.7e-8)
        << t;
  }
}

TEST(SurfaceHeat, InsulatedTakesNothing) {
  SurfaceCondition<double> c = exchange(5, 5, 1, 5);
  c.kind = SurfaceHeat::insulated;
  EXPECT_EQ(surface_heat(c, 1.0, 0.1, 1.0, 0.0).rate, 0.0);
}

/// Sum of particle_surface over a lattice body.
template <class Inside>
double lattice_area(int n, Inside inside) {
  const double support = 2.5, spacing = 1;
  const auto e = make_wall_exchange<double>(support, spacing);
  const auto k = make_kernel<double>(support, spacing);
  const double first = wall_area(e, 0.5);
  double sum = 0;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        if (!inside(x, y, z)) continue;
        Vec3<double> G{};
        int live = 0;
        for (int c = -2; c <= 2; ++c)
          for (int b = -2; b <= 2; ++b)
            for (int a = -2; a <= 2; ++a) {
              if (!inside(x + a, y + b, z + c)) continue;
              if (std::abs(a) <= 1 && std::abs(b) <= 1 && std::abs(c) <= 1) ++live;
              const double r2 = a * a + b * b + c * c;
              if (r2 < support * support)
                G +=
                    Vec3<double>{double(-a), double(-b), double(-c)} * kernel_laplacian(k, std::sqrt(r2), r2);
            }
        if (live < 27) sum += particle_surface(e, 1.0, length(G), live, first).area;
      }
  return sum;
}

// What heat_boundary.hpp says of itself: boxes 0..+2 %, a ball of radius 8 within 3 %.
TEST(ParticleSurface, AddsUpToTheSurfaceOfTheBody) {
  const auto box = [](int x, int y, int z) { return x >= 0 && y >= 0 && z >= 0 && x < 8 && y < 8 && z < 8; };
  EXPECT_NEAR(lattice_area(8, box) / (6 * 64), 1.005, 0.012);
  const auto ball = [](int x, int y, int z) { return x * x + y * y + z * z <= 64; };
  const double radius = std::cbrt(0.75 * 2109 / 3.14159265358979);  // of a sphere of as many cells, 2109
  EXPECT_NEAR(lattice_area(9, ball) / (4 * 3.14159265358979 * radius * radius), 1, 0.03);
}

TEST(ParticleSurface, DryShare) {
  EXPECT_EQ(dry_share(0.8, 0.8), 1.0);
  EXPECT_EQ(dry_share(0.8, 1.0), 0.0);
  EXPECT_NEAR(dry_share(0.8, 0.9), 0.5, 1e-12);
  EXPECT_EQ(dry_share(0.8, 1.1), 0.0);  // crowded
  EXPECT_EQ(dry_share(1.0, 1.0), 0.0);  // inside
}

PropertyTable<double> table(std::initializer_list<std::pair<double, double>> points) {
  PropertyTable<double> t;
  for (const auto& [a, b] : points) {
    t.temperature[t.points] = a;
    t.value[t.points++] = b;
  }
  return t;
}

TEST(PropertyTable, LinearBetweenPointsConstantBeyond) {
  const auto t = table({{0, 10}, {10, 30}, {40, 0}});
  EXPECT_EQ(property_at(t, -5.0), 10);
  EXPECT_EQ(property_at(t, 0.0), 10);
  EXPECT_DOUBLE_EQ(property_at(t, 5.0), 20);
  EXPECT_DOUBLE_EQ(property_at(t, 10.0), 30);
  EXPECT_DOUBLE_EQ(property_at(t, 25.0), 15);
  EXPECT_EQ(property_at(t, 99.0), 0);
}

// h is the integral of c; the inverse returns T. 1e-9 degrees of 1e3.
TEST(EnthalpyCurve, IntegralAndInverse) {
  const auto solid = table({{-50, 1800}, {0, 2100}}), liquid = table({{0, 4200}, {50, 4180}, {100, 4220}});
  const EnthalpyCurve curve = make_enthalpy_curve(solid, liquid, 0, 3.34e5);
  double sum = curve_enthalpy(curve, -80.0);
  for (double t = -80; t < 120; t += 0.01) {
    const double middle = t + 0.005;
    sum += 0.01 * (middle < 0 ? property_at(solid, middle) : property_at(liquid, middle));
    if (t <= 0 && t + 0.01 > 0) {
      EXPECT_NEAR(sum, -3.34e5, 30);  // 0.01 degrees of c
      sum += 3.34e5;
    }
  }
  EXPECT_NEAR(curve_enthalpy(curve, 120.0), sum, 60);
  for (const double t : {-300.0, -50.0, -20.0, -1e-6, 1e-6, 30.0, 50.0, 77.0, 400.0})
    EXPECT_NEAR(curve_temperature(curve, curve_enthalpy(curve, t)), t, 1e-9) << t;
  EXPECT_EQ(curve_temperature(curve, -1e5), 0.0);                               // on the plateau
  EXPECT_NEAR(curve_enthalpy(curve, 10.0), 4200 * 10 - 0.5 * 0.4 * 100, 1e-6);  // liquid: 0 at 0 degrees
}

}  // namespace
