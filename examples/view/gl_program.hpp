// SPDX-License-Identifier: Apache-2.0
// A linked pair of shaders. Failures are runner::Failure: without them there is no picture.
#pragma once

#include <epoxy/gl.h>

#include <string>

#include "camera.hpp"

namespace view {

class GlProgram {
 public:
  /// `shared` stands before both sources, after the version line.
  GlProgram(const char* name, const std::string& shared, const char* vertex, const char* fragment);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const { glUseProgram(id_); }
  // Of the program in use.
  void set(const char* uniform, const Mat4& value) const;
  void set(const char* uniform, const Vec3d& value) const;
  void set(const char* uniform, float value) const;
  void set(const char* uniform, float a, float b) const;
  void set(const char* uniform, float a, float b, float c, float d) const;
  void set(const char* uniform, int value) const;

 private:
  GLint location(const char* uniform) const { return glGetUniformLocation(id_, uniform); }
  GLuint id_ = 0;
};

}  // namespace view
