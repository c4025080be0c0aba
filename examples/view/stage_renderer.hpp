// SPDX-License-Identifier: Apache-2.0
// Everything around the particles: backdrop, floor with a grid, edges of the domain.
#pragma once

#include "gl_program.hpp"
#include "look.hpp"
#include "particle_renderer.hpp"

namespace view {

class StageRenderer {
 public:
  explicit StageRenderer(const ParticleRenderer& particles);
  ~StageRenderer();
  StageRenderer(const StageRenderer&) = delete;
  StageRenderer& operator=(const StageRenderer&) = delete;

  void draw_behind(const Frame& frame) const;  ///< first: fills the window
  void draw_around(const Frame& frame, const Look& look, const meltsim::Box& box) const;  ///< after particles

 private:
  void draw_floor(const Frame& frame, const Look& look, const meltsim::Box& box) const;
  void draw_edges(const Frame& frame, const meltsim::Box& box) const;

  const ParticleRenderer& particles_;
  GlProgram backdrop_, floor_, lines_;
  GLuint empty_ = 0, edges_ = 0, edge_points_ = 0;
};

/// 1, 2 or 5 times a power of ten: some tens of lines across `extent`.
double grid_step(double extent);

}  // namespace view
