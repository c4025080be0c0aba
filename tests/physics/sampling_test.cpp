// SPDX-License-Identifier: Apache-2.0
// Averages at a point and the level along a line, against sums written out and lattices whose surface is known.
#include "meltsim/physics/sampling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr std::uint32_t everything = (1u << sample_fields) - 1u;

// Two particles with weights 3 and 1, one of them a half-molten solid. All numbers are exact in binary.
TEST(Sampling, SolidsCountForHeatAndNotForPressure) {
  MaterialRow<double> water;
  water.density = 1000;
  water.heat_capacity = 4000;
  MaterialRow<double> ice;
  ice.density = 900;
  ice.heat_capacity = 2000;
  ice.plateau = 1;
  ice.latent_heat = ice.melting_heat = 1024;
  SampleSums s;
  EXPECT_TRUE(std::isnan(sampled_value(s, SampleField::temperature, 0)));
  s.add(1, sampled(ice, false, 512, 2, 1, 0.75, -3, {7, 8, 9}, everything));
  EXPECT_EQ(sampled_value(s, SampleField::liquid_fraction, 0), 0.5);
  EXPECT_TRUE(std::isnan(sampled_value(s, SampleField::pressure, 0)));
  EXPECT_TRUE(std::isnan(sampled_value(s, SampleField::speed, 0)));
  SampleSums liquid;  // added up apart, as parts of a sum are
  liquid.add(3, sampled(water, true, 160000, 500, 0.5, 2, 25, {3, 0, -4}, everything));
  s.add(liquid);
  EXPECT_EQ(sampled_value(s, SampleField::temperature, 0), (3 * 40.0 + 0) / 4);
  EXPECT_EQ(sampled_value(s, SampleField::density, 0), (3 * 2000.0 + 900) / 4) << "phi m / V of liquid";
  EXPECT_EQ(sampled_value(s, SampleField::liquid_fraction, 0), (3 + 0.5) / 4);
  EXPECT_EQ(sampled_value(s, SampleField::pressure, 0), 100) << "P = P/phi^2 phi^2";
  EXPECT_EQ(sampled_value(s, SampleField::speed, 0), 5);
  for (std::uint32_t c = 0; c < 3; ++c)
    EXPECT_EQ(sampled_value(s, SampleField::velocity, c),
              (Vec3<double>{3, 0, -4}.x * (c == 0)) - 4.0 * (c == 2));
}

TEST(Sampling, LevelIsTheHighestFallThroughZero) {
  const auto level = [](std::vector<double> g) {
    return level_of(g.data(), static_cast<std::uint32_t>(g.size()), 10.0, 2.0);
  };
  EXPECT_EQ(level({1, 1, 0.5, -0.5, -1}), 10 + 2 * 2.5);
  EXPECT_EQ(level({1, 1, -1, 0.25, -0.75}), 10 + 2 * 3.25) << "the highest of two";
  EXPECT_EQ(level({-1, -1, 3, -1}), 10 + 2 * 2.75) << "liquid above nothing";
  EXPECT_EQ(level({-1, 1, 1}), 14) << "up to the end of the line";
  EXPECT_TRUE(std::isnan(level({-1, 0, -0.5})));
  EXPECT_TRUE(std::isnan(level({})));
}

/// g at height y near a lattice of liquid up to y = 0: in the open, on a wall, or beside a solid in x < 0 that goes on above.
double excess_at(double support, double y, bool solid, bool walled) {
  const auto k = make_kernel<double>(support, 1);
  WallBox<double> box;
  box.support = support;
  box.min = {0, -100, -100};
  box.max = {100, 100, 100};
  box.faces = walled ? 1u : 0u;
  const Vec3<double> at{solid ? 0.3 : walled ? 0.0 : 50.3, y, 0.1};
  const auto walls = wall_view(box, at);
  FillSums<double> s;
  for (int n = 0; n < 40 * 80 * 120; ++n) {
    const Vec3<double> x{n % 120 - 60 + 0.5, n / 120 % 80 - 40 + 0.5, n / 9600 - 20 + 0.5};
    const bool is_liquid = !(solid && x.x < 0);
    if ((is_liquid && x.y > 0) || (walled && x.x < 0)) continue;
    const Vec3<double> d = at - x;
    const double r2 = dot(d, d);
    if (r2 < k.support2) s.add(k, walls, is_liquid, 1, d, r2);
  }
  return liquid_excess(k, s);
}

// g = 0 on the surface of a lattice, whatever the support, in the open, on a wall and beside a body. Its slope there
// is about 1 per spacing, so 0.06 is less than a tenth of a spacing: twice the ripple of a lattice at 2 spacings, which deep inside
// is 0.05 of f.
TEST(Sampling, ASurfaceIsWhereLiquidFillsHalf) {
  for (const double support : {2.0, 2.5, 3.0, 4.0}) {
    EXPECT_NEAR(excess_at(support, 0, false, false), 0, 0.06) << support;
    EXPECT_NEAR(excess_at(support, 0, false, true), 0, 0.06) << support;
    EXPECT_NEAR(excess_at(support, 0, true, false), 0, 0.06) << support;
    EXPECT_NEAR(excess_at(support, -support, false, false), 1, 0.11) << support;
    EXPECT_NEAR(excess_at(support, -support, false, true), 1, 0.11) << support;
    EXPECT_GT(excess_at(support, -support, true, false), 0.3) << support;
    EXPECT_NEAR(excess_at(support, support, false, false), -1, 1e-12) << support;
  }
}

}  // namespace
