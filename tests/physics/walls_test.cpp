// SPDX-License-Identifier: Apache-2.0
// Images in walls against particles mirrored explicitly: box [0, 4]^3, dx = 0.2 m, H = 2.5 dx.
#include "meltsim/physics/walls.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "meltsim/physics/fluid.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double dx = 0.2, support = 0.5, cell = dx * dx * dx, size = 4;

WallBox<double> box(std::uint32_t faces = 63u) {
  WallBox<double> b;
  b.max = {size, size, size};
  b.faces = faces;
  b.support = support;
  b.cover_scale = wall_cover_scale<double>(support, dx);
  return b;
}

/// x and its 26 reflections in the planes of walled faces, each made by hand.
std::vector<Vec3<double>> reflections(Vec3<double> x, std::uint32_t faces) {
  std::vector<Vec3<double>> all;
  for (int m = 1; m < 27; ++m) {
    const int how[3] = {m % 3, m / 3 % 3, m / 9};
    double at[3] = {x.x, x.y, x.z};
    bool walled = true;
    for (int a = 0; a < 3; ++a) {
      if (how[a] == 0) continue;
      walled = walled && ((faces >> (2 * a + how[a] - 1)) & 1u) != 0u;
      at[a] = how[a] == 1 ? -at[a] : 2 * size - at[a];
    }
    if (walled) all.push_back({at[0], at[1], at[2]});
  }
  return all;
}

// Pairs beside faces, edges and corners, with all walls and with some missing. The images found must be those
// made by hand within H: number, distance and the sum of their offsets, to rounding.
TEST(WallImages, AreTheReflectionsWithinReach) {
  Random random(21);
  const auto kernel = make_kernel<double>(support, dx);
  int found_at_all = 0, corners = 0;
  for (int n = 0; n < 20000; ++n) {
    const std::uint32_t faces = n % 3 == 0 ? 63u : n % 3 == 1 ? 0x15u : 0x2cu;
    Vec3<double> i{random.uniform(0, 0.5), random.uniform(0, 0.5), random.uniform(0, 0.5)};
    if (n % 4 == 1) i.y = 2;
    if (n % 5 == 1) i.z = size - i.z;
    if (n % 7 == 1) i.x = size - i.x;
    Vec3<double> j = i + random.vector(n % 11 == 0 ? 0.0 : 0.3);
    j = {clamp(j.x, 0.0, size), clamp(j.y, 0.0, size), clamp(j.z, 0.0, size)};
    int expected = 0, found = 0;
    double shape = 0;
    Vec3<double> sum{}, seen{};
    for (const auto& m : reflections(j, faces)) {
      const auto d = i - m;
      if (length(d) >= support) continue;
      ++expected;
      shape += kernel_shape(kernel, length(d));
      sum += d * kernel_gradient_factor(kernel, length(d));
    }
    for_each_image(wall_view(box(faces), i), support * support, i - j, [&](const Vec3<double>& d, double r2) {
      ++found;
      EXPECT_NEAR(r2, dot(d, d), 1e-14);
      seen += d * kernel_gradient_factor(kernel, std::sqrt(r2));
    });
    ASSERT_EQ(found, expected) << n;
    ASSERT_LE(length(seen - sum), 1e-9 * (1 + length(sum))) << n;
    // What density and forces take: sums of weights instead of images one by one.
    const auto view = wall_view(box(faces), i);
    const double r2 = dot(i - j, i - j);
    ASSERT_NEAR(image_shape(kernel, view, i - j, r2), shape, 1e-12) << n;
    const auto push = image_pressure_force(kernel, view, i - j, r2, 0.5, 2.0, 3.0);
    ASSERT_LE(length((i - j) * push.along + push.normal - sum * 3.0), 1e-9 * (1 + length(sum))) << n;
    found_at_all += found;
    corners += found == 7 ? 1 : 0;
  }
  EXPECT_GT(found_at_all, 10000);
  EXPECT_GT(corners, 20);
}

/// phi, and the force at unit pressure, of a lattice particle m layers from each of the walls that `faces`
/// has low.
struct Reading {
  double phi = 0;
  Vec3<double> force{};
};
Reading read(Vec3<double> x, std::uint32_t faces) {
  const auto kernel = make_kernel<double>(support, dx);
  const auto view = wall_view(box(faces), x);
  Reading out;
  const auto add = [&](const Vec3<double>& d, double r2) {
    out.phi += cell * kernel_value(kernel, std::sqrt(r2));
    out.force += pressure_force(cell, cell, 1.0, 1.0, kernel_gradient_factor(kernel, std::sqrt(r2)), d);
  };
  for (int c = -3; c <= 3; ++c)
    for (int b = -3; b <= 3; ++b)
      for (int a = -3; a <= 3; ++a) {
        const Vec3<double> d{dx * a, dx * b, dx * c}, other = x - d;
        if (minimum(minimum(other.x, other.y), other.z) < 0 || dot(d, d) >= support * support) continue;
        add(d, dot(d, d));
        for_each_image(view, support * support, d, add);
      }
  return out;
}

// A lattice half a spacing from the walls continues itself beyond them: 1, and no force, to rounding.
TEST(WallImages, LatticeReadsOneAndFeelsNothing) {
  for (const double y : {0.1, 0.3, 2.1})
    for (const double z : {0.1, 0.3, 2.1}) {
      const Reading r = read({0.1, y, z}, 63u);
      EXPECT_NEAR(r.phi, 1.0, 1e-12) << y << " " << z;
      EXPECT_LE(length(r.force), 1e-14) << y << " " << z;
    }
}

// A column of lattice layers under its own weight, P = rho g (h - y): pressure, images and floor_push
// together carry every particle. Exact in the first layer, which the scale is made for; the second's push is
// 2 % of g, and 3 % of that are left. Without the push the first layer carries half.
TEST(FloorPush, CarriesAColumnWithTheImages) {
  const auto kernel = make_kernel<double>(support, dx);
  WallBox<double> b;
  b.min = {-100, 0, -100};
  b.max = {100, 100, 100};
  b.support = support;
  b.faces = 4u;  // the floor
  b.push_scale = floor_push_scale<double>(support, dx);
  const Vec3<double> gravity{0, -9.81, 0};
  const auto operand = [](double y) { return 9.81 * (20 * dx - y); };  // P/rho
  for (const int layer : {0, 1, 2, 6}) {
    const Vec3<double> x{0, (layer + 0.5) * dx, 0};
    const auto view = wall_view(b, x);
    Vec3<double> a = floor_push(b, kernel, view, gravity);
    for (int i = -3; i <= 3; ++i)
      for (int j = 0; j <= layer + 3; ++j)
        for (int k = -3; k <= 3; ++k) {
          const Vec3<double> other{i * dx, (j + 0.5) * dx, k * dx}, d = x - other;
          const double sum = dx * dx * dx * (operand(x.y) + operand(other.y));
          if (dot(d, d) < support * support) a += d * (sum * kernel_gradient_factor(kernel, length(d)));
          for_each_image(view, support * support, d, [&](const Vec3<double>& image, double r2) {
            a += image * (sum * kernel_gradient_factor(kernel, std::sqrt(r2)));
          });
        }
    EXPECT_NEAR(a.y / 9.81, 1, layer == 1 ? 1e-3 : 1e-12) << layer;
    EXPECT_LE(std::fabs(a.x) + std::fabs(a.z), 1e-12) << layer;
  }
  const auto at = [&](double y, Vec3<double> g) {
    const Vec3<double> x{0, y, 0};
    return length(floor_push(b, kernel, wall_view(b, x), g));
  };
  EXPECT_EQ(at(support, gravity), 0.0);
  EXPECT_EQ(at(0.1, -gravity), 0.0);  // a ceiling
  EXPECT_EQ(at(0.1, {9.81, 0, 0}), 0.0);
  EXPECT_NEAR(at(0.0, gravity) / 9.81, 1.15, 0.01);  // bounded: a particle that lies on the floor
}

constexpr double stiffness = 1000.0 * 30 * 30 / 7;
double energy_density(double phi) {  // derivative P/phi^2
  const double p = maximum(phi, 1.0);
  return stiffness * (std::pow(p, 6) / 6 + 1 / p);
}

struct Corner {
  SphKernel<double> kernel = make_kernel<double>(support, dx);
  std::vector<Vec3<double>> x;
  double phi(std::size_t i) const {
    double sum = 0;
    const auto view = wall_view(box(), x[i]);
    for (const auto& j : x) {
      const auto d = x[i] - j;
      sum += 1.2 * cell * kernel_value(kernel, length(d));
      for_each_image(view, support * support, d, [&](const Vec3<double>&, double r2) {
        sum += 1.2 * cell * kernel_value(kernel, std::sqrt(r2));
      });
    }
    return sum;
  }
  double energy() const {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += 1.2 * cell * energy_density(phi(i));
    return sum;
  }
};

// A cloud in a corner, compressed. As for the liquid alone (fluid_test.cpp): step 1e-6 m, 1e-5 of the rms
// force; the factor is the ratio of the lattice corrections of grad W and W.
TEST(WallImages, ForceIsMinusTheGradientOfTheEnergy) {
  Random random(31);
  Corner c;
  for (int i = 0; i < 50; ++i) c.x.push_back(random.vector(0.25) + Vec3<double>{0.27, 0.27, 0.27});
  std::vector<double> term;
  for (std::size_t i = 0; i < c.x.size(); ++i)
    term.push_back(pressure_term(tait_pressure(stiffness, c.phi(i)), c.phi(i)));
  const double ratio = c.kernel.grad_scale * c.kernel.support2 / (20 * c.kernel.w_scale), v = 1.2 * cell;
  std::vector<Vec3<double>> force(c.x.size());
  double square = 0;
  for (std::size_t i = 0; i < c.x.size(); ++i) {
    const auto view = wall_view(box(), c.x[i]);
    for (std::size_t j = 0; j < c.x.size(); ++j) {
      const auto add = [&](const Vec3<double>& d, double r2) {
        force[i] +=
            pressure_force(v, v, term[i], term[j], kernel_gradient_factor(c.kernel, std::sqrt(r2)), d);
      };
      const auto d = c.x[i] - c.x[j];
      add(d, dot(d, d));
      for_each_image(view, support * support, d, add);
    }
    square += dot(force[i], force[i]);
  }
  const double rms = std::sqrt(square / static_cast<double>(c.x.size())), e = 1e-6;
  ASSERT_GT(rms, 1.0);
  for (std::size_t i = 0; i < c.x.size(); i += 5)
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Corner high = c, low = c;
      high.x[i].*axis += e;
      low.x[i].*axis -= e;
      EXPECT_NEAR(force[i].*axis, -ratio * (high.energy() - low.energy()) / (2 * e), 1e-5 * rms);
    }
}

TEST(WallView, OutOfReachAndMissingFacesAreNotSeen) {
  EXPECT_EQ(wall_view(box(), {2, 2, 2}).axes, 0u);
  EXPECT_EQ(wall_view(box(), {0.1, 2, 3.9}).axes, 5u);
  EXPECT_EQ(wall_view(box(62u), {0.1, 2, 2}).axes, 0u);  // no wall at -x
  EXPECT_NEAR(wall_view(box(), {3.9, 2, 2}).from.x, -0.1, 1e-12);
}

// Behind a wall a particle counts as on it: finite, and pushed inwards by everything near.
TEST(WallImages, FiniteBehindTheWall) {
  const auto view = wall_view(box(), {-0.05, 2, 2});
  EXPECT_GT(view.from.x, 0.0);
  EXPECT_LT(view.from.x, 1e-5);
  for_each_image(view, support * support, Vec3<double>{-0.1, 0, 0},
                 [&](const Vec3<double>& d, double r2) { EXPECT_TRUE(d.x > 0 && r2 > 0); });
}

// Half of everything on the plane itself; at dx/2 the lattice's share; an edge by the product.
TEST(WallCover, IsTheShareBehindThePlanes) {
  EXPECT_NEAR(half_space_share(uncorrected_kernel<double>(support), 0.0), 0.5, 1e-12);
  const auto k = make_kernel<double>(support, dx);
  const double plane = lattice_half_space(support, dx);
  EXPECT_NEAR(wall_cover(box(), k, {0.1, 2, 2}), plane, 1e-12);
  EXPECT_NEAR(wall_cover(box(), k, {0.1, 3.9, 2}), 1 - (1 - plane) * (1 - plane), 1e-12);
  EXPECT_EQ(wall_cover(box(), k, {2, 2, 2}), 0.0);
  // Against midpoints: layers of thickness dz at depth z hold 2 pi int_z^H W r dr each; 1e-4 at 400 of them.
  double sum = 0;
  const double dz = (support - 0.13) / 400;
  for (int i = 0; i < 400; ++i) {
    const double z = 0.13 + (i + 0.5) * dz, dr = (support - z) / 400;
    for (int j = 0; j < 400; ++j) {
      const double r = z + (j + 0.5) * dr;
      sum += 2 * 3.14159265358979323846 * kernel_value(k, r) * r * dr * dz;
    }
  }
  EXPECT_NEAR(half_space_share(k, 0.13), sum, 1e-4 * sum);
}

TEST(WallViscousForce, IsTheExchangesArea) {
  const auto e = make_wall_exchange<double>(support, dx);
  const Vec3<double> f = wall_viscous_force(e, 0.3, cell, 0.1, Vec3<double>{0, 2, 0});
  EXPECT_DOUBLE_EQ(f.y, 0.3 * cell * wall_area(e, 0.1) / 0.1 * 2);
  EXPECT_EQ(f.x, 0.0);
}

}  // namespace
