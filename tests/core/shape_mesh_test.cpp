// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "shape/mesh_raster.hpp"
#include "shape/mesh_shells.hpp"
#include "shape_support.hpp"

namespace shape_tests {
namespace {

TEST(ShapeMesh, CuboidEqualsTheBox) {
  // Generic corners, several lattices, and corners exactly on sites.
  for (const double spacing : {0.1, 0.0371}) {
    const Vec3d lo{-0.313, 0.117, 0.229}, hi{0.411, 0.873, 0.697};
    const auto expected = Shape::box(lo, hi).lattice_points(generic_origin, spacing);
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(same_sites(Shape::mesh(cuboid(lo, hi)).lattice_points(generic_origin, spacing), expected));
  }
  for (const double phase : {0.0, 0.05}) {
    const Vec3d lo{phase, phase, phase}, hi{phase + 0.7, phase + 0.3, phase + 1.1};
    const auto sites = Shape::mesh(cuboid(lo, hi)).lattice_points({}, 0.1);
    EXPECT_EQ(sites.size(), 7u * 3 * 11);
    EXPECT_TRUE(same_sites(sites, Shape::box(lo, hi).lattice_points({}, 0.1)));
  }
}

TEST(ShapeMesh, TurnedCuboidEqualsTheTurnedBox) {
  const Vec3d lo{-0.313, 0.117, 0.229}, hi{0.411, 0.873, 0.697};
  const auto turned = [](const Shape& s) {
    return s.transformed({0.1, 0.2, 0.3}, {1, 2, -1}, 0.8, 1.7).lattice_points(generic_origin, 0.05);
  };
  EXPECT_TRUE(same_sites(turned(Shape::mesh(cuboid(lo, hi))), turned(Shape::box(lo, hi))));
}

TEST(ShapeMesh, TorusVolume) {
  // The polyhedron is inscribed: per section its area is that of a regular polygon, around the axis the
  // sections are sheared by cos. 96 by 48 corners keep that below 0.4 %, which is added to the tolerance.
  const double volume = 2 * pi * pi * 0.5 * 0.2 * 0.2, area = 4 * pi * pi * 0.5 * 0.2;
  const Shape s = Shape::mesh(torus_mesh(0.5, 0.2, 96, 48));
  EXPECT_NEAR(sampled_volume(s, 0.02), volume, volume_tolerance(area, 0.02) + 0.004 * volume);
}

TEST(ShapeMesh, OrientationDoesNotMatter) {
  TriangleMesh all = torus_mesh(0.5, 0.2, 24, 12), some = all;
  const auto expected = Shape::mesh(all).lattice_points(generic_origin, 0.05);
  for (std::size_t t = 0; t < all.indices.size(); t += 3) {
    std::swap(all.indices[t], all.indices[t + 1]);
    if (t % 2 == 0) std::swap(some.indices[t], some.indices[t + 2]);
  }
  EXPECT_TRUE(same_sites(Shape::mesh(all).lattice_points(generic_origin, 0.05), expected));
  EXPECT_TRUE(same_sites(Shape::mesh(some).lattice_points(generic_origin, 0.05), expected));
}

TEST(ShapeMesh, CubeWithoutOneFaceIsStillSolid) {
  // Along two axes the parity is right everywhere; they outvote the third, on each of the six sides.
  const Vec3d lo{-0.313, 0.117, 0.229}, hi{0.411, 0.873, 0.697};
  const auto expected = Shape::box(lo, hi).lattice_points(generic_origin, 0.05);
  for (std::ptrdiff_t face = 0; face < 6; ++face) {
    TriangleMesh open = cuboid(lo, hi);
    open.indices.erase(open.indices.begin() + 6 * face, open.indices.begin() + 6 * face + 6);
    const Shape s = Shape::mesh(open);
    EXPECT_TRUE(same_sites(s.lattice_points(generic_origin, 0.05), expected)) << face;
    EXPECT_TRUE(s.contains({0, 0.5, 0.5})) << face;
    EXPECT_FALSE(s.contains({0, 0.5, 0.8})) << face;
  }
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  for (const std::uint32_t i : b.indices) a.indices.push_back(i + first);
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  return a;
}

TriangleMesh inside_out(TriangleMesh m) {
  for (std::size_t t = 0; t < m.indices.size(); t += 3) std::swap(m.indices[t], m.indices[t + 1]);
  return m;
}

// Two cubes that share half a cube, in any orientation, and one that is there twice, or nearly.
TEST(ShapeMesh, ShellsThatOverlapAreOneBody) {
  const TriangleMesh first = cuboid({0, 0, 0}, {1, 1, 1}), second = cuboid({0.5, 0, 0}, {1.5, 1, 1});
  for (const bool a : {false, true})
    for (const bool b : {false, true}) {
      const Shape both = Shape::mesh(joined(a ? inside_out(first) : first, b ? inside_out(second) : second));
      EXPECT_EQ(both.lattice_points({}, 0.1).size(), 1500u) << a << b;
      EXPECT_TRUE(both.contains({0.75, 0.5, 0.5})) << a << b;
      EXPECT_FALSE(both.contains({1.75, 0.5, 0.5})) << a << b;
    }
  EXPECT_EQ(Shape::mesh(joined(first, first)).lattice_points({}, 0.1).size(), 1000u);
  EXPECT_EQ(Shape::mesh(joined(first, cuboid({1e-3, 0, 0}, {1.001, 1, 1}))).lattice_points({}, 0.1).size(),
            1000u);
}

// A cube within a cube is a part of it if it faces the same way and a cavity if it faces the other, whichever that is.
TEST(ShapeMesh, AShellWithinAnotherIsACavityIfItFacesTheOtherWay) {
  const TriangleMesh outer = cuboid({0, 0, 0}, {1, 1, 1}), inner = cuboid({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8});
  EXPECT_EQ(Shape::mesh(joined(outer, inner)).lattice_points({}, 0.1).size(), 1000u);
  for (const TriangleMesh& hollow : {joined(outer, inside_out(inner)), joined(inside_out(outer), inner),
                                     joined(inside_out(inner), outer)}) {
    EXPECT_EQ(Shape::mesh(hollow).lattice_points({}, 0.1).size(), 1000u - 216u);
    EXPECT_FALSE(Shape::mesh(hollow).contains({0.5, 0.5, 0.5}));
    const TriangleMesh kernel = cuboid({0.4, 0.4, 0.4}, {0.6, 0.6, 0.6});
    const bool turned = hollow.indices[0] != outer.indices[0] && hollow.vertices[0].x == 0;
    EXPECT_EQ(
        Shape::mesh(joined(hollow, turned ? inside_out(kernel) : kernel)).lattice_points({}, 0.1).size(),
        1000u - 208u);
  }
}

// Vertices that are repeated, as files repeat them where normals jump, are one; of an open shell beside it parity holds.
TEST(ShapeMesh, RepeatedVerticesJoinAndOpenShellsCountByParity) {
  TriangleMesh soup, cube = cuboid({0, 0, 0}, {1, 1, 1});
  for (const std::uint32_t i : cube.indices) {
    soup.indices.push_back(static_cast<std::uint32_t>(soup.vertices.size()));
    soup.vertices.push_back(cube.vertices[i]);
  }
  EXPECT_EQ(Shape::mesh(joined(soup, cuboid({0.5, 0, 0}, {1.5, 1, 1}))).lattice_points({}, 0.1).size(),
            1500u);
  TriangleMesh open = cuboid({2, 0, 0}, {3, 1, 1});
  open.indices.resize(open.indices.size() - 3);
  EXPECT_EQ(Shape::mesh(joined(soup, open)).lattice_points({}, 0.1).size(), 2000u);
}

TEST(ShapeMesh, SitesOnVerticesAndEdgesAreCountedOnce) {
  // An octahedron whose vertices, edges and diagonals run through sites. Integer points with
  // |x| + |y| + |z| <= n number (2n + 1)(2n^2 + 2n + 3) / 3; the surface belongs to it only in part, so
  // the count lies between those of n - 1 and n, and no line of sites may leak out.
  const int n = 6;
  TriangleMesh m;
  for (const double s : {-1.0, 1.0})
    for (const Vec3d axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
      m.vertices.push_back(Vec3d{0.5, 0.5, 0.5} + axis * (s * n));
  for (const std::uint32_t x : {0u, 3u})
    for (const std::uint32_t y : {1u, 4u})
      for (const std::uint32_t z : {2u, 5u}) m.indices.insert(m.indices.end(), {x, y, z});
  const auto count = [](int k) {
    return static_cast<std::size_t>((2 * k + 1) * (2 * k * k + 2 * k + 3) / 3);
  };
  const Shape s = Shape::mesh(m);
  const auto sites = s.lattice_points({}, 1);
  EXPECT_GE(sites.size(), count(n - 1));
  EXPECT_LE(sites.size(), count(n));
  for (const Vec3i& i : sites) {
    EXPECT_LE(std::abs(i.x) + std::abs(i.y) + std::abs(i.z), n);
    EXPECT_TRUE(s.contains({i.x + 0.5, i.y + 0.5, i.z + 0.5}));
  }
}

TEST(ShapeMesh, LinesThroughVerticesAreCountedOnce) {
  // Shapes move their points by a hair and so hardly ever meet this case; here nothing is moved. The lines of
  // a grid hit vertices and edges of a torus whose corners are rounded to that grid.
  TriangleMesh m = torus_mesh(24, 8, 20, 10);
  for (Vec3d& v : m.vertices) v = {std::round(v.x), std::round(v.y), std::round(v.z)};
  const std::vector<std::int8_t> turns = meltsim::triangle_turns(m);
  meltsim::SiteMask mask{{{-40, -40, -12}, {40, 40, 12}}, {}};
  mask.inside.assign(mask.range.count(), 0);
  // Sites at integers: the lattice puts its sites half a spacing above its origin.
  meltsim::fill_inside(m, turns, {0, 0, 0}, {{-0.5, -0.5, -0.5}, 1, {}, {}}, mask);
  const Vec3d off{0.1, 0.2, 0.3};
  for (int y = -40; y < 40; ++y)
    for (int z = -12; z < 12; ++z) {
      // A leak would fill the row up to its end, outside the torus.
      EXPECT_EQ(mask.inside[mask.row(y, z) + 79], 0);
      for (const double x : {-39.0, 39.0}) EXPECT_FALSE(meltsim::inside_of(m, turns, {x, y * 1.0, z * 1.0}));
    }
  // The circle of the centres lies well inside, whatever is hit on the way to it.
  for (int i = 0; i < 200; ++i) {
    const double a = 2 * pi * i / 200;
    const Vec3d p{std::round(24 * std::cos(a)), std::round(24 * std::sin(a)), 0};
    EXPECT_TRUE(meltsim::inside_of(m, turns, p)) << p.x << ' ' << p.y;
    EXPECT_TRUE(meltsim::inside_of(m, turns, p + off)) << p.x << ' ' << p.y;
    EXPECT_NE(mask.inside[mask.row(static_cast<int>(p.y), 0) + static_cast<std::size_t>(p.x + 40)], 0);
  }
}

TEST(ShapeMesh, OneVoteOfThreeIsNotEnough) {
  for (std::ptrdiff_t face = 0; face < 6; ++face) {
    TriangleMesh open = cuboid({0, 0, 0}, {1, 1, 1});
    open.indices.erase(open.indices.begin() + 6 * face, open.indices.begin() + 6 * face + 6);
    for (const Vec3d p : {Vec3d{1.5, 0.4, 0.3}, Vec3d{0.4, 1.5, 0.3}, Vec3d{0.4, 0.3, 1.5}})
      EXPECT_FALSE(meltsim::inside_of(open, meltsim::triangle_turns(open), p)) << face;
  }
}

TEST(ShapeMesh, HugeCoordinates) {
  const Vec3d far{1e6, -2e6, 3e6};
  const Shape s = Shape::mesh(cuboid(far, far + Vec3d{1, 1, 1}));
  EXPECT_EQ(s.lattice_points({}, 0.1).size(), 1000u);
  // Almost at the limit: nothing overflows, and no such lattice exists.
  const Shape vast = Shape::mesh(cuboid({-1e30, -1e30, -1e30}, {1e30, 1e30, 1e30}));
  EXPECT_TRUE(vast.validate());
  EXPECT_TRUE(vast.contains({1, 2, 3}));
  EXPECT_TRUE(vast.lattice_points({}, 0.1).empty());
}

TEST(ShapeMesh, TriangleSoupDoesNotCrash) {
  // Arbitrary triangles bound nothing in particular; degenerate ones, repeated corners and slivers have to be
  // survived, and sites have to agree with contains().
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-1, 1);
  TriangleMesh m;
  for (int i = 0; i < 60; ++i) m.vertices.push_back({at(random), at(random), at(random)});
  for (int i = 0; i < 100 * 3; ++i) m.indices.push_back(static_cast<std::uint32_t>(random() % 60));
  const Shape s = Shape::mesh(m);
  const auto sites = s.lattice_points(generic_origin, 0.1);
  EXPECT_FALSE(sites.empty());
  for (const Vec3i& i : sites)
    EXPECT_TRUE(s.contains(generic_origin + Vec3d{i.x + 0.5, i.y + 0.5, i.z + 0.5} * 0.1));
}

TEST(ShapeMesh, ValidateNamesTheEntry) {
  const auto message = [](const TriangleMesh& m) {
    const meltsim::Status s = Shape::mesh(m).validate();
    EXPECT_TRUE(Shape::mesh(m).lattice_points({}, 0.1).empty());
    EXPECT_FALSE(Shape::mesh(m).contains({0.5, 0.5, 0.5}));
    return s ? std::string("accepted") : s.error().message;
  };
  const TriangleMesh good = cuboid({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(Shape::mesh(good).validate());
  TriangleMesh bad = good;
  bad.indices.clear();
  EXPECT_NE(message(bad).find("mesh.indices is empty"), std::string::npos);
  bad = good;
  bad.indices.pop_back();
  EXPECT_NE(message(bad).find("mesh.indices has 35"), std::string::npos);
  bad = good;
  bad.indices[5] = 8;
  EXPECT_NE(message(bad).find("mesh.indices[5] is 8"), std::string::npos);
  bad = good;
  bad.vertices[3].z = std::nan("");
  EXPECT_NE(message(bad).find("mesh.vertices[3].z is nan"), std::string::npos);
}

}  // namespace
}  // namespace shape_tests
