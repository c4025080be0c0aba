// SPDX-License-Identifier: Apache-2.0
#include "gl_program.hpp"

#include <vector>

#include "failure.hpp"

namespace view {

namespace {

GLuint compile(const char* name, GLenum type, const std::string& shared, const char* source) {
  const GLuint shader = glCreateShader(type);
  const char* parts[] = {"#version 330 core\n", shared.c_str(), source};
  glShaderSource(shader, 3, parts, nullptr);
  glCompileShader(shader);
  GLint good = 0, length = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good != 0) return shader;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::vector<char> log(static_cast<std::size_t>(length) + 1);
  glGetShaderInfoLog(shader, length, nullptr, log.data());
  throw runner::Failure(runner::ExitCode::device,
                        std::string("OpenGL refuses shader ") + name + ": " + log.data());
}

}  // namespace

GlProgram::GlProgram(const char* name, const std::string& shared, const char* vertex, const char* fragment) {
  const GLuint first = compile(name, GL_VERTEX_SHADER, shared, vertex);
  const GLuint second = compile(name, GL_FRAGMENT_SHADER, shared, fragment);
  id_ = glCreateProgram();
  glAttachShader(id_, first);
  glAttachShader(id_, second);
  glLinkProgram(id_);
  glDeleteShader(first);
  glDeleteShader(second);
  GLint good = 0;
  glGetProgramiv(id_, GL_LINK_STATUS, &good);
  if (good != 0) return;
  char log[1024] = "";
  glGetProgramInfoLog(id_, sizeof log, nullptr, log);
  throw runner::Failure(runner::ExitCode::device, std::string("OpenGL cannot link ") + name + ": " + log);
}

GlProgram::~GlProgram() { glDeleteProgram(id_); }

void GlProgram::set(const char* uniform, const Mat4& value) const {
  glUniformMatrix4fv(location(uniform), 1, GL_FALSE, value.m.data());
}
void GlProgram::set(const char* uniform, const Vec3d& v) const {
  glUniform3f(location(uniform), static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
}
void GlProgram::set(const char* uniform, float value) const { glUniform1f(location(uniform), value); }
void GlProgram::set(const char* uniform, float a, float b) const { glUniform2f(location(uniform), a, b); }
void GlProgram::set(const char* uniform, float a, float b, float c, float d) const {
  glUniform4f(location(uniform), a, b, c, d);
}
void GlProgram::set(const char* uniform, int value) const { glUniform1i(location(uniform), value); }

}  // namespace view
