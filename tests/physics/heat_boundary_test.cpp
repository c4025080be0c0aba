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
  // Half of the flux goes on, as the film and the depth share what they pass.
  EXPECT_NEAR(r.rate, 0.25 * 7 / 2 - 0.25 * 20 * 30, 1e-12);
  // An insulator's skin takes all of a flux that cannot go anywhere else, and nothing from a film.
  EXPECT_EQ(surface_heat(exchange(7, 0, 0, -10), 0.25, 0.05, 0.0, 20.0).rate, 0.25 * 7);
  EXPECT_EQ(surface_heat(exchange(7, 40, 0, -10), 0.25, 0.05, 0.0, 20.0).rate, 0.0);
}

// What reaches the surface from outside at its temperature goes on to the particle: from wax to metal, from frost to lava, also where
// the particle is as warm as what is around, and where cooling is all there is. In double to rounding of the larger side, in single
// precision to 1e-4 of what is exchanged at most.
template <class T>
void balances(double tolerance) {
  for (const double inner : {1e-3, 1.0, 40.0, 1e4, 1e7})
    for (const double convection : {0.0, 10.0, 1e5})
      for (const double emissivity : {0.0, 0.3, 1.0})
        for (const double flux : {0.0, 1e3, 1e9, -1e3})
          for (const double temperature : {-200.0, 20.0, 1200.0})
            for (const double ambient : {-270.0, 20.0, 3000.0}) {
              if (convection == 0 && emissivity == 0) continue;
              const double depth = 0.01, area = 0.25, k = inner * depth;
              const SurfaceCondition<T> c{T(ambient), T(flux), T(convection), T(emissivity),
                                          SurfaceHeat::exchange};
              const auto r = surface_heat(c, T(area), T(depth), T(k), T(temperature));
              const double in = double(r.rate) / area, surface = temperature + in / inner;
              if (surface < -273.15 + 1e-3) continue;  // cooled beyond what there is
              const double a = ambient + 273.15, s = surface + 273.15;
              const double out = flux + convection * (ambient - surface) +
                                 emissivity * stefan_boltzmann * (std::pow(a, 4) - std::pow(s, 4));
              const double slope = inner + convection + 4 * emissivity * stefan_boltzmann * std::pow(s, 3);
              const double most = std::fabs(flux) +
                                  (convection + inner) * (std::fabs(ambient - temperature) + 1) +
                                  emissivity * stefan_boltzmann * (std::pow(a, 4) + std::pow(s, 4));
              // An error e of what goes in is one of e/inner of the surface.
              EXPECT_NEAR(out, in, tolerance * most * (slope / inner))
                  << inner << ' ' << convection << ' ' << emissivity << ' ' << flux << ' ' << temperature
                  << ' ' << ambient;
            }
}
TEST(SurfaceHeat, GivesOnWhatItGets) {
  balances<double>(1e-12);
  balances<float>(1e-5);
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

/// Sum of particle_surface over those of a lattice body that count.
template <class Inside, class Counts>
double lattice_area(int n, Inside inside, Counts counts) {
  const double support = 2.5, spacing = 1;
  const auto e = make_wall_exchange<double>(support, spacing);
  const auto k = make_kernel<double>(support, spacing);
  double sum = 0;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        if (!inside(x, y, z) || !counts(x, y, z)) continue;
        Vec3<double> G{};
        std::uint32_t direct = 0;
        for (int c = -2; c <= 2; ++c)
          for (int b = -2; b <= 2; ++b)
            for (int a = -2; a <= 2; ++a) {
              if (!inside(x + a, y + b, z + c)) continue;
              if (std::abs(a) <= 1 && std::abs(b) <= 1 && std::abs(c) <= 1)
                direct |= 1u << ((a + 1) + 3 * (b + 1) + 9 * (c + 1));
              const double r2 = a * a + b * b + c * c;
              if (r2 < support * support)
                G +=
                    Vec3<double>{double(-a), double(-b), double(-c)} * kernel_laplacian(k, std::sqrt(r2), r2);
            }
        if (direct != (1u << 27) - 1) sum += particle_surface(e, 1.0, length(G), direct).area;
      }
  return sum;
}

template <class Inside>
double lattice_area(int n, Inside inside) {
  return lattice_area(n, inside, [](int, int, int) { return true; });
}

/// Of a cube of this edge whose axes are these, over offsets of a lattice: relative to its true surface.
double turned_cube(double edge, const Vec3<double>& a, const Vec3<double>& b) {
  const Vec3<double> c = cross(a, b);
  constexpr int offsets = 48;
  double sum = 0;
  for (int o = 0; o < offsets; ++o) {
    const auto shift = [&](double step) {
      return std::fmod(o * step, 1.0) - 0.5;
    };  // evenly, along no diagonal
    const Vec3<double> at{shift(0.8191725), shift(0.6710436), shift(0.5497005)};
    sum += lattice_area(static_cast<int>(edge) + 1, [&](int i, int j, int k) {
      const Vec3<double> p{i - at.x, j - at.y, k - at.z};
      return std::fabs(dot(p, a)) < edge / 2 && std::fabs(dot(p, b)) < edge / 2 &&
             std::fabs(dot(p, c)) < edge / 2;
    });
  }
  return sum / (offsets * 6 * edge * edge);
}

// What heat_boundary.hpp says of itself: 4 %, boxes along the lattice the faces of their cells, however thin. Factors of one for all but edges of boxes
// make turned cubes of 6 spacings lose 4 to 9 %.
TEST(ParticleSurface, AddsUpToTheSurfaceOfTheBody) {
  for (const int edge : {2, 3, 6, 8}) {
    const auto box = [&](int x, int y, int z) {
      return x >= 0 && y >= 0 && z >= 0 && x < edge && y < edge && z < edge;
    };
    EXPECT_NEAR(lattice_area(edge, box) / (6.0 * edge * edge), 1, 1e-12) << edge;
  }
  const double s = std::sqrt(0.5);
  EXPECT_NEAR(turned_cube(6, {s, s, 0}, {-s, s, 0}), 1, 0.045);               // by 45 degrees
  EXPECT_NEAR(turned_cube(6, {0.36, 0.48, -0.8}, {-0.8, 0.6, 0}), 1, 0.045);  // along nothing
  EXPECT_NEAR(turned_cube(8, {2 / 3., 2 / 3., 1 / 3.}, {-2 / 3., 1 / 3., 2 / 3.}), 1, 0.045);
}

// Balls against a sphere of as many cells: where anyone puts them first, about a site, the middle of a cell, of a face or of an edge, and at chance.
// Steps of such a ball stand in rings of 4 to 24 alike, so that what one of them is off does not average out: 6 %. By |G| and factors for edges those of
// 3 spacings were 29 % too large, those of 2 up to 42 %.
TEST(ParticleSurface, BallsHaveTheirAreaWhereverTheyLie) {
  const double pi = 3.14159265358979;
  const Vec3<double> places[] = {{0, 0, 0}, {0.5, 0.5, 0.5}, {0.5, 0.5, 0}, {0.5, 0, 0}, {0.17, 0.3, 0.41}};
  for (const double radius : {2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0})
    for (const Vec3<double>& at : places) {
      int cells = 0;
      const auto ball = [&](int x, int y, int z) {
        return dot(Vec3<double>{double(x), double(y), double(z)} - at,
                   Vec3<double>{double(x), double(y), double(z)} - at) <= radius * radius;
      };
      const int n = static_cast<int>(radius) + 2;
      for (int z = -n; z <= n; ++z)
        for (int y = -n; y <= n; ++y)
          for (int x = -n; x <= n; ++x) cells += ball(x, y, z) ? 1 : 0;
      EXPECT_NEAR(lattice_area(n, ball) / (4 * pi * std::pow(0.75 * cells / pi, 2.0 / 3.0)), 1, 0.06)
          << radius << " at " << at.x << " " << at.y << " " << at.z;
    }
}

// Sheets and rods of one site and of two, along each axis, and a single site: the faces of their cells, to rounding.
TEST(ParticleSurface, SheetsRodsAndSingleSitesShowTheFacesOfTheirCells) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto within = [&](int x, int y, int z, int thin, int wide, int high) {
      const int p[3] = {x, y, z}, a = p[axis], b = p[(axis + 1) % 3], c = p[(axis + 2) % 3];
      return a >= 0 && b >= 0 && c >= 0 && a < thin && b < wide && c < high;
    };
    const auto area = [&](int thin, int wide, int high) {
      return lattice_area(8, [&](int x, int y, int z) { return within(x, y, z, thin, wide, high); });
    };
    EXPECT_NEAR(area(1, 7, 5), 2 * (7 + 5 + 35), 1e-12) << axis;
    EXPECT_NEAR(area(1, 1, 6), 2 * (1 + 6 + 6), 1e-12) << axis;
    EXPECT_NEAR(area(1, 1, 1), 6, 1e-12) << axis;
    EXPECT_NEAR(area(2, 7, 5), 2 * (14 + 10 + 35), 1e-12) << axis;
    EXPECT_NEAR(area(2, 2, 5), 2 * (4 + 10 + 10), 1e-12) << axis;
  }
}

/// Sum of particle_surface over a cube of 4 sites in a corner of three walls, `gap` from each, whose lattice is turned by `turn`.
double area_in_a_corner(double gap, const Quat<double>& turn) {
  const double support = 2.5;
  const auto e = make_wall_exchange<double>(support, 1);
  const auto k = make_kernel<double>(support, 1);
  WallBox<double> walls;
  walls.max = {20, 20, 20};
  walls.faces = 63;
  walls.support = support;
  double sum = 0;
  const auto at = [&](int x, int y, int z) {  // the middle of the cube stays where it is
    const Vec3<double> middle{2 + gap, 2 + gap, 2 + gap};
    return middle + rotate(turn, Vec3<double>{x - 1.5, y - 1.5, z - 1.5});
  };
  for (int i = 0; i < 64; ++i) {
    const int x = i % 4, y = i / 4 % 4, z = i / 16;
    std::uint32_t sites = 0;
    for (int c = 0; c < 27; ++c) {
      const int a = x + c % 3 - 1, b = y + c / 3 % 3 - 1, d = z + c / 9 - 1;
      if (a >= 0 && b >= 0 && d >= 0 && a < 4 && b < 4 && d < 4) sites |= 1u << c;
    }
    const auto flush = flush_walls(e, wall_view(walls, at(x, y, z)), turn, sites);
    BodySums<double> s;
    for (int j = 0; j < 64; ++j) {
      const Vec3<double> x_ij = at(x, y, z) - at(j % 4, j / 4 % 4, j / 16);
      if (dot(x_ij, x_ij) < k.support2) s.add(k, flush.view, 1, x_ij, dot(x_ij, x_ij), true);
    }
    const auto filled = [&](int face) { return (flush.view.axes >> (face / 2) & 1u) != 0u ? 0.0 : 1.0; };
    s.everything += wall_cover(walls, k, at(x, y, z), filled);
    if (sites != all_sites)
      sum += particle_surface(e, 1.0, length(s.G), flush.direct).area * dry_share(s.own, s.everything);
  }
  return sum;
}

// A body in a corner shows its three free faces in full, however its lattice lies there, and to 0.2 spacings; from two spacings on, which is
// out of the walls' reach but for a corner of the support, all six.
TEST(ParticleSurface, EndsAtWallsThatTheBodyTouches) {
  const double h = std::sqrt(0.5);
  const Quat<double> turns[] = {{},           {h, h, 0, 0}, {h, 0, -h, 0},
                                {h, 0, 0, h}, {0, 0, 1, 0}, {0.5, 0.5, 0.5, 0.5}};
  for (const Quat<double>& turn : turns) {
    EXPECT_NEAR(area_in_a_corner(0, turn), 48, 1e-9);
    EXPECT_NEAR(area_in_a_corner(0.19, turn), 48, 1e-9);
    EXPECT_NEAR(area_in_a_corner(2, turn), 96, 1e-9);
  }
}

// Planes of any orientation: the sites of a body without end whose columns along z lie in a window of 21^2. 6 %: 1 to 3
// of the formula, and the window's rim cuts steps by up to a row of sites.
TEST(ParticleSurface, PlanesOfAnyOrientationHaveTheirArea) {
  const Vec3<double> normals[] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0, 1, 2},     {0, 1, 3},
                                  {1, 1, 2}, {1, 2, 2}, {1, 2, 5}, {0.3, 0.7, 1}, {0.5, 0.6, 0.8}};
  for (const auto& n : normals) {
    const auto beneath = [&](int x, int y, int z) { return dot(n, {x + 0.3, y + 0.1, z + 0.2}) <= 0; };
    const auto window = [](int x, int y, int) { return std::abs(x) <= 10 && std::abs(y) <= 10; };
    EXPECT_NEAR(lattice_area(24, beneath, window) / (21 * 21 * length(n) / n.z), 1, 0.06)
        << n.x << " " << n.y << " " << n.z;
  }
}

// Plates across the lattice, where the sides of a row of sites cancel in G: they showed 0 of their surface at 45 degrees and, of two
// spacings, 0.75 of it. A tenth for one spacing, where steps are up to 1.1 times as long as the plane; 13 % for those of 1.5 and 2, which are sampled as
// one, two or three layers.
TEST(ParticleSurface, PlatesAcrossTheLatticeShowBothSides) {
  const Vec3<double> normals[] = {{0, 1, 1}, {1, 1, 1}, {0, 1, 2}, {0, 1, 4}, {1, 2, 5}, {0.5, 0.6, 0.8}};
  const auto window = [](int x, int y, int) { return std::abs(x) <= 10 && std::abs(y) <= 10; };
  const auto shown = [&](const Vec3<double>& n, double thickness) {
    double sum = 0;
    for (const double at : {-0.45, -0.25, -0.05, 0.15, 0.35})
      sum += lattice_area(
          24,
          [&](int x, int y, int z) {
            return std::fabs(dot(n, {double(x), double(y), z + at})) < thickness / 2 * length(n);
          },
          window);
    return sum / (5 * 2 * 21 * 21 * length(n) / n.z);
  };
  for (const auto& n : normals) {
    EXPECT_NEAR(shown(n, 1), 1, 0.1) << n.x << " " << n.y << " " << n.z;
    for (const double thickness : {1.5, 2.0}) {
      const double share = shown(n, thickness);
      EXPECT_NEAR(share, 1, 0.13) << thickness << " of " << n.x << " " << n.y << " " << n.z;
    }
  }
}

TEST(ParticleSurface, DryShare) {
  EXPECT_EQ(dry_share(0.8, 0.8), 1.0);
  EXPECT_EQ(dry_share(0.8, 1.0), 0.0);
  EXPECT_NEAR(dry_share(0.8, 0.9), 0.5, 1e-12);
  EXPECT_EQ(dry_share(0.8, 1.1), 0.0);  // crowded
  EXPECT_EQ(dry_share(1.0, 1.0), 0.0);  // inside
}

// A gap of a few tenths of a spacing is covered; from twice that share on it counts in full, without a jump.
TEST(ParticleSurface, AGapOfAFewTenthsOfASpacingIsCovered) {
  EXPECT_EQ(dry_share(0.8, 1 - 0.2 * 0.19), 0.0);
  EXPECT_NEAR(dry_share(0.8, 1 - 0.2 * 0.3), 0.2, 1e-12);
  EXPECT_NEAR(dry_share(0.8, 1 - 0.2 * 0.4), 0.4, 1e-12);
  EXPECT_NEAR(dry_share(0.8, 1 - 0.2 * 0.6), 0.6, 1e-12);
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
  const EnthalpyCurve curve = make_enthalpy_curve(solid, liquid, {0, 0, 3.34e5});
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

// Both capacities change along the range: what melting takes is L and the mean of their integrals, and T is linear in it.
TEST(EnthalpyCurve, AMeltingRangeJoinsBothPhases) {
  const auto solid = table({{-50, 1800}, {10, 2400}}), liquid = table({{0, 4200}, {50, 4000}});
  const EnthalpyCurve curve = make_enthalpy_curve(solid, liquid, {2, 6, 3e5});
  const double begin = curve_enthalpy(curve, 2.0), end = curve_enthalpy(curve, 8.0);
  EXPECT_NEAR(end - begin, 3e5 + 0.5 * 6 * (0.5 * (2320 + 2380) + 0.5 * (4192 + 4168)), 1e-6);
  EXPECT_NEAR(end, 8 * 0.5 * (4200 + 4168), 1e-6);  // liquid: 0 at 0 degrees
  for (const double share : {0.0, 0.25, 0.5, 0.99, 1.0})
    EXPECT_NEAR(curve_temperature(curve, begin + share * (end - begin)), 2 + 6 * share, 1e-9);
  for (const double t : {-300.0, -50.0, 1.9, 2.1, 5.0, 7.9, 8.1, 30.0, 77.0})
    EXPECT_NEAR(curve_temperature(curve, curve_enthalpy(curve, t)), t, 1e-9) << t;
  EXPECT_NEAR(begin - curve_enthalpy(curve, 1.0), 0.5 * (2310 + 2320), 1e-6);
}

}  // namespace
