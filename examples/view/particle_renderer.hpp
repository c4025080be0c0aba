// SPDX-License-Identifier: Apache-2.0
// Particles as shaded spheres, and the shadows they cast.
#pragma once

#include "gl_program.hpp"
#include "look.hpp"

namespace view {

class ParticleRenderer {
 public:
  ParticleRenderer();
  ~ParticleRenderer();
  ParticleRenderer(const ParticleRenderer&) = delete;
  ParticleRenderer& operator=(const ParticleRenderer&) = delete;

  void set_colors(const ColorTable& table);
  /// Draws `count` ParticleVertex of `buffer` into the shadow map.
  void cast(const Frame& frame, const Look& look, unsigned buffer, std::size_t count) const;
  /// Draws them into the window.
  void draw(const Frame& frame, const Look& look, unsigned buffer, std::size_t count) const;
  /// Makes the shadow map known to a program in use.
  void bind_shadows(const GlProgram& program, const Frame& frame, const Look& look) const;

 private:
  void read(unsigned buffer) const;

  GlProgram spheres_, casters_;
  GLuint layout_ = 0, colors_ = 0, depth_ = 0, target_ = 0;
};

}  // namespace view
