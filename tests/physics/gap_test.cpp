// SPDX-License-Identifier: Apache-2.0
#include "meltsim/physics/gap.hpp"

#include <gtest/gtest.h>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double dx = 0.1;

/// Sums of the particle at the origin, in the outermost layer of a half-space y >= 0 of solid, over a lattice: its own piece there, and
/// what `below` gives it below the plane y = -dx/2, `apart` spacings from it.
template <class Below>
GapSums<double> beside_plane(const SphKernel<double>& k, double apart, const Below& below) {
  GapSums<double> s;
  const WallView<double> walls{};
  const double volumes = std::pow(dx, 6);
  for (int x = -6; x <= 6; ++x)
    for (int z = -6; z <= 6; ++z)
      for (int y = -6; y <= 6; ++y) {
        const bool own = y >= 0;
        const Vec3<double> at{x * dx, own ? y * dx : (y + 1 - apart) * dx, z * dx};
        const double r2 = dot(at, at);
        if (!(r2 > 0) || !(r2 < k.support2)) continue;
        GapNeighbour<double> j;
        if (own) j.solid = j.own = true;
        else j = below(y, at);
        s.add(k, walls, j, volumes, -at, r2);
      }
  return s;
}

GapNeighbour<double> other_body(int y, const Vec3<double>&) {
  GapNeighbour<double> j;
  j.solid = true;
  j.faces = y == -1;
  return j;
}

// A body on a body, both wide: the gap presses with its pressure on every site's side, dx^2, whatever the support is. The pairs of a
// lattice press with 1.00 of it within 1 % for supports of 2.2 spacings and more: so far is a lattice from a continuum.
TEST(Gap, PressesOnTheWholeSide) {
  for (const double support : {2.2, 2.5, 3.0, 3.5}) {
    const auto k = make_kernel<double>(support * dx, dx);
    for (const double apart : {1.0, 1.3, 1.6}) {
      const auto s = beside_plane(k, apart, other_body);
      const auto face = gap_face(s, dx, gap_scale(k, dx));
      // From this pressure, and from a rim of that area, which asks for it.
      const double push = gap_pressure(face.side, face.filled, 1.0, 700.0, 0.0, 0.0);
      EXPECT_NEAR(push * length(s.facing), 700 * dx * dx, 0.01 * 700 * dx * dx) << support << ", " << apart;
    }
  }
}

// Where liquid is in place of the other body, nothing is asked for.
TEST(Gap, LeavesToLiquidWhatItFills) {
  const auto k = make_kernel<double>(2.5 * dx, dx);
  const auto s = beside_plane(k, 1, [](int y, const Vec3<double>&) {
    GapNeighbour<double> j;
    j.pressure = j.level = 700;
    if (y < -1) j = other_body(-1, {});
    return j;
  });
  EXPECT_GT(length(s.facing), 0);
  const auto face = gap_face(s, dx, gap_scale(k, dx));
  EXPECT_EQ(face.side, 0);
  EXPECT_EQ(face.filled, 0);
}

// Beyond reach, and with no other body about, nothing is asked for, and no rim is counted.
TEST(Gap, EndsWhereLiquidCanEnter) {
  const auto k = make_kernel<double>(2.5 * dx, dx);
  for (const double apart : {1.9, 2.2, 5.0}) {
    const auto face = gap_face(beside_plane(k, apart, other_body), dx, gap_scale(k, dx));
    EXPECT_EQ(face.side, 0) << apart;
    EXPECT_EQ(face.area, 0) << apart;
  }
}

// Pressure rises by rho g with depth, and does not become negative; what presses already is taken off.
TEST(Gap, PressureHasItsHeight) {
  EXPECT_DOUBLE_EQ(gap_pressure(1.0, 0.0, 2.0, 200.0, 2 * 9810.0, 0.1), 100 + 981);
  EXPECT_EQ(gap_pressure(1.0, 0.0, 2.0, 200.0, 2 * 9810.0, -0.1), 0);
  EXPECT_DOUBLE_EQ(gap_pressure(2.0, 50.0, 2.0, 200.0, 0.0, 0.0), 150);
  EXPECT_EQ(gap_pressure(1.0, 0.0, 0.0, 200.0, 0.0, 0.0), 0);
}

// Layers apart by s spacings have s pairs: c is 1 where only neighbouring layers meet, and grows with the support.
TEST(Gap, ScaleCountsPairsOfLayers) {
  EXPECT_EQ(gap_scale(make_kernel<double>(1.9 * dx, dx), dx), 1);
  const double two = gap_scale(make_kernel<double>(2.5 * dx, dx), dx),
               three = gap_scale(make_kernel<double>(3.5 * dx, dx), dx);
  EXPECT_GT(two, 1);
  EXPECT_GT(three, two);
}

// Who sees more has more of a say; who asks for nothing, because no force moves it, has none.
TEST(Gap, BothSidesHaveTheirSay) {
  EXPECT_DOUBLE_EQ(gap_pair_pressure(100.0, 1.0, 300.0, 3.0), 250);
  EXPECT_DOUBLE_EQ(gap_pair_pressure(100.0, 0.2, 0.0, 0.0), 100);
  EXPECT_EQ(gap_pair_pressure(0.0, 0.0, 0.0, 0.0), 0);
}

TEST(Gap, ForceIsOddToTheBit) {
  test_support::Random random(81);
  const auto k = make_kernel<float>(0.25, 0.1);
  for (int n = 0; n < 1000; ++n) {
    const auto x = cast<float>(random.vector(0.1));
    const auto p = static_cast<float>(random.uniform(0, 1e4));
    const auto f = gap_pair_force(k, p, 1e-6f, x, dot(x, x)),
               back = gap_pair_force(k, p, 1e-6f, -x, dot(x, x));
    ASSERT_TRUE(f.x == -back.x && f.y == -back.y && f.z == -back.z);
    ASSERT_GE(dot(f, x), 0.0f);
  }
}

}  // namespace
