// SPDX-License-Identifier: Apache-2.0
#include "shape/shape_depth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "shape_support.hpp"

namespace shape_tests {
namespace {

using meltsim::ShapeDepth;
using meltsim::TriangleMesh;

constexpr double most = 0.5;
constexpr double found_to = 0.01 * most;  // what depths are found to along a direction

Vec3d any_point(std::mt19937& dice, double size) {
  std::uniform_real_distribution<double> d(-size, size);
  return {d(dice), d(dice), d(dice)};
}

/// A box of two triangles a side, of the corners -half and half.
TriangleMesh box_mesh(Vec3d half) {
  TriangleMesh m;
  for (int k = 0; k < 8; ++k)
    m.vertices.push_back(
        {(k & 1) != 0 ? half.x : -half.x, (k & 2) != 0 ? half.y : -half.y, (k & 4) != 0 ? half.z : -half.z});
  m.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
               2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return m;
}

double depth_in_box(Vec3d x, Vec3d half) {
  return std::min({half.x - std::fabs(x.x), half.y - std::fabs(x.y), half.z - std::fabs(x.z)});
}

// R - |x|, from anywhere inside.
TEST(ShapeDepth, OfABallIsRadial) {
  const double R = 2;
  const ShapeDepth depth(Shape::sphere({}, R));
  std::mt19937 dice(1);
  for (int k = 0; k < 500; ++k) {
    const Vec3d x = any_point(dice, R);
    const double r = length(x);
    if (r >= R) {
      EXPECT_EQ(depth.at(x, {}, most), most);  // outside
      continue;
    }
    EXPECT_NEAR(depth.at(x, x * (1 / r), most), std::min(most, R - r), found_to);
  }
}

// Along one of 26 directions a plane is at most 1/cos(27.4 degrees) = 1.13 times as far as along its normal, wherever that points.
TEST(ShapeDepth, WithoutTheWayOutIsAnEighthTooMuchAtMost) {
  const double R = 50;  // a plane, to most^2/2R = 0.0025
  const ShapeDepth depth(Shape::sphere({}, R));
  std::mt19937 dice(2);
  for (int k = 0; k < 500; ++k) {
    Vec3d n = any_point(dice, 1);
    n = n * (1 / length(n));
    const double found = depth.at(n * (R - 0.3), {}, most);
    EXPECT_GE(found, 0.3 - found_to - 0.0025);
    EXPECT_LE(found, 0.3 * 1.13 + found_to + 0.0025);
  }
}

// A box along the axes has its faces among the 26 directions, one that is turned has them as the way out; in a hole the surface is that
// of the hole.
TEST(ShapeDepth, OfBoxesAndHolesIsTheDistanceToTheirFaces) {
  const Vec3d half{1, 2, 3};
  const Shape box = Shape::box(-half, half);
  const ShapeDepth straight(box), turned(box.transformed({1, 0, 0}, {0, 0, 1}, 0.5));
  std::mt19937 dice(3);
  for (int k = 0; k < 200; ++k) {
    const Vec3d x = any_point(dice, 1);
    EXPECT_NEAR(straight.at(x, {}, most), std::min(most, depth_in_box(x, half)), found_to);
  }
  const Vec3d out{std::cos(0.5), std::sin(0.5), 0};
  EXPECT_NEAR(turned.at(Vec3d{1, 0, 0} + out * 0.8, out, most), 0.2, found_to);
  const ShapeDepth holed(Shape::subtract(box, Shape::sphere({}, 0.5)));
  EXPECT_NEAR(holed.at({0.6, 0, 0}, {}, most), 0.1, found_to);
  EXPECT_EQ(holed.at({0, 0, 0}, {}, most), most);  // in the hole: outside
}

// At an edge the way out is the diagonal: the depth is that of the edge, not that of the nearer face, so that what stands on the other face
// stands on its rim. Of triangles the faces do not count there.
TEST(ShapeDepth, AtAnEdgeIsThatOfTheEdge) {
  const Vec3d half{1, 2, 3};
  const ShapeDepth box(Shape::box(-half, half)), mesh(Shape::mesh(box_mesh(half)));
  const double r2 = std::sqrt(2), r3 = std::sqrt(3);
  const Vec3d edge{half.x - 0.3, half.y - 0.4, 0}, edge_out{1 / r2, 1 / r2, 0};
  EXPECT_NEAR(box.at(edge, edge_out, most), 0.3 * r2, found_to);
  EXPECT_EQ(mesh.at(edge, edge_out, most), most);
  const Vec3d corner{half.x - 0.2, half.y - 0.4, half.z - 0.4}, corner_out{1 / r3, 1 / r3, 1 / r3};
  EXPECT_NEAR(box.at(corner, corner_out, most), 0.2 * r2,
              found_to);  // the edges of x beside the corner are nearer
  EXPECT_EQ(mesh.at(corner, corner_out, most), most);
  for (const ShapeDepth* depth : {&box, &mesh}) {  // a face, and none
    EXPECT_NEAR(depth->at(edge, {1, 0, 0}, most), 0.3, found_to);
    EXPECT_NEAR(depth->at(edge, {}, most), 0.3, found_to);
  }
  for (const double beyond : {0.0, -1e-16, 1e-16})
    EXPECT_NEAR(mesh.at({half.x * (1 + beyond), 0.3, 0}, {1, 0, 0}, most), 0, 1e-12) << beyond;
}

// The same box as triangles, where it lies and moved, turned and scaled; to rounding, no direction is needed.
TEST(ShapeDepth, OfAMeshIsTheDistanceToItsTriangles) {
  const Vec3d half{1, 2, 3};
  const Shape mesh = Shape::mesh(box_mesh(half));
  const ShapeDepth here(mesh), moved(mesh.transformed({1, 2, 3}, {0, 0, 1}, 0.7, 2));
  std::mt19937 dice(4);
  for (int k = 0; k < 300; ++k) {
    const Vec3d x{any_point(dice, 1).x, any_point(dice, 2).y, any_point(dice, 3).z};
    const double exact = depth_in_box(x, half);
    EXPECT_NEAR(here.at(x, {}, most), std::min(most, exact), 1e-12);
    const double c = std::cos(0.7), s = std::sin(0.7);
    const Vec3d there{1 + 2 * (c * x.x - s * x.y), 2 + 2 * (s * x.x + c * x.y), 3 + 2 * x.z};
    EXPECT_NEAR(moved.at(there, {}, most), std::min(most, 2 * exact), 1e-12);
  }
}

// A ball of many small triangles: each point against all of them.
TEST(ShapeDepth, OfManyTrianglesIsThatOfTheNearest) {
  TriangleMesh m;
  const int rows = 24, columns = 48;
  for (int r = 0; r <= rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const double a = pi * r / rows, b = 2 * pi * c / columns;
      m.vertices.push_back({std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b)});
    }
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * columns + j % columns); };
      m.indices.insert(m.indices.end(), {at(r, c), at(r, c + 1), at(r + 1, c)});
      m.indices.insert(m.indices.end(), {at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)});
    }
  const ShapeDepth depth(Shape::mesh(m));
  std::mt19937 dice(5);
  const double sagitta = 1 - std::cos(pi / rows);  // chords lie that far inside
  for (int k = 0; k < 300; ++k) {
    const Vec3d x = any_point(dice, 0.57);
    const double exact = std::min(most, 1 - length(x));
    EXPECT_LE(depth.at(x, {}, most), exact + 1e-12);
    EXPECT_GE(depth.at(x, {}, most), std::min(most, 1 - length(x) - sagitta) - 1e-12);
  }
}

// Faces turned against everything: normals to a hundredth of a radian, of ways out that end within 1e-3 of `most` of the surface. None within 0.6 of `most` of an
// edge, where another face ends the ways that lead into the shape.
TEST(ShapeDepth, FacesHaveTheirNormalsAndEdgesNone) {
  const Vec3d half{2, 1.5, 1}, axis = Vec3d{1, 2, -1} * (1 / std::sqrt(6.0));
  const auto turned = [&](Vec3d v) {  // Rodrigues
    return v * std::cos(0.7) + cross(axis, v) * std::sin(0.7) + axis * (dot(axis, v) * (1 - std::cos(0.7)));
  };
  const ShapeDepth box(Shape::box(-half, half).transformed({}, axis, 0.7)),
      mesh(Shape::mesh(box_mesh(half)).transformed({}, axis, 0.7));
  for (const double lean : {0.0, 0.3})
    for (const double deep : {0.02, 0.15, 0.3})
      for (const ShapeDepth* depth : {&box, &mesh}) {
        const Vec3d up = turned({0, 1, 0}), way = turned(Vec3d{std::sin(lean), std::cos(lean), 0});
        const auto face = depth->face(turned({0.3, half.y - deep, -0.1}), way, most);
        ASSERT_TRUE(face) << lean << " " << deep;
        EXPECT_LT(length(face->normal - up), 0.01);
        EXPECT_FALSE(face->curved);
        const Vec3d rim{half.x - 0.1, half.y - 0.1, 0};
        EXPECT_FALSE(depth->face(turned(rim), turned(Vec3d{1, 1, 0} * std::sqrt(0.5)), most));
        EXPECT_FALSE(depth->face(turned(rim), up, most));
      }
  const ShapeDepth ball(Shape::sphere({}, 2));
  const Vec3d out = Vec3d{1, -2, 3} * (1 / std::sqrt(14.0));
  const auto face = ball.face(out * 1.9, Vec3d{0, -0.5, 0.866}, most);
  ASSERT_TRUE(face);
  EXPECT_LT(length(face->normal - out), 0.02);  // of a plane through points 0.15 apart on it
  EXPECT_TRUE(face->curved);
  EXPECT_FALSE(ball.face(out * 2.1, out, most));
  EXPECT_FALSE(ball.face(out * 1.4, out, most));
}

TEST(ShapeDepth, IsNotLookedForWhereMeshesAreOnlyParts) {
  const Shape mesh = Shape::mesh(box_mesh({1, 1, 1}));
  const ShapeDepth depth(Shape::subtract(mesh, Shape::sphere({}, 0.5)));
  EXPECT_EQ(depth.at({0.9, 0, 0}, {}, most), most);
  EXPECT_FALSE(depth.face({0.9, 0, 0}, {1, 0, 0}, most));
  EXPECT_EQ(ShapeDepth(Shape()).at({}, {}, most), most);
}

}  // namespace
}  // namespace shape_tests
