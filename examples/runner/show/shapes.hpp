// SPDX-License-Identifier: Apache-2.0
// What a frame looks like: surfaces where they are known, balls where only particles are.
#pragma once

#include <cstdint>
#include <vector>

#include "meltsim/types.hpp"
#include "particle_files.hpp"
#include "show/camera.hpp"

namespace runner {

/// A closed surface; arrays per vertex are parallel.
struct Mesh {
  std::vector<meltsim::Vec3f> position,
      normal;                            ///< [m] relative to the origin of its FrameShapes; unit, outward
  std::vector<float> temperature;        ///< [degrees Celsius]
  std::vector<std::uint32_t> body;       ///< 1 + index; 0 = liquid
  std::vector<std::uint32_t> triangles;  ///< 3 vertices each, counter-clockwise from outside
  bool empty() const { return triangles.empty(); }
};

struct Ball {
  meltsim::Vec3f center;
  float radius;
  float temperature;
  std::uint32_t body;
  bool solid;
};

struct FrameShapes {
  double time = 0;        ///< [s]
  meltsim::Vec3d origin;  ///< [m]; what follows is relative to it
  Mesh liquid, solid;
  std::vector<Ball> balls;  ///< what the meshes do not show
};

/// Particles as balls; those of phases that a mesh shows are left out.
void add_balls(FrameShapes& shapes, const std::vector<FrameParticle>& particles, double spacing);
/// In world coordinates.
Box box_of(const FrameShapes& shapes);

}  // namespace runner
