// SPDX-License-Identifier: Apache-2.0
#include "show/draw.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace runner {

namespace {

/// The lowest corner of a box, seen along `up`.
double bottom(const Box& box, const meltsim::Vec3d& up) {
  const auto low = [](double direction, double min, double max) {
    return direction * (direction > 0 ? min : max);
  };
  return low(up.x, box.min.x, box.max.x) + low(up.y, box.min.y, box.max.y) + low(up.z, box.min.z, box.max.z);
}

}  // namespace

PictureWish picture_wish(const Scene& scene, double cold, double hot) {
  const Json& given = scene.output.picture;
  PictureWish wish;
  wish.threads = scene.world.threads;
  wish.cold = cold;
  wish.hot = hot;
  if (!given.is_object()) return wish;
  wish.width = given.value("width", wish.width);
  wish.height = given.value("height", wish.height);
  wish.samples = given.value("samples", wish.samples);
  if (given.value("look", "natural") == std::string("temperature")) wish.look = Look::temperature;
  return wish;
}

TraceSettings trace_settings(const Scene& scene, const Camera& camera, const PictureWish& wish) {
  TraceSettings settings;
  settings.width = wish.width;
  settings.height = wish.height;
  settings.samples = wish.samples;
  settings.threads = wish.threads;
  settings.look = wish.look;
  settings.cold = wish.cold;
  settings.hot = wish.hot;
  settings.spacing = scene.world.spacing;
  for (const auto& given : scene.output.body_colors) {
    settings.bodies.push_back(given ? linear(*given) : palette_color(settings.bodies.size()));
  }
  settings.looks = scene.output.looks;
  settings.extent = wish.extent > 0 ? wish.extent : length(view_box(scene, {}).size());
  // Without bounds there is nothing to stand on.
  settings.has_floor = scene.world.domain.bounded;
  if (settings.has_floor) {
    settings.floor = bottom(view_box(scene, {}), camera.up) - 0.02 * scene.world.spacing;
    settings.tank = tank_bars(scene, camera.eye);
    if (!settings.tank.empty()) {
      settings.basin = view_box(scene, {});
      settings.floor -= tank_width(scene);  // the lowest bars stand on it
    }
  }
  return settings;
}

Image draw(const FrameShapes& shapes, const Scene& scene, const Camera& camera, const PictureWish& wish) {
  Image image = traced(shapes, camera, trace_settings(scene, camera, wish));
  annotate(image, shapes.time, wish);
  return image;
}

void annotate(Image& image, double time, const PictureWish& wish) {
  draw_caption(image, fmt::format("t = {:.2f} s", time));
  if (wish.look == Look::temperature) draw_legend(image, wish.cold, wish.hot);
}

void widen_range(const FrameShapes& shapes, double& cold, double& hot) {
  const auto take = [&](double t) {
    cold = std::min(cold, t);
    hot = std::max(hot, t);
  };
  for (const Mesh* mesh : {&shapes.liquid, &shapes.solid}) {
    for (const float t : mesh->temperature) take(t);
  }
  for (const Ball& ball : shapes.balls) take(ball.temperature);
}

}  // namespace runner
