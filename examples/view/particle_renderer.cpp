// SPDX-License-Identifier: Apache-2.0
#include "particle_renderer.hpp"

#include <cstddef>

#include "particle_vertex.hpp"
#include "shaders.hpp"

namespace view {

namespace {

constexpr int shadow_texels = 2048;

/// The plane to cut at, as the shader wants it; relative to the World's origin.
void set_cut(const GlProgram& program, const Frame& frame, const Look& look) {
  float axis[3] = {0, 0, 0};
  double at = 1;
  if (look.cut_axis >= 0) {
    const double origin[3] = {frame.origin.x, frame.origin.y, frame.origin.z};
    axis[look.cut_axis] = 1;
    at = static_cast<double>(look.cut_at) - origin[look.cut_axis];
  }
  program.set("cut", axis[0], axis[1], axis[2], static_cast<float>(at));
  const auto radius = static_cast<float>(frame.radius);
  program.set("radii", radius * look.liquid_size, radius * look.solid_size);
}

GLuint make_depth_texture() {
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, shadow_texels, shadow_texels, 0, GL_DEPTH_COMPONENT,
               GL_UNSIGNED_INT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  return texture;
}

/// Directions and points of the eye back to the World's axes: the inverse of a rigid placement.
Mat4 inverse_rigid(const Mat4& m) {
  Mat4 r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r.at(i, j) = m.at(j, i);
    for (int j = 0; j < 3; ++j) r.at(i, 3) -= m.at(j, i) * m.at(j, 3);
  }
  r.at(3, 3) = 1;
  return r;
}

Vec3d turned(const Mat4& m, const Vec3d& v) {
  const auto row = [&](int i) {
    return static_cast<double>(m.at(i, 0)) * v.x + static_cast<double>(m.at(i, 1)) * v.y +
           static_cast<double>(m.at(i, 2)) * v.z;
  };
  return {row(0), row(1), row(2)};
}

}  // namespace

ParticleRenderer::ParticleRenderer()
    : spheres_("spheres", std::string(shaders::shadow) + shaders::particle, shaders::particle_vertex,
               shaders::particle_fragment),
      casters_("shadows of spheres", shaders::particle, shaders::caster_vertex, shaders::caster_fragment) {
  glGenVertexArrays(1, &layout_);
  glGenTextures(1, &colors_);
  set_colors(color_table());
  depth_ = make_depth_texture();
  glGenFramebuffers(1, &target_);
  glBindFramebuffer(GL_FRAMEBUFFER, target_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

ParticleRenderer::~ParticleRenderer() {
  glDeleteFramebuffers(1, &target_);
  glDeleteTextures(1, &depth_);
  glDeleteTextures(1, &colors_);
  glDeleteVertexArrays(1, &layout_);
}

void ParticleRenderer::set_colors(const ColorTable& table) {
  glBindTexture(GL_TEXTURE_2D, colors_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, table_width, color_choices, 0, GL_RGB, GL_UNSIGNED_BYTE,
               table.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void ParticleRenderer::read(unsigned buffer) const {
  const auto offset = [](std::size_t bytes) { return reinterpret_cast<const void*>(bytes); };
  const GLsizei stride = sizeof(ParticleVertex);
  glBindVertexArray(layout_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, stride, offset(0));
  glVertexAttribPointer(1, 1, GL_FLOAT, GL_FALSE, stride, offset(offsetof(ParticleVertex, temperature)));
  glVertexAttribIPointer(2, 1, GL_UNSIGNED_INT, stride, offset(offsetof(ParticleVertex, tag)));
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
}

void ParticleRenderer::cast(const Frame& frame, const Look& look, unsigned buffer, std::size_t count) const {
  glBindFramebuffer(GL_FRAMEBUFFER, target_);
  glViewport(0, 0, shadow_texels, shadow_texels);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glClear(GL_DEPTH_BUFFER_BIT);
  if (look.shadows) {
    casters_.use();
    casters_.set("shadow_matrix", frame.shadow);
    set_cut(casters_, frame, look);
    casters_.set("disc", static_cast<float>(frame.shadow_scale * shadow_texels * 0.5),
                 static_cast<float>(frame.shadow_depth * 0.5));
    glEnable(GL_PROGRAM_POINT_SIZE);
    read(buffer);
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count));
  }
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, frame.viewport.width, frame.viewport.height);
}

void ParticleRenderer::bind_shadows(const GlProgram& program, const Frame& frame, const Look& look) const {
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, depth_);
  glActiveTexture(GL_TEXTURE0);
  program.set("shadow_map", 1);
  program.set("shadow_matrix", frame.shadow);
  program.set("shadows", look.shadows ? 1.0f : 0.0f);
}

void ParticleRenderer::draw(const Frame& frame, const Look& look, unsigned buffer, std::size_t count) const {
  const Range& range = look.range();
  spheres_.use();
  bind_shadows(spheres_, frame, look);
  set_cut(spheres_, frame, look);
  spheres_.set("view", frame.view);
  spheres_.set("projection", frame.projection);
  spheres_.set("to_world", inverse_rigid(frame.view));
  spheres_.set("height", static_cast<float>(frame.viewport.height));
  spheres_.set("viewport", static_cast<float>(frame.viewport.width),
               static_cast<float>(frame.viewport.height));
  spheres_.set("color_by", static_cast<int>(look.by));
  spheres_.set("range", static_cast<float>(range.low), static_cast<float>(range.high));
  spheres_.set("sun", turned(frame.view, frame.to_light));
  spheres_.set("up", turned(frame.view, frame.up));
  spheres_.set("colors", 0);
  glBindTexture(GL_TEXTURE_2D, colors_);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  read(buffer);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count));
  glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
}

}  // namespace view
