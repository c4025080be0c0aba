// SPDX-License-Identifier: Apache-2.0
// The best rotation, against Kabsch's by Eigen's singular values in double. Scales 1, 1e-4 and 1e-7 m: A goes
// with their square. Single precision is held to 1e-5: rounding of A, 6e-8, over the eigenvalue gaps of small
// sets; double to 1e-10.
#include "meltsim/physics/polar.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;
using Points = std::vector<Vec3<double>>;

constexpr double pi = 3.14159265358979323846;

Quat<double> turn(Vec3<double> axis, double angle) {
  const Vec3<double> n = axis * (std::sin(0.5 * angle) / length(axis));
  return {std::cos(0.5 * angle), n.x, n.y, n.z};
}

Points rotated(const Quat<double>& q, const Points& rest) {
  Points p;
  for (const auto& y : rest) p.push_back(to_matrix(q) * y);
  return p;
}

/// A = sum x y^T about the centres.
Mat3<double> moment(const Points& x, const Points& y) {
  Vec3<double> cx{}, cy{};
  const double share = 1.0 / static_cast<double>(x.size());
  for (const auto& p : x) cx += p * share;
  for (const auto& p : y) cy += p * share;
  Mat3<double> a;
  for (std::size_t i = 0; i < x.size(); ++i) add_outer(a, 1.0, x[i] - cx, y[i] - cy);
  return a;
}

template <class T, class S>
Mat3<T> rounded(const Mat3<S>& a) {
  Mat3<T> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.m[i][j] = static_cast<T>(a.m[i][j]);
  return r;
}

Eigen::Matrix3d to_eigen(const Mat3<double>& a) {
  Eigen::Matrix3d e;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) e(i, j) = a.m[i][j];
  return e;
}

/// Largest trace(R^T A) over proper rotations, and one R that has it.
double kabsch(const Eigen::Matrix3d& a, Eigen::Matrix3d& r) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d d = Eigen::Matrix3d::Identity();
  d(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  r = svd.matrixU() * d * svd.matrixV().transpose();
  return svd.singularValues().dot(d.diagonal());
}

template <class T>
class Polar : public testing::Test {
 protected:
  static constexpr double tolerance = sizeof(T) == 8 ? 1e-10 : 1e-5;

  /// Checks everything that holds for any set and returns the rotation.
  static Quat<double> fit(const std::string& what, const Points& x, const Points& y,
                          const Quat<double>& previous = {}) {
    Quat<double> last;
    for (const double scale : {1.0, 1e-4, 1e-7}) {
      SCOPED_TRACE(what + " at scale " + std::to_string(scale));
      Mat3<double> a = moment(x, y);
      for (auto& row : a.m)
        for (double& v : row) v *= scale * scale;
      const Mat3<T> given = rounded<T>(a);
      const Quat<T> q = best_rotation(given, Quat<T>{static_cast<T>(previous.w), static_cast<T>(previous.x),
                                                     static_cast<T>(previous.y), static_cast<T>(previous.z)});
      last = {double(q.w), double(q.x), double(q.y), double(q.z)};
      const Eigen::Matrix3d r = to_eigen(to_matrix(last));
      EXPECT_TRUE(r.allFinite());
      EXPECT_LE((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), tolerance);
      EXPECT_NEAR(r.determinant(), 1.0, tolerance);
      const Eigen::Matrix3d e = to_eigen(rounded<double>(given));  // what the library was given
      Eigen::Matrix3d oracle;
      const double best = kabsch(e, oracle);
      EXPECT_NEAR((r.transpose() * e).trace(), best, tolerance * e.norm());
    }
    return last;
  }
  /// q and -q are the same rotation.
  static void same(const Quat<double>& a, const Quat<double>& b) {
    const double sign = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -1 : 1;
    const double w = a.w - sign * b.w, x = a.x - sign * b.x, y = a.y - sign * b.y, z = a.z - sign * b.z;
    EXPECT_LE(std::sqrt(w * w + x * x + y * y + z * z), tolerance);
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Polar, Scalars);

Points random_points(Random& random, int n) {
  Points p;
  for (int i = 0; i < n; ++i) p.push_back(random.vector(1));
  return p;
}

// Noise of half the size: the best rotation is then no longer the one applied, only Kabsch's.
TYPED_TEST(Polar, EqualsKabschOnRandomSets) {
  Random random(41);
  for (int n = 0; n < 200; ++n) {
    const Points y = random_points(random, 4 + n % 20);
    Points x = rotated(random.rotation(), y);
    for (auto& p : x) p += random.vector(0.5);
    this->fit("random set " + std::to_string(n), x, y, random.rotation());
  }
}

TYPED_TEST(Polar, ReturnsTheRotationApplied) {
  Random random(42);
  for (int n = 0; n < 200; ++n) {
    const Points y = random_points(random, 20);
    const Quat<double> q = random.rotation();
    this->same(this->fit("rotated", rotated(q, y), y), q);
  }
}

// From the identity as previous rotation: where iterations stand still.
TYPED_TEST(Polar, HalfTurns) {
  Random random(43);
  const Points y = random_points(random, 20);
  for (const Vec3<double>& axis :
       {Vec3<double>{1, 0, 0}, Vec3<double>{0, 1, 0}, Vec3<double>{0, 0, 1}, Vec3<double>{1, -2, 0.5}}) {
    const Quat<double> q = turn(axis, pi);
    this->same(this->fit("half turn", rotated(q, y), y), q);
    Points cube;
    for (int i = 0; i < 27; ++i) cube.push_back({i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0});
    this->same(this->fit("half turn of a cube", rotated(q, cube), cube), q);
  }
}

TYPED_TEST(Polar, FewAndFlatSets) {
  Random random(44);
  const Points single{{0.3, 0.2, 0.1}}, two{{0, 0, 0}, {1, 0, 0}}, chain{{0, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  const Points sheet{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}},
      skew{{0, 0, 0}, {1, 0, 0}, {0.3, 0, 1}, {2, 0, 1}};
  for (int n = 0; n < 50; ++n) {
    const Quat<double> q = random.rotation(), previous = random.rotation();
    this->fit("single", rotated(q, single), single, previous);
    this->fit("two", rotated(q, two), two, previous);
    this->fit("chain", rotated(q, chain), chain, previous);
    this->same(this->fit("sheet", rotated(q, sheet), sheet, previous), q);  // a plane fixes the rotation
    this->same(this->fit("skew sheet", rotated(q, skew), skew, previous), q);
    for (const Points* y : {&two, &chain}) {
      const Points x = rotated(q, *y);
      const Mat3<double> r = to_matrix(this->fit("line", x, *y, previous));
      const Vec3<double> got = r * (y->back() - y->front()), wanted = x.back() - x.front();
      EXPECT_LE(length(got - wanted), 10 * this->tolerance * length(wanted));
    }
  }
}

TYPED_TEST(Polar, CoincidentAndInverted) {
  Random random(45);
  const Points y = random_points(random, 20);
  const Quat<double> previous = random.rotation();
  this->same(this->fit("coincident", Points(20), y, previous), previous);
  Points mirrored = y, inverted = y;
  for (auto& p : mirrored) p.x = -p.x;
  for (auto& p : inverted) p = -p;
  this->fit("mirrored", mirrored, y, previous);
  this->fit("inverted", inverted, y, previous);
  Points cube;
  for (int i = 0; i < 27; ++i) cube.push_back({i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0});
  Points inverted_cube = cube;
  for (auto& p : inverted_cube) p = -p;
  this->fit("inverted cube: a whole sphere of best rotations", inverted_cube, cube, previous);
}

// The twist of a chain is seen by nobody: it stays, along any direction; there the equal eigenvalues differ
// by rounding.
TYPED_TEST(Polar, KeepsWhatCannotBeObserved) {
  Random random(47);
  const Points chain{{0, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  for (int n = 0; n < 50; ++n) {
    const Quat<double> q = n == 0 ? Quat<double>{} : random.rotation();
    for (const double angle : {0.0, 0.7, -2.5, 3.0}) {
      const Quat<double> t = turn(to_matrix(q) * Vec3<double>{0, 1, 0}, angle);
      const Vec3<double> a{t.x, t.y, t.z}, b{q.x, q.y, q.z}, v = b * t.w + a * q.w + cross(a, b);
      const Quat<double> previous{t.w * q.w - dot(a, b), v.x, v.y, v.z};  // t after q
      this->same(this->fit("twisted chain", rotated(q, chain), chain, previous), previous);
    }
  }
  const Quat<double> previous = turn({1, 2, 3}, 1.0);
  this->same(this->fit("single", Points{{1, 2, 3}}, Points{{4, 5, 6}}, previous), previous);
}

TYPED_TEST(Polar, NonFiniteGivesThePrevious) {
  using T = TypeParam;
  Mat3<T> a;
  a.m[0][0] = std::numeric_limits<T>::infinity();
  const Quat<T> previous{T(0.5), T(0.5), T(0.5), T(0.5)};
  EXPECT_EQ(best_rotation(a, previous).w, T(0.5));
}

// Angular velocity from angular momentum, also where some inertia is missing; scales of mass and length as a
// lattice of dx = scale and density 1000 has them.
TYPED_TEST(Polar, SolvesSymmetricSystemsAtAnyScale) {
  using T = TypeParam;
  Random random(46);
  for (const double size : {1.0, 1e-12, 1e-32}) {
    for (int n = 0; n < 50; ++n) {
      const Eigen::Matrix3d b = Eigen::Matrix3d::Random();
      const Eigen::Matrix3d s = size * (b * b.transpose() + 0.3 * Eigen::Matrix3d::Identity());
      const Vec3<double> x = random.vector(2);
      const Eigen::Vector3d rhs = s * Eigen::Vector3d(x.x, x.y, x.z);
      Mat3<T> given;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) given.m[i][j] = static_cast<T>(s(i, j));
      const Vec3<T> got = solve_symmetric(given, cast<T>(Vec3<double>{rhs[0], rhs[1], rhs[2]}));
      // Condition up to 30: ten times the tolerance.
      ASSERT_LE(length(cast<double>(got) - x), 10 * this->tolerance * length(x)) << "size " << size;
    }
  }
  Mat3<T> rod;  // no inertia about x
  rod.m[1][1] = rod.m[2][2] = T(2);
  const Vec3<T> spin = solve_symmetric(rod, Vec3<T>{T(5), T(4), T(2)});
  EXPECT_EQ(spin.x, T(0));
  EXPECT_NEAR(double(spin.y), 2.0, 1e-6);
  EXPECT_TRUE(finite(solve_symmetric(Mat3<T>{}, Vec3<T>{T(1), T(1), T(1)})));
}

// Newton's method says that it has the best rotation only where it has, whatever it is given and wherever it starts;
// and it has it where it is meant to: a full set of points, turned by what a sub-step turns by.
TYPED_TEST(Polar, NewtonIsRightOrSaysThatItIsNot) {
  using T = TypeParam;
  Random random(47);
  int answered = 0, refused = 0;
  for (int n = 0; n < 10000; ++n) {
    Mat3<double> a;
    for (auto& row : a.m)
      for (double& v : row) v = random.vector(1).x;
    if (n % 4 == 0)  // flat
      for (int i = 0; i < 3; ++i) a.m[i][2] = 1e-3 * (n % 3) * a.m[i][1];
    const Vec3<double> axis = random.vector(1);
    const Quat<double> start = turn(axis, n % 5);
    Quat<T> q{T(start.w), T(start.x), T(start.y), T(start.z)};
    const Mat3<T> given = rounded<T>(a);
    if (!turned_rotation(given, q)) {
      ++refused;
      continue;
    }
    ++answered;
    const Eigen::Matrix3d r =
        to_eigen(to_matrix(Quat<double>{double(q.w), double(q.x), double(q.y), double(q.z)}));
    const Eigen::Matrix3d e = to_eigen(rounded<double>(given));
    Eigen::Matrix3d oracle;
    ASSERT_NEAR((r.transpose() * e).trace(), kabsch(e, oracle), this->tolerance * e.norm()) << n;
  }
  EXPECT_GT(answered, 100);
  EXPECT_GT(refused, 100);
  for (int n = 0; n < 200; ++n) {
    const Points rest = random_points(random, 27);
    const Vec3<double> axis = random.vector(1);
    const Quat<double> now = turn(axis, n * 0.1), before = turn(axis, n * 0.1 - 0.05);
    Quat<T> q{T(before.w), T(before.x), T(before.y), T(before.z)};
    ASSERT_TRUE(turned_rotation(rounded<T>(moment(rotated(now, rest), rest)), q)) << n;
    this->same({double(q.w), double(q.x), double(q.y), double(q.z)}, now);
  }
}

TYPED_TEST(Polar, CofactorsRefuseWhatIsNotDefinite) {
  using T = TypeParam;
  const auto solves = [](T x, T y, T z) {
    Mat3<T> s;
    s.m[0][0] = x;
    s.m[1][1] = y;
    s.m[2][2] = z;
    Vec3<T> unused;
    return solve_definite(s, Vec3<T>{T(1), T(1), T(1)}, unused);
  };
  EXPECT_TRUE(solves(T(1), T(2), T(3)));
  EXPECT_FALSE(solves(T(0), T(2), T(2)));    // a rod
  EXPECT_FALSE(solves(T(-1), T(-1), T(9)));  // determinants above zero
  EXPECT_FALSE(solves(T(9), T(-1), T(-1)));
  EXPECT_FALSE(solves(std::numeric_limits<T>::quiet_NaN(), T(1), T(1)));
}

}  // namespace
