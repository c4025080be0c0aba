// SPDX-License-Identifier: Apache-2.0
// Shape matching as a whole step: bodies that are turned and far away stay exactly where they are.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine.hpp"
#include "support/random.hpp"

namespace modules_test {
namespace {

template <class T>
class ShapeMatching : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(ShapeMatching, Scalars);

/// A body turned about its first particle and moved, at rest; regions still hold the rotation of the start.
template <class T>
double moved_in_a_step(const std::vector<Vec3i>& points, int half_width, const Quat<double>& rotation,
                       Vec3d offset) {
  core::SceneConstants c = plain_constants(0.2);
  c.materials[1].shape_stiffness = 1;
  c.materials[1].shape_damping = 0.1;
  core::SceneLattice l;
  core::SceneState s;
  add_body(l, s, c, points, half_width);
  const Mat3<double> r = to_matrix(rotation);
  const Vec3d first = s.position[0];
  for (Vec3d& x : s.position) {
    x = r * (x - first) + offset;
    x = cast<double>(cast<T>(x));  // as it is stored
  }
  const std::vector<Vec3d> before = s.position;
  Rig<T> rig;
  rig.upload(c, l, s, core::fact_particles | core::fact_solid | core::fact_mobile | core::fact_lattice);
  rig.run({"spatial", "lsm.gather", "lsm.loads", "lsm.regions", "lsm.goals", "lsm.balance", "step"}, 1e-3);
  core::SceneState after = s;
  rig.engine->download(after);
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3d d = after.position[i] - before[i];
    most = std::max({most, std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
  }
  return most;
}

// Any rotation, half turns among them (the warm start is then as wrong as can be), at 0, 10 and 100 m:
// max(1e-5 dx, 4 ulp) in single precision, 1e-11 dx in double, per coordinate.
TYPED_TEST(ShapeMatching, TurnedBodiesStayWhereTheyAre) {
  using T = TypeParam;
  test_support::Random random(91);
  const Quat<double> turns[] = {{1, 0, 0, 0},     {0, 1, 0, 0},      {0, 0, 1, 0},
                                {0, 0.6, 0, 0.8}, random.rotation(), random.rotation()};
  for (const double far : {0.0, 10.0, 100.0})
    for (const Quat<double>& turn : turns)
      for (const int w : {1, 2, 3}) {
        const T reach = static_cast<T>(far + 1);
        const double ulp = static_cast<double>(std::nextafter(reach, 2 * reach) - reach);
        const double tolerance = std::max((sizeof(T) == 8 ? 1e-11 : 1e-5) * 0.2, 4 * ulp);
        ASSERT_LE(moved_in_a_step<T>(block(4, 3, 5), w, turn, {far, -far, far}), tolerance)
            << far << " m, w " << w << ", turn " << turn.w << " " << turn.x << " " << turn.y << " " << turn.z;
      }
}

// The same of bodies that are wide enough for whole regions, which go by rows.
TYPED_TEST(ShapeMatching, TurnedBodiesWithWholeRegionsStayWhereTheyAre) {
  using T = TypeParam;
  test_support::Random random(93);
  for (const double far : {0.0, 100.0})
    for (const int w : {2, 3}) {
      const T reach = static_cast<T>(far + 1);
      const double ulp = static_cast<double>(std::nextafter(reach, 2 * reach) - reach);
      const double tolerance = std::max((sizeof(T) == 8 ? 1e-11 : 1e-5) * 0.2, 4 * ulp);
      for (const Quat<double>& turn : {Quat<double>{0, 0, 0.6, 0.8}, random.rotation()})
        ASSERT_LE(moved_in_a_step<T>(block(8, 8, 7), w, turn, {far, -far, far}), tolerance)
            << far << " m, w " << w << ", turn " << turn.w << " " << turn.x << " " << turn.y << " " << turn.z;
    }
}

// A rod, a sheet and a single particle, whose rotation is not determined.
TYPED_TEST(ShapeMatching, ThinBodiesStayWhereTheyAre) {
  using T = TypeParam;
  test_support::Random random(92);
  for (const auto& points : {block(6, 1, 1), block(4, 1, 4), block(1, 1, 1), block(2, 1, 1)})
    for (int n = 0; n < 4; ++n) {
      const double moved = moved_in_a_step<T>(points, 2, random.rotation(), {1, 1, 1});
      ASSERT_LE(moved, (sizeof(T) == 8 ? 1e-11 : 1e-5) * 0.2) << points.size();
    }
}

}  // namespace
}  // namespace modules_test
