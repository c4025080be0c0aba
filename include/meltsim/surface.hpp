// SPDX-License-Identifier: Apache-2.0
// The surface of a World as a triangle mesh: World::surface().
#pragma once

#include <cstdint>
#include <vector>

#include "meltsim/handle.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

/// Whose surface.
enum class SurfaceOf {
  liquid,  ///< all liquid; where it touches a solid, see SurfaceDesc::closed_at_solids
  solids,  ///< all solid particles, as one
  body     ///< the solid particles of one body
};

/// What a particle's share of the field looks like.
enum class SurfaceKernel {
  isotropic,   ///< a ball: round drops, edges rounded by half a spacing
  anisotropic  ///< an ellipsoid along its neighbours (Yu & Turk 2013): flatter and smoother; several times
               ///< the cost
};

struct SurfaceDesc {
  SurfaceOf of = SurfaceOf::liquid;
  BodyId body;      ///< which one, for SurfaceOf::body
  double cell = 0;  ///< edge of the marching cubes' cells [m], 1/16 to 2 spacings; 0 = half a spacing
  SurfaceKernel kernel = SurfaceKernel::isotropic;
  int smoothing = 4;  ///< passes over the mesh that take out bumps and keep the volume, 0 to 100
  /// Of SurfaceOf::liquid. False: the solids' mesh is the interface of both; the liquid's mesh leaves it out and
  /// ends a little inside the solids (a third of a cell, at most a quarter of a spacing), so that no two sheets
  /// coincide and there is no gap between them: draw both. True: the liquid's mesh covers the interface as well,
  /// is closed and has a volume; its sheet there coincides with the solids', and renderers show artefacts.
  bool closed_at_solids = false;
};

/// A surface: every edge belongs to two triangles, except where a liquid's mesh ends inside a solid
/// (SurfaceDesc::closed_at_solids). Vertices are shared. Arrays per vertex are parallel.
struct SurfaceMesh {
  Vec3d origin;                        ///< add it to positions [m]; zero unless they are too large for float
  std::vector<Vec3f> position;         ///< [m]
  std::vector<Vec3f> normal;           ///< unit, outward
  std::vector<float> temperature;      ///< [degrees Celsius], average of the particles around
  std::vector<float> liquid_fraction;  ///< 0 solid .. 1 liquid: latent heat taken up, likewise
  std::vector<std::uint32_t> body;     ///< 0 = liquid, else body index + 1
  /// MaterialId::index of the particle that weighs most there; of two that weigh the same the one first in
  /// order of cell, then id. So colours change from vertex to vertex, not in between.
  std::vector<std::uint32_t> material;
  std::vector<std::uint32_t> triangles;  ///< 3 vertices per triangle, counter-clockwise seen from outside
};

}  // namespace v0
}  // namespace meltsim
