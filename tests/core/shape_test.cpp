// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <new>
#include <numeric>

#include "shape/shape_limits.hpp"
#include "shape/shape_node.hpp"
#include "shape_support.hpp"

namespace shape_tests {
namespace {

using meltsim::Box;
using meltsim::Ellipsoid;

// About 50 sites across a unit: a sampled volume is then good to a per cent and a test takes milliseconds.
constexpr double h = 0.02;

void expect_volume(const Shape& shape, double volume, double area) {
  ASSERT_TRUE(shape.validate()) << shape.validate().error().message;
  EXPECT_NEAR(sampled_volume(shape, h), volume, volume_tolerance(area, h));
}

void expect_refused(const Shape& shape, const std::string& field, const std::string& value) {
  const meltsim::Status s = shape.validate();
  ASSERT_FALSE(s) << field;
  EXPECT_EQ(s.error().code, meltsim::ErrorCode::invalid_argument);
  EXPECT_NE(s.error().message.find(field), std::string::npos) << s.error().message;
  EXPECT_NE(s.error().message.find(value), std::string::npos) << s.error().message;
  EXPECT_TRUE(shape.lattice_points({}, 0.1).empty());
}

/// Sites and bounds belong to the shape, and points outside the bounds do not.
void expect_consistent(const Shape& shape, double spacing) {
  const std::vector<Vec3i> sites = shape.lattice_points(generic_origin, spacing);
  ASSERT_FALSE(sites.empty());
  const Box b = shape.bounds();
  std::size_t next = 0;
  const auto index = [&](double v, double o) { return static_cast<int>(std::floor((v - o) / spacing)); };
  for (int z = index(b.min.z, generic_origin.z) - 3; z < index(b.max.z, generic_origin.z) + 3; ++z)
    for (int y = index(b.min.y, generic_origin.y) - 3; y < index(b.max.y, generic_origin.y) + 3; ++y)
      for (int x = index(b.min.x, generic_origin.x) - 3; x < index(b.max.x, generic_origin.x) + 3; ++x) {
        const Vec3d p = generic_origin + Vec3d{x + 0.5, y + 0.5, z + 0.5} * spacing;
        const bool listed =
            next < sites.size() && sites[next].x == x && sites[next].y == y && sites[next].z == z;
        ASSERT_EQ(shape.contains(p), listed) << p.x << ' ' << p.y << ' ' << p.z;
        if (listed) ++next;
      }
  EXPECT_EQ(next, sites.size()) << "sites out of order or out of bounds";
}

TEST(Shape, EmptyShapeHoldsNothing) {
  const Shape none;
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(none.validate());
  EXPECT_FALSE(none.contains({}));
  EXPECT_GT(none.bounds().min.x, none.bounds().max.x);
  EXPECT_TRUE(none.lattice_points({}, 1).empty());
  EXPECT_TRUE(Shape::unite({}).empty());
  EXPECT_TRUE(Shape::subtract(none, Shape::sphere({}, 1)).empty());
  EXPECT_TRUE(none.transformed({1, 2, 3}).empty());
  EXPECT_FALSE(Shape::subtract(Shape::sphere({}, 1), none).empty());
}

TEST(Shape, SphereVolume) { expect_volume(Shape::sphere({0.1, 0.2, -0.3}, 0.5), pi / 6, pi); }

TEST(Shape, CapsuleVolume) {
  const double l = std::sqrt(0.3 * 0.3 + 0.4 * 0.4 + 0.5 * 0.5), r = 0.3;
  expect_volume(Shape::capsule({0, 0, 0}, {0.3, 0.4, 0.5}, r), pi * r * r * l + 4 * pi / 3 * r * r * r,
                2 * pi * r * l + 4 * pi * r * r);
  expect_volume(Shape::capsule({0, 0, 0}, {0, 0, 0}, r), 4 * pi / 3 * r * r * r, 4 * pi * r * r);
}

TEST(Shape, CylinderVolume) {
  const double l = std::sqrt(0.3 * 0.3 + 0.4 * 0.4 + 0.5 * 0.5), r = 0.3;
  expect_volume(Shape::cylinder({0, 0, 0}, {0.3, 0.4, 0.5}, r), pi * r * r * l, 2 * pi * r * (l + r));
}

TEST(Shape, TorusVolume) {
  expect_volume(Shape::torus({0.1, 0, 0}, {1, 2, 3}, 0.5, 0.2), 2 * pi * pi * 0.5 * 0.2 * 0.2,
                4 * pi * pi * 0.5 * 0.2);
}

TEST(Shape, SharpBlendIsTheUnionOfEllipsoids) {
  // 4 pi (abc) / 3 each, apart from each other; the surface is below that of the sphere of the largest axis.
  const Shape s = Shape::blend({{{0, 0, 0}, {0.5, 0.3, 0.2}}, {{2, 0, 0}, {0.2, 0.3, 0.4}}}, 0);
  expect_volume(s, 4 * pi / 3 * (0.5 * 0.3 * 0.2 + 0.2 * 0.3 * 0.4), 4 * pi * (0.25 + 0.16));
}

TEST(Shape, BlendAddsMaterialOnlyNearTheSeam) {
  const std::vector<Ellipsoid> parts{{{-0.3, 0, 0}, {0.4, 0.4, 0.4}}, {{0.3, 0, 0}, {0.4, 0.4, 0.4}}};
  const Shape sharp = Shape::blend(parts, 0), soft = Shape::blend(parts, 0.2);
  // On the plane of symmetry both distances are d = sqrt(y^2 + 0.3^2) - 0.4 and the smooth one is d - 0.2
  // / 4.
  const double y = std::sqrt(0.45 * 0.45 - 0.3 * 0.3);
  EXPECT_TRUE(soft.contains({0, y - 1e-6, 0}));
  EXPECT_FALSE(soft.contains({0, y + 1e-6, 0}));
  EXPECT_FALSE(sharp.contains({0, y - 1e-6, 0}));
  // Opposite the neighbour the distances differ by 0.6, more than the blend: nothing changes there.
  EXPECT_FALSE(soft.contains({-0.7 - 1e-6, 0, 0}));
  EXPECT_TRUE(soft.contains({-0.7 + 1e-6, 0, 0}));
  EXPECT_TRUE(soft.contains({-0.3, 0, 0})) << "the centre, where the gradient vanishes";
}

TEST(Shape, BoxAlignedWithTheLatticeIsExact) {
  // 0.1 * 3 and its like are not representable; whatever the rounding, n spacings hold n sites per axis, also
  // where the faces run through sites (phase 1/2) and far from the origin.
  for (const double spacing : {0.1, 0.2, 0.3, 1.0 / 3, 0.7e-3})
    for (const double phase : {0.0, 0.5})
      for (const int first : {-7, 0, 3, 100000})
        for (const int n : {1, 2, 3, 7, 11}) {
          const double lo = (first + phase) * spacing, hi = lo + n * spacing;
          const Shape box = Shape::box({lo, 0, 0}, {hi, spacing * 2, spacing});
          const std::vector<Vec3i> sites = box.lattice_points({}, spacing);
          ASSERT_EQ(sites.size(), static_cast<std::size_t>(2 * n)) << spacing << ' ' << first << ' ' << n;
          EXPECT_EQ(sites.front().x, first) << "a site on the lower face is inside, on the upper one outside";
        }
}

TEST(Shape, BoxesThatShareAFaceShareNoSite) {
  const Shape left = Shape::box({0, 0, 0}, {0.35, 1, 1}), right = Shape::box({0.35, 0, 0}, {1, 1, 1});
  EXPECT_EQ(left.lattice_points({}, 0.1).size() + right.lattice_points({}, 0.1).size(), 1000u);
}

TEST(Shape, SitesOnASphereAreInsideOnBothSides) {
  // Centre on a site and a radius of five spacings: (3, 4, 0) and its like lie on the surface.
  const std::vector<Vec3i> sites = Shape::sphere({0.05, 0.05, 0.05}, 0.5).lattice_points({}, 0.1);
  EXPECT_EQ(sites.size(), 515u) << "integer points with x^2 + y^2 + z^2 <= 25 (OEIS A000605)";
}

TEST(Shape, SitesComeXFastestAndMatchContains) {
  // 0.07 leaves ten to twenty sites per axis, enough to meet every kind of face.
  expect_consistent(Shape::box({-0.3, -0.4, 0.1}, {0.5, 0.2, 0.6}), 0.07);
  expect_consistent(Shape::sphere({0.1, 0.2, 0.3}, 0.5), 0.07);
  expect_consistent(Shape::capsule({0, 0, 0}, {0.3, 0.4, 0.5}, 0.3), 0.07);
  expect_consistent(Shape::cylinder({0, 0, 0}, {0.3, 0.4, 0.5}, 0.3), 0.07);
  expect_consistent(Shape::torus({0, 0, 0}, {1, 2, 3}, 0.5, 0.2), 0.07);
  // Three long parts close together bulge farthest, where the bounds are tested most.
  expect_consistent(
      Shape::blend(
          {{{0, 0, 0}, {0.5, 0.2, 0.2}}, {{0, 0.1, 0}, {0.5, 0.2, 0.2}}, {{0, 0, 0.1}, {0.5, 0.2, 0.2}}},
          0.4),
      0.07);
  expect_consistent(Shape::mesh(torus_mesh(0.5, 0.2, 24, 12)), 0.07);
}

TEST(Shape, TransformedShapesMatchContains) {
  const Shape parts =
      Shape::unite({Shape::mesh(torus_mesh(0.5, 0.2, 24, 12)), Shape::cylinder({0, 0, 0}, {0, 0.6, 0.1}, 0.1),
                    Shape::box({0.4, 0, 0}, {0.8, 0.2, 0.3}), Shape::torus({0, 0, 0.3}, {0, 1, 1}, 0.3, 0.1),
                    Shape::blend({{{0, 0, -0.3}, {0.4, 0.2, 0.1}}}, 0)});
  expect_consistent(parts.transformed({1, 2, 3}, {1, -2, 0.5}, 0.7, 1.3), 0.09);
  expect_consistent(
      Shape::unite({parts.transformed({1, 2, 3}, {1, 0, 0}, 0.7), Shape::sphere({1, 2, 3}, 0.2)})
          .transformed({0, 0, 0}, {0, 0, 1}, -0.4, 0.8),
      0.09);
}

TEST(Shape, TransformScalesTurnsAndMoves) {
  const Shape rod = Shape::box({0, -0.1, -0.1}, {1, 0.1, 0.1});
  // A quarter turn about z takes x to y; then twice as large, then up by 10.
  const Shape moved = rod.transformed({0, 0, 10}, {0, 0, 3}, pi / 2, 2);
  EXPECT_TRUE(moved.contains({0, 1.9, 10}));
  EXPECT_FALSE(moved.contains({0, -0.1, 10}));
  EXPECT_FALSE(moved.contains({1.9, 0, 10}));
  // 1e-12 covers a few roundings of numbers around ten.
  EXPECT_NEAR(moved.bounds().max.y, 2, 1e-12);
  EXPECT_NEAR(moved.bounds().min.x, -0.2, 1e-12);
  EXPECT_NEAR(moved.bounds().max.z, 10.2, 1e-12);
  expect_volume(rod.transformed({0.3, 0.1, 0}, {1, 2, 3}, 1.1, 2), 8 * 0.04, 4 * (4 * 0.2 + 2 * 0.04));
}

TEST(Shape, MovesFollowOneAnother) {
  // The point (1, 0, 0) of the ball goes to (2, 0, 0), by a quarter turn about y to (0, 0, -2), doubled to
  // (0, 0, -4), and up to (0, 5, -4).
  const Shape s =
      Shape::sphere({1, 0, 0}, 0.1).transformed({1, 0, 0}).transformed({0, 5, 0}, {0, 1, 0}, pi / 2, 2);
  EXPECT_TRUE(s.contains({0, 5, -4.19}));
  EXPECT_FALSE(s.contains({0, 5, -4.21}));
  expect_consistent(s, 0.07);
}

TEST(Shape, BoundsAreTight) {
  // Across an axis with direction cosine c the disc of a cap reaches r sqrt(1 - c^2): 0.8 and 0.6 of r here.
  // 1e-12 covers roundings of numbers around one.
  const Box c =
      Shape::cylinder({0, 0, 0}, {0.6, 0.8, 0}, 0.5).transformed({0, 0, 1}, {0, 1, 0}, 0, 2).bounds();
  EXPECT_NEAR(c.min.x, -0.8, 1e-12);
  EXPECT_NEAR(c.max.x, 1.2 + 0.8, 1e-12);
  EXPECT_NEAR(c.max.y, 1.6 + 0.6, 1e-12);
  EXPECT_NEAR(c.max.z, 1 + 1, 1e-12);
  const Box t = Shape::torus({0, 0, 0}, {3, 4, 0}, 0.5, 0.1).bounds();
  EXPECT_NEAR(t.max.x, 0.4 + 0.1, 1e-12);
  EXPECT_NEAR(t.max.y, 0.3 + 0.1, 1e-12);
  EXPECT_NEAR(t.max.z, 0.5 + 0.1, 1e-12);
  // A quarter turn about z swaps the half axes x and y.
  const Box e =
      Shape::blend({{{0, 0, 0}, {0.5, 0.3, 0.2}}}, 0.1).transformed({0, 0, 0}, {0, 0, 1}, pi / 2).bounds();
  EXPECT_NEAR(e.max.x, 0.3, 1e-12);
  EXPECT_NEAR(e.max.y, 0.5, 1e-12);
}

TEST(Shape, MovingAThousandTimesStaysExactEnoughAndShallow) {
  Shape s = Shape::sphere({}, 1);
  for (int i = 0; i < 1000; ++i) s = s.transformed({0.001, 0, 0}, {0, 1, 0}, 0.01);
  EXPECT_TRUE(s.validate());
  // Each of 1000 products of rotations rounds by 1e-16.
  EXPECT_NEAR(s.bounds().max.y, 1, 1e-12);
}

TEST(Shape, UnionAndDifferenceVolumes) {
  const Shape a = Shape::sphere({0, 0, 0}, 0.5), b = Shape::sphere({0.5, 0, 0}, 0.5);
  // Spheres of radius r at distance r share 5 pi r^3 / 12.
  const double ball = pi / 6, lens = 5 * pi / 12 * 0.125;
  expect_volume(Shape::unite({a, b}), 2 * ball - lens, 2 * pi);
  expect_volume(Shape::subtract(a, b), ball - lens, 2 * pi);
  expect_volume(Shape::subtract(Shape::subtract(a, b), Shape::sphere({-0.5, 0, 0}, 0.5)), ball - 2 * lens,
                3 * pi);
  expect_consistent(Shape::subtract(Shape::unite({a, b}), Shape::mesh(torus_mesh(0.5, 0.2, 24, 12))), 0.07);
}

TEST(Shape, IntersectionVolumes) {
  const Shape a = Shape::sphere({0, 0, 0}, 0.5), b = Shape::sphere({0.5, 0, 0}, 0.5);
  const double ball = pi / 6, lens = 5 * pi / 12 * 0.125;
  expect_volume(Shape::intersect({a, b}), lens, pi);
  expect_volume(Shape::intersect({a}), ball, pi);
  const Shape turned = Shape::intersect({a, b}).transformed({1, 2, 3}, {0, 0, 1}, pi / 3);
  expect_volume(turned, lens, pi);
  // The lens reaches from x = 0 to 0.5 and 0.433 across; the box of the parts' boxes is a little larger.
  EXPECT_NEAR(Shape::intersect({a, b}).bounds().min.x, 0, 1e-12);
  EXPECT_NEAR(Shape::intersect({a, b}).bounds().max.x, 0.5, 1e-12);
  expect_consistent(Shape::intersect({a, Shape::mesh(torus_mesh(0.5, 0.2, 24, 12))}), 0.07);
}

TEST(Shape, IntersectionsOfNothing) {
  const Shape a = Shape::sphere({0, 0, 0}, 0.5), far = Shape::sphere({9, 0, 0}, 0.5);
  EXPECT_TRUE(Shape::intersect({}).empty());
  EXPECT_TRUE(Shape::intersect({a, Shape()}).empty());
  EXPECT_TRUE(Shape::intersect({a, far}).validate());
  EXPECT_TRUE(Shape::intersect({a, far}).lattice_points({}, 0.1).empty());
  // Nothing in a union changes nothing.
  EXPECT_TRUE(same_sites(Shape::unite({a, Shape::intersect({a, far})}).lattice_points({}, 0.1),
                         a.lattice_points({}, 0.1)));
  expect_refused(Shape::intersect({a, Shape::sphere({}, -3)}), "intersect.parts[1]", "-3");
}

TEST(Shape, ManyPartsInALoopStayShallow) {
  Shape all;  // one part per step: deeper than any tree could be walked if it were not flattened
  for (int i = 0; i < 2000; ++i) all = Shape::unite({all, Shape::box({i * 1.0, 0, 0}, {i + 1.0, 1, 1})});
  EXPECT_TRUE(all.validate());
  EXPECT_EQ(all.lattice_points({}, 0.5).size(), 2000u * 8);
  for (int i = 0; i < 1000; ++i) all = Shape::subtract(all, Shape::box({i * 2.0, 0, 0}, {i * 2 + 1.0, 1, 1}));
  EXPECT_TRUE(all.validate());
  EXPECT_EQ(all.lattice_points({}, 0.5).size(), 1000u * 8);
}

TEST(Shape, TooDeepTreesAreRefused) {
  Shape s = Shape::sphere({}, 1);  // alternating kinds cannot be flattened
  for (int i = 0; i < 100000; ++i)
    s = Shape::subtract(Shape::unite({s, Shape::sphere({3, 0, 0}, 1)}), Shape::sphere({9, 0, 0}, 1));
  expect_refused(s, "nested", "256");
}

TEST(Shape, ValidateNamesFieldAndValue) {
  const double nan = std::nan(""), inf = meltsim::infinity;
  expect_refused(Shape::box({0, 2, 0}, {1, 1, 1}), "box.min.y", "2");
  expect_refused(Shape::box({0, 0, 0}, {1, 1, 0}), "box.max.z", "0");
  expect_refused(Shape::box({0, 0, nan}, {1, 1, 1}), "box.min.z", "nan");
  expect_refused(Shape::box({0, 0, 0}, {1, 1, 1e31}), "box.max.z", "1e+31");
  expect_refused(Shape::sphere({0, 0, 0}, 0), "sphere.radius", "0");
  expect_refused(Shape::sphere({inf, 0, 0}, 1), "sphere.center.x", "inf");
  expect_refused(Shape::capsule({}, {1, 0, 0}, -2), "capsule.radius", "-2");
  expect_refused(Shape::cylinder({1, 1, 1}, {1, 1, 1}, 1), "cylinder.a", "cylinder.b");
  expect_refused(Shape::cylinder({}, {1, 0, 0}, nan), "cylinder.radius", "nan");
  expect_refused(Shape::torus({}, {0, 0, 0}, 1, 0.1), "torus.axis", "(0, 0, 0)");
  expect_refused(Shape::torus({}, {0, 0, 1}, 1, 2), "torus.minor_radius", "2");
  expect_refused(Shape::torus({}, {0, 0, 1}, -1, -2), "torus.major_radius", "-1");
  expect_refused(Shape::blend({}, 0.1), "blend.parts", "empty");
  expect_refused(Shape::blend({{{}, {1, 1, 1}}, {{}, {1, 0, 1}}}, 0.1), "blend.parts[1].radii.y", "0");
  expect_refused(Shape::blend({{{}, {1, 1, 1}}}, -0.1), "blend.blend", "-0.1");
  const Shape ball = Shape::sphere({}, 1);
  expect_refused(ball.transformed({0, 0, 0}, {0, 1, 0}, 0, 0), "transformed.scale", "0");
  expect_refused(ball.transformed({0, 0, 0}, {0, 0, 0}, 1), "transformed.axis", "(0, 0, 0)");
  expect_refused(ball.transformed({0, nan, 0}), "transformed.offset.y", "nan");
  expect_refused(ball.transformed({0, 0, 0}, {0, 1, 0}, inf), "transformed.angle", "inf");
  EXPECT_TRUE(ball.transformed({0, 0, 0}, {0, 0, 0}, 0).validate()) << "without a turn no axis is needed";
  expect_refused(Shape::unite({ball, Shape::sphere({}, -3)}), "unite.parts[1]", "-3");
  expect_refused(Shape::subtract(ball, Shape::sphere({}, -3)).transformed({}), "subtract.what", "-3");
}

TEST(Shape, AbsurdLatticesGiveNothing) {
  const Shape ball = Shape::sphere({}, 1);
  EXPECT_TRUE(ball.lattice_points({}, 1e-6).empty()) << "8e18 sites";
  EXPECT_TRUE(ball.lattice_points({}, 0).empty());
  EXPECT_TRUE(ball.lattice_points({}, -0.1).empty());
  EXPECT_TRUE(ball.lattice_points({}, std::nan("")).empty());
  EXPECT_TRUE(ball.lattice_points({std::nan(""), 0, 0}, 0.1).empty());
  EXPECT_TRUE(Shape::sphere({1e12, 0, 0}, 1).lattice_points({}, 0.1).empty()) << "indices beyond 32 bits";
  EXPECT_TRUE(ball.transformed({}, {0, 1, 0}, 0, 1e30)
                  .transformed({}, {0, 1, 0}, 0, 1e30)
                  .lattice_points({}, 1)
                  .empty());
}

TEST(Shape, CheckLatticeSaysWhatDoesNotFit) {
  const auto message = [](const Shape& s, double spacing) {
    const meltsim::Status status = meltsim::check_lattice(s.bounds(), {}, spacing);
    return status ? std::string("fits") : status.error().message;
  };
  EXPECT_EQ(message(Shape::sphere({}, 1), 0.01), "fits");
  EXPECT_EQ(message(Shape(), 0.01), "fits");
  EXPECT_NE(message(Shape::sphere({}, 1), -0.5).find("spacing is -0.5"), std::string::npos);
  EXPECT_NE(message(Shape::sphere({}, 1), 1e-6).find("8.0"), std::string::npos) << "8e18 sites";
  EXPECT_NE(message(Shape::sphere({1e12, 0, 0}, 1), 0.1).find("1e9 spacings"), std::string::npos);
}

TEST(Shape, HugeCoordinatesKeepTheirVolume) {
  // A million metres out, a double still resolves 1e-10 m, a billionth of the spacing.
  const Vec3d far{1e6, -2e6, 3e6};
  expect_volume(Shape::sphere({1e6, -2e6, 3e6}, 0.5), pi / 6, pi);
  EXPECT_EQ(Shape::box(far, far + Vec3d{1, 1, 1}).lattice_points({}, 0.1).size(), 1000u);
}

TEST(Shape, BlendHoldsWhatItsFormulaSays) {
  const std::vector<Ellipsoid> parts = {{{0, 0, 0}, {1.45, 1.05, 0.95}},
                                        {{-0.65, -0.3, 0.62}, {0.85, 0.8, 0.5}},
                                        {{1.25, 1.15, 0}, {0.8, 0.65, 0.62}},
                                        {{0.85, 2.45, 0.42}, {0.34, 1.05, 0.24}},
                                        {{2.6, 0, 0}, {0.01, 0.3, 0.2}}};
  for (const double width : {0.0, 1e-6, 0.05, 0.3, 2.0}) {
    const auto value = [&](Vec3d p) {
      double least = meltsim::infinity;
      for (const Ellipsoid& e : parts) {
        const Vec3d d = p - e.center;
        const Vec3d q{d.x * (1 / e.radii.x), d.y * (1 / e.radii.y), d.z * (1 / e.radii.z)};
        const Vec3d g{q.x * (1 / e.radii.x), q.y * (1 / e.radii.y), q.z * (1 / e.radii.z)};
        const double level = length(q), a = (level - 1) * level / length(g);
        const double overlap = width - std::abs(least - a);
        least = std::min(least, a) - (overlap > 0 ? 0.25 * overlap * overlap / width : 0.0);
      }
      return least;
    };
    const Shape shape = Shape::blend(parts, width);
    int inside = 0;
    for (int k = 0; k < 200000; ++k) {
      const Vec3d p{-2.5 + 6 * ((k * 0.754877666) - std::floor(k * 0.754877666)),
                    -2 + 6 * ((k * 0.569840296) - std::floor(k * 0.569840296)),
                    -2 + 4 * ((k * 0.362372) - std::floor(k * 0.362372))};
      const double v = value(p);
      if (std::abs(v) < 1e-7) continue;  // as near to the surface as it is meant to be known
      ASSERT_EQ(shape.contains(p), v < 0) << p.x << ' ' << p.y << ' ' << p.z << ", width " << width;
      inside += v < 0 ? 1 : 0;
    }
    EXPECT_GT(inside, 10000);
  }
}

TEST(Shape, SitesAreTheSameHoweverPartsAreGoneThrough) {
  const Shape ball = Shape::sphere({0.3, 0.2, 0.1}, 0.5),
              box = Shape::mesh(cuboid({0, 0, 0}, {0.9, 0.5, 0.7}));
  const Shape blend = Shape::blend({{{0, 0, 0}, {0.5, 0.4, 0.3}}, {{0.4, 0.3, 0}, {0.3, 0.3, 0.3}}}, 0.1);
  const Shape all[] = {ball,
                       box,
                       blend.transformed({0.1, 0.2, 0.3}, {1, 1, 0}, 30),
                       Shape::unite({ball, box.transformed({0.3, 0.1, 0}, {0, 0, 1}, 20)}),
                       Shape::subtract(box, ball),
                       Shape::intersect({ball, blend})};
  for (const Shape& shape : all) {
    std::int64_t most = 0;
    const auto backwards = [&most](std::int64_t parts, const std::function<void(std::int64_t)>& part) {
      most = std::max(most, parts);
      for (std::int64_t k = parts; k-- > 0;) part(k);
    };
    const std::vector<Vec3i> expected = shape.lattice_points(generic_origin, h);
    std::vector<Vec3i> sites;
    ASSERT_TRUE(meltsim::lattice_points(shape, generic_origin, h, backwards, sites));
    ASSERT_EQ(sites.size(), expected.size());
    for (std::size_t k = 0; k < sites.size(); ++k)
      ASSERT_TRUE(sites[k].x == expected[k].x && sites[k].y == expected[k].y && sites[k].z == expected[k].z);
    // The same as at once: vertices of meshes are rounded relative to where the lattice begins.
    const meltsim::ShapeNode* const node = meltsim::ShapeAccess::node(shape);
    const meltsim::SiteMask mask =
        meltsim::sample(*node, {generic_origin, h, {}, {}}, {{-1000, -1000, -1000}, {1000, 1000, 1000}});
    EXPECT_EQ(std::accumulate(mask.inside.begin(), mask.inside.end(), std::size_t{0}), sites.size());
    EXPECT_EQ(most > 1, !node->holds_mesh());
    EXPECT_EQ(most > 1, &shape == &all[0] || &shape == &all[2] || &shape == &all[5]) << "no mesh among them";
  }
}

TEST(Shape, MemoryThatRunsOutInAPartIsAnError) {
  const auto no_memory = [](std::int64_t, const std::function<void(std::int64_t)>&) {
    throw std::bad_alloc();
  };
  std::vector<Vec3i> sites;
  const meltsim::Status s = meltsim::lattice_points(Shape::sphere({}, 1), {}, h, no_memory, sites);
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, meltsim::ErrorCode::out_of_memory);
}

}  // namespace
}  // namespace shape_tests
