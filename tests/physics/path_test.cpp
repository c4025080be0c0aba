// SPDX-License-Identifier: Apache-2.0
#include "meltsim/physics/path.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace meltsim {
namespace {

using physics::displacement_at;
using physics::for_each_place;

// Rests at the origin until 1 s, goes 4 m along x in 2 s, 3 m along y in 1 s, and rests.
const std::vector<PathPoint> path{{1, {0, 0, 0}}, {3, {4, 0, 0}}, {4, {4, 3, 0}}};
Vec3d at(double t) { return displacement_at(path.data(), 3, t); }

// Numbers that a double has.
TEST(Path, IsStraightFromPointToPointAndRestsBeforeAndAfter) {
  for (const double t : {-1e300, 0.0, 1.0}) EXPECT_EQ(at(t).x, 0) << t;
  EXPECT_EQ(at(1.5).x, 1);
  EXPECT_EQ(at(3).x, 4);
  EXPECT_EQ(at(3).y, 0);
  EXPECT_EQ(at(3.5).y, 1.5);
  EXPECT_EQ(at(3.5).x, 4);
  for (const double t : {4.0, 5.0, 1e300}) EXPECT_EQ(at(t).y, 3) << t;
  const PathPoint one{2, {7, 0, 0}};
  for (const double t : {1.0, 2.0, 3.0}) EXPECT_EQ(displacement_at(&one, 1, t).x, 7);
}

struct Seen {
  double share = 0, x = 0, y = 0, apart = 0;
  int places = 0;
};
Seen seen(double from, double until, double apart) {
  Seen s;
  Vec3d last;
  for_each_place(path.data(), 3, from, until, apart, [&](const Vec3d& d, double share) {
    if (s.places++ > 0) s.apart = std::max(s.apart, length(d - last));
    last = d;
    s.share += share;
    s.x += d.x * share;
    s.y += d.y * share;
  });
  return s;
}

// The mean place of a step: integrals of straight lines, which the midpoint rule has exactly (1e-12 of rounding).
TEST(Path, PlacesOfAStepStandForTheirShareOfItsTime) {
  for (const double apart : {0.01, 0.3, 100.0}) {
    const Seen all = seen(0, 6, apart);
    EXPECT_NEAR(all.share, 1, 1e-12);
    EXPECT_NEAR(all.x, (0 * 1 + 2 * 2 + 4 * 1 + 4 * 2) / 6.0, 1e-12);
    EXPECT_NEAR(all.y, (1.5 * 1 + 3 * 2) / 6.0, 1e-12);
    if (apart < 1) {
      EXPECT_LE(
          all.apart,
          apart * (1 + 1e-9));  // also from the middle of one part's last place to the next part's first
    }
    const Seen part = seen(1.5, 3.5, apart);
    EXPECT_NEAR(part.share, 1, 1e-12);
    EXPECT_NEAR(part.x, (2.5 * 1.5 + 4 * 0.5) / 2, 1e-12);
    EXPECT_NEAR(part.y, 0.75 * 0.5 / 2, 1e-12);
  }
  EXPECT_EQ(seen(4.5, 5, 0.1).places, 1);  // at rest
  EXPECT_EQ(seen(0, 0.5, 0.1).places, 1);
  EXPECT_EQ(seen(1, 3, 1).places, 4);
  EXPECT_EQ(seen(1, 3, 1e-9).places, static_cast<int>(physics::most_places));
}

// A door that turns by two turns in 4 s while it moves, and rests before and after.
TEST(Path, OfABodyTurnsAtAConstantRate) {
  constexpr double pi = 3.14159265358979323846;
  const PosePoint door[] = {{1, {0, 0, 0}, 0}, {5, {2, 0, 0}, 4 * pi}, {6, {2, 0, 0}, 4 * pi}};
  const auto at = [&](double t) {
    return physics::place_at(physics::motion_on(door, 3, {0, 0, 1}, {5, 0, 0}, t), t);
  };
  for (const double t : {0.0, 1.0}) EXPECT_EQ(at(t).position.x, 5);
  EXPECT_EQ(length(at(0.5).velocity), 0);
  EXPECT_EQ(length(at(0.5).angular_velocity), 0);
  EXPECT_NEAR(at(1).angular_velocity.z, pi, 1e-15);  // from then on
  EXPECT_NEAR(at(2).velocity.x, 0.5, 1e-15);
  EXPECT_NEAR(at(2).position.x, 5.5, 1e-15);
  EXPECT_NEAR(at(1.5).orientation.z, std::sin(pi / 4), 1e-15);  // a quarter turn
  EXPECT_NEAR(at(3.5).orientation.w, std::cos(5 * pi / 4), 1e-14);
  for (const double t : {5.0, 5.5, 6.0, 9.0}) {
    EXPECT_EQ(at(t).position.x, 7) << t;
    EXPECT_EQ(length(at(t).velocity), 0) << t;
    EXPECT_NEAR(at(t).orientation.w, 1, 1e-14) << t;
  }
  // A motion holds beyond the next point, too: a step may end a rounding after it.
  const physics::RigidMotion m = physics::motion_on(door, 3, {0, 0, 1}, {5, 0, 0}, 4.9);
  EXPECT_EQ(physics::place_at(m, 5.5).position.x, 7);
}

}  // namespace
}  // namespace meltsim
