// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "camera.hpp"
#include "look.hpp"
#include "picking.hpp"

namespace {

using namespace view;

const Viewport viewport{800, 600};
const meltsim::Box box{{0, 0, 0}, {2, 1, 3}};

/// By the matrices, as the shaders do it: pixels from the upper left, depth -1..1.
Vec3d through_matrices(const Camera& camera, const Vec3d& x) {
  const Mat4 m = camera.projection(viewport, {1, 0.5, 1.5}, 4) * camera.view();
  const double in[4] = {x.x, x.y, x.z, 1};
  double clip[4] = {};
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) clip[i] += static_cast<double>(m.at(i, k)) * in[k];
  return {400 * (1 + clip[0] / clip[3]), 300 * (1 - clip[1] / clip[3]), clip[2] / clip[3]};
}

TEST(Camera, FramedBoxIsInsideTheWindow) {
  for (const Vec3d up : {Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{1, 0, 0}}) {
    Camera camera;
    camera.frame(box, up, viewport.aspect());
    for (int i = 0; i < 8; ++i) {
      const Vec3d corner{i & 1 ? 2.0 : 0.0, i & 2 ? 1.0 : 0.0, i & 4 ? 3.0 : 0.0};
      const Vec3d pixel = through_matrices(camera, corner);
      EXPECT_TRUE(pixel.x > 0 && pixel.x < 800 && pixel.y > 0 && pixel.y < 600) << pixel.x << " " << pixel.y;
      EXPECT_TRUE(pixel.z > -1 && pixel.z < 1) << pixel.z;
    }
  }
}

TEST(Camera, UpIsUpInThePicture) {
  for (const Vec3d up : {Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{0, 0, -1}, Vec3d{0, -1, 0}}) {
    Camera camera;
    camera.frame(box, up, viewport.aspect());
    const Vec3d low = through_matrices(camera, camera.target());
    const Vec3d high = through_matrices(camera, camera.target() + up * 0.3);
    EXPECT_LT(high.y, low.y - 5);
    EXPECT_NEAR(high.x, low.x, 1e-3);
  }
}

TEST(Camera, PlacedWhereAsked) {
  Camera camera;
  camera.place({8, 6, 10}, {2.4, 1.5, 2.4}, {0, 1, 0});
  EXPECT_NEAR(length(camera.eye() - Vec3d{8, 6, 10}), 0, 1e-9);
}

TEST(Camera, RayProjectionAndMatricesAgreeAlsoBesideAPanel) {
  Camera camera;
  camera.frame(box, {0, 1, 0}, viewport.aspect());
  camera.orbit(0.2, 0.1);
  camera.pan(0.05, -0.1);
  camera.shift(0.3);
  const Vec3d point{0.3, 0.8, 2.1};
  double x = 0, y = 0;
  ASSERT_TRUE(camera.project(point, viewport, x, y));
  const Vec3d pixel = through_matrices(camera, point);
  EXPECT_NEAR(pixel.x, x, 1e-2);
  EXPECT_NEAR(pixel.y, y, 1e-2);
  const Ray ray = camera.ray(x, y, viewport);
  const Vec3d to = point - ray.origin;
  EXPECT_NEAR(length(to - ray.direction * dot(to, ray.direction)), 0, 1e-9);
}

TEST(Camera, PanMovesTheTargetWithThePointer) {
  Camera camera;
  camera.frame(box, {0, 1, 0}, viewport.aspect());
  const Vec3d target = camera.target();
  camera.pan(60 / 600.0, 30 / 600.0);
  double x = 0, y = 0;
  ASSERT_TRUE(camera.project(target, viewport, x, y));
  EXPECT_NEAR(x, 400 + 60, 1e-6);
  EXPECT_NEAR(y, 300 + 30, 1e-6);
}

TEST(Camera, WheelGoesNearerAndBack) {
  Camera camera;
  camera.frame(box, {0, 1, 0}, viewport.aspect());
  const double distance = camera.distance();
  camera.zoom(3);
  EXPECT_LT(camera.distance(), 0.8 * distance);
  camera.zoom(-3);
  EXPECT_NEAR(camera.distance(), distance, 1e-9);
}

meltsim::ParticleData three_in_a_row() {
  meltsim::ParticleData data;
  data.id = {4, 7, 9};
  data.position = {{0, 0, 5}, {0, 0, 2}, {0, 0, 8}};
  data.tag = {0, meltsim::tag_solid | 1u << meltsim::tag_body_shift, 0};
  return data;
}

TEST(Picking, SphereIsMetAtItsNearSide) {
  const Ray ray{{0, 0, 0}, {0, 0, 1}};
  EXPECT_NEAR(hit_sphere(ray, {0.3, 0, 5}, 0.5).value_or(0), 5 - 0.4, 1e-12);
  EXPECT_FALSE(hit_sphere(ray, {0.6, 0, 5}, 0.5));
  EXPECT_FALSE(hit_sphere(ray, {0, 0, -5}, 0.5));
  EXPECT_FALSE(hit_sphere(ray, {0, 0, 5}, 0));
}

TEST(Picking, NearestThatIsShown) {
  const meltsim::ParticleData data = three_in_a_row();
  const Ray ray{{0, 0, 0}, {0, 0, 1}};
  Look look;
  const auto radius = [&look](const Vec3d& x, meltsim::ParticleTag tag) {
    return shown_radius(look, 1, x, tag);
  };
  EXPECT_EQ(pick(ray, data, radius), std::optional<std::size_t>(1));
  look.solid_size = 0;
  EXPECT_EQ(pick(ray, data, radius), std::optional<std::size_t>(0));
  look.cut_axis = 2;
  look.cut_at = 1;
  EXPECT_FALSE(pick(ray, data, radius));
}

TEST(Picking, IdIsFound) {
  const meltsim::ParticleData data = three_in_a_row();
  EXPECT_EQ(find_id(data, 7), std::optional<std::size_t>(1));
  EXPECT_FALSE(find_id(data, 5));
  EXPECT_FALSE(find_id(data, 12));
}

}  // namespace
