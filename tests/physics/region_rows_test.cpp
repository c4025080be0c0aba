// SPDX-License-Identifier: Apache-2.0
// Whole regions as planes of rows: the same sums as over their members, the same goals as from their regions.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "meltsim/physics/shape_matching.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double dx = 0.2;

/// The box of half-width w around a vertex: members a fifth of a spacing off their place in a turned lattice,
/// of masses that differ by a factor of ten, moving at random. As the library has them: rounded.
template <class T>
struct Box {
  int w;
  std::vector<Vec3<T>> x, v;
  std::vector<T> mass;
  std::vector<RegionFit<T>> fit;  ///< of each of them as a region's vertex

  Box(int half_width, Random& random) : w(half_width) {
    const Mat3<double> turn = to_matrix(random.rotation());
    const Vec3<double> offset = random.vector(2);
    for (int dz = -w; dz <= w; ++dz)
      for (int dy = -w; dy <= w; ++dy)
        for (int k = -w; k <= w; ++k) {
          const Vec3<double> q = Vec3<double>{double(k), double(dy), double(dz)} * dx;
          x.push_back(cast<T>(turn * q + random.vector(0.2 * dx) + offset));
          v.push_back(cast<T>(random.vector(3)));
          mass.push_back(static_cast<T>(random.uniform(1, 10)));
          const Quat<double> r = random.rotation();
          fit.push_back({{static_cast<T>(r.w), static_cast<T>(r.x), static_cast<T>(r.y), static_cast<T>(r.z)},
                         cast<T>(random.vector(0.3 * dx)),
                         cast<T>(random.vector(3)),
                         cast<T>(random.vector(5))});
        }
  }
  std::size_t at(int dx_, int dy, int dz) const {
    const int side = 2 * w + 1;
    return static_cast<std::size_t>(dx_ + w + side * (dy + w + side * (dz + w)));
  }
  std::size_t center() const { return at(0, 0, 0); }
  Vec3<double> rest(std::size_t j) const {
    const int side = 2 * w + 1, k = static_cast<int>(j);
    return Vec3<double>{double(k % side - w), double(k / side % side - w), double(k / side / side - w)} * dx;
  }
  Vec3<double> place(std::size_t j) const { return cast<double>(x[j]) - cast<double>(x[center()]); }
  /// What rounding may come to at worst, as a share of the sum of magnitudes: a term passes through 2w+1
  /// additions in its row, as many of rows and of planes, and some twenty roundings on the way. A wrong term is 1e-3 or more.
  double rounding() const {
    const int side = 2 * w + 1;
    return (3 * side + 20) * static_cast<double>(std::numeric_limits<T>::epsilon());
  }
};

template <class T>
class RegionRows : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(RegionRows, Scalars);

/// scale: the sum of magnitudes that b is made of, or more.
void expect_near(Vec3<double> a, Vec3<double> b, double scale, double share, const char* what) {
  EXPECT_LE(length(a - b), share * scale) << what;
}

TYPED_TEST(RegionRows, SumsEqualSumsOverMembers) {
  using T = TypeParam;
  Random random(61);
  for (const int w : {1, 2, 3, 8})
    for (int n = 0; n < (w == 8 ? 1 : 5); ++n) {
      SCOPED_TRACE("w " + std::to_string(w));
      const Box<T> box(w, random);
      const auto step = [](int k) { return static_cast<T>(k * dx); };
      const std::size_t c = box.center();
      BoxSums<T, 3> whole;
      for (int dz = -w; dz <= w; ++dz) {
        const std::size_t p = box.at(0, 0, dz);
        BoxSums<T, 2> plane;
        for (int dy = -w; dy <= w; ++dy) {
          const std::size_t r = box.at(0, dy, dz);
          BoxSums<T, 1> row;
          for (int k = -w; k <= w; ++k) {
            const std::size_t j = box.at(k, dy, dz);
            add_member<T>(row, box.mass[j], box.x[j] - box.x[r], step(k), box.v[j] - box.v[r]);
          }
          add_box<T, 1>(plane, row, box.x[r] - box.x[p], step(dy), box.v[r] - box.v[p]);
        }
        add_box<T, 2>(whole, plane, box.x[p] - box.x[c], step(dz), box.v[p] - box.v[c]);
      }
      const RegionSums<T> sums = region_of(whole);
      // As the symbols say, in double.
      double mass = 0, far = 0, fast = 0;
      Vec3<double> mu{}, mq{}, mv{}, muxv{};
      Mat3<double> muq, muu;
      for (std::size_t j = 0; j < box.x.size(); ++j) {
        const double m = static_cast<double>(box.mass[j]);
        const Vec3<double> u = box.place(j), q = box.rest(j);
        const Vec3<double> v = cast<double>(box.v[j]) - cast<double>(box.v[box.center()]);
        far = std::max({far, length(u), length(q)});
        fast = std::max(fast, length(v));
        mass += m;
        mu += u * m;
        mq += q * m;
        mv += v * m;
        muxv += cross(u, v) * m;
        add_outer(muq, m, u, q);
        add_outer(muu, m, u, u);
      }
      const double share = box.rounding();
      EXPECT_NEAR(static_cast<double>(sums.mass), mass, share * mass);
      expect_near(cast<double>(sums.mu), mu, mass * far, share, "mu");
      expect_near(cast<double>(sums.mq), mq, mass * far, share, "mq");
      expect_near(cast<double>(sums.mv), mv, mass * fast, share, "mv");
      expect_near(cast<double>(sums.muxv), muxv, mass * far * fast, share, "muxv");
      const Mat3<T> second = to_matrix(sums.muu);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          EXPECT_NEAR(static_cast<double>(sums.muq.m[i][j]), muq.m[i][j], share * mass * far * far) << i << j;
          EXPECT_NEAR(static_cast<double>(second.m[i][j]), muu.m[i][j], share * mass * far * far) << i << j;
        }
    }
}

// Fits that have nothing to do with each other: no term can hide behind another.
TYPED_TEST(RegionRows, GoalsEqualThoseOfEveryRegion) {
  using T = TypeParam;
  Random random(62);
  for (const int w : {1, 2, 3, 8})
    for (int n = 0; n < (w == 8 ? 1 : 5); ++n) {
      SCOPED_TRACE("w " + std::to_string(w));
      const Box<T> box(w, random);
      const std::size_t i = box.center();
      const T count = static_cast<T>(2 * w + 1);
      const auto step = [](int k) { return static_cast<T>(-k * dx); };
      BoxGoals<T, 3> whole;
      for (int dz = -w; dz <= w; ++dz) {
        const std::size_t p = box.at(0, 0, dz);
        BoxGoals<T, 2> plane;
        for (int dy = -w; dy <= w; ++dy) {
          const std::size_t c = box.at(0, dy, dz);
          BoxGoals<T, 1> row;
          for (int k = -w; k <= w; ++k) {
            const std::size_t r = box.at(k, dy, dz);
            add_goals<T, 0>(row, goals_of(box.fit[r]), T(1), step(k), box.x[c] - box.x[r]);
          }
          add_goals<T, 1>(plane, row, count, step(dy), box.x[p] - box.x[c]);
        }
        add_goals<T, 2>(whole, plane, count * count, step(dz), box.x[i] - box.x[p]);
      }
      const Vec3<T> displacement = whole.displacement,
                    defect = whole.velocity - box.v[i] * (count * count * count);
      Vec3<double> wanted{}, missing{};
      double far = 0, fast = 0;
      for (std::size_t r = 0; r < box.x.size(); ++r) {
        const RegionFit<T>& f = box.fit[r];
        const Quat<double> turn{static_cast<double>(f.rotation.w), static_cast<double>(f.rotation.x),
                                static_cast<double>(f.rotation.y), static_cast<double>(f.rotation.z)};
        const Vec3<double> q = box.rest(r) * -1.0, u = box.place(r) * -1.0;
        wanted += rotate(turn, q) + cast<double>(f.anchor) - u;
        missing += cast<double>(f.velocity) + cross(cast<double>(f.spin), u) - cast<double>(box.v[i]);
        far += length(q) + length(cast<double>(f.anchor)) + length(u);
        fast += length(cast<double>(f.velocity)) + length(cast<double>(f.spin)) * length(u) +
                length(cast<double>(box.v[i]));
      }
      expect_near(cast<double>(displacement), wanted, far, box.rounding(), "displacement");
      expect_near(cast<double>(defect), missing, fast, box.rounding(), "defect");
    }
}

TEST(Symmetric, SquaresAreOuterProducts) {
  Random random(63);
  Sym3<double> packed;
  Mat3<double> full;
  for (int n = 0; n < 5; ++n) {
    const Vec3<double> a = random.vector(1);
    const double s = random.uniform(-1, 1);
    add_square(packed, s, a);
    add_outer(full, s, a, a);
  }
  const Mat3<double> m = to_matrix(packed);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(m.m[i][j], full.m[i][j], 1e-15);
}

}  // namespace
