// SPDX-License-Identifier: Apache-2.0
#include "stage_renderer.hpp"

#include <array>
#include <cmath>

#include "shaders.hpp"

namespace view {

double grid_step(double extent) {
  const double fine = extent / 16, power = std::pow(10, std::floor(std::log10(fine)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= fine) return factor * power;
  return 10 * power;
}

StageRenderer::StageRenderer(const ParticleRenderer& particles)
    : particles_(particles),
      backdrop_("backdrop", "", shaders::backdrop_vertex, shaders::backdrop_fragment),
      floor_("floor", shaders::shadow, shaders::floor_vertex, shaders::floor_fragment),
      lines_("lines", "", shaders::line_vertex, shaders::line_fragment) {
  glGenVertexArrays(1, &empty_);
  glGenVertexArrays(1, &edges_);
  glGenBuffers(1, &edge_points_);
}

StageRenderer::~StageRenderer() {
  glDeleteBuffers(1, &edge_points_);
  glDeleteVertexArrays(1, &edges_);
  glDeleteVertexArrays(1, &empty_);
}

void StageRenderer::draw_behind(const Frame& frame) const {
  glViewport(0, 0, frame.viewport.width, frame.viewport.height);
  glDepthMask(GL_TRUE);
  glClear(GL_DEPTH_BUFFER_BIT);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glBindVertexArray(empty_);
  backdrop_.use();
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void StageRenderer::draw_around(const Frame& frame, const Look& look, const meltsim::Box& box) const {
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  draw_floor(frame, look, box);
  if (look.box) draw_edges(frame, box);
  glDepthMask(GL_TRUE);
}

void StageRenderer::draw_floor(const Frame& frame, const Look& look, const meltsim::Box& box) const {
  const Vec3d up = frame.up, size = box.max - box.min;
  // The lowest corner of the box; what is below the floor sees no floor.
  const Vec3d low{up.x >= 0 ? box.min.x : box.max.x, up.y >= 0 ? box.min.y : box.max.y,
                  up.z >= 0 ? box.min.z : box.max.z};
  const Vec3d corner = low - frame.origin;
  const double depth = dot(frame.eye - corner, up);
  if (depth <= 0) return;
  const Vec3d along = normalized(cross(up, std::abs(up.x) > 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}));
  const Vec3d across = cross(along, up), middle = (box.min + box.max) * 0.5 - frame.origin;
  const double step = grid_step(length(size));
  // A hair lower, so that it does not fight with what lies on it.
  const Vec3d center = middle - up * (dot(middle - corner, up) + 1e-3 * length(size));
  floor_.use();
  particles_.bind_shadows(floor_, frame, look);
  floor_.set("view", frame.view);
  floor_.set("projection", frame.projection);
  floor_.set("center", center);
  floor_.set("along", along);
  floor_.set("across", across);
  floor_.set("reach", static_cast<float>(1.6 * length(size)));
  floor_.set("step_size", static_cast<float>(step));
  floor_.set("start", static_cast<float>(dot(corner, along)), static_cast<float>(dot(corner, across)));
  glBindVertexArray(empty_);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

void StageRenderer::draw_edges(const Frame& frame, const meltsim::Box& box) const {
  std::array<float, 12 * 2 * 3> points{};
  std::size_t at = 0;
  const Vec3d ends[2] = {box.min - frame.origin, box.max - frame.origin};
  const auto corner = [&](int i) {
    points[at++] = static_cast<float>(ends[i & 1].x);
    points[at++] = static_cast<float>(ends[(i >> 1) & 1].y);
    points[at++] = static_cast<float>(ends[(i >> 2) & 1].z);
  };
  for (int i = 0; i < 8; ++i) {
    for (const int axis : {1, 2, 4}) {
      if ((i & axis) != 0) continue;
      corner(i);
      corner(i | axis);
    }
  }
  lines_.use();
  lines_.set("view", frame.view);
  lines_.set("projection", frame.projection);
  glBindVertexArray(edges_);
  glBindBuffer(GL_ARRAY_BUFFER, edge_points_);
  glBufferData(GL_ARRAY_BUFFER, sizeof points, points.data(), GL_STREAM_DRAW);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  glEnableVertexAttribArray(0);
  glDrawArrays(GL_LINES, 0, 24);
}

}  // namespace view
