// SPDX-License-Identifier: Apache-2.0
// The surface of a World as a triangle mesh: World::surface().
#pragma once

#include <cstdint>
#include <vector>

#include "meltsim/handle.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

/// The particles whose surface is meshed.
enum class SurfaceOf {
  liquid,  ///< all liquid; where it touches a solid, see SurfaceDesc::closed_at_solids
  solids,  ///< all solid particles, as one
  body     ///< the solid particles of one body
};

/// The shape of a particle's contribution to the field.
enum class SurfaceKernel {
  isotropic,   ///< a ball: round drops, edges rounded by half a spacing
  anisotropic  ///< an ellipsoid along its neighbours (Yu & Turk 2013): flatter and smoother; several times
               ///< the cost
};
/// What World::surface() meshes, and how.
struct SurfaceDesc {
  SurfaceOf of = SurfaceOf::liquid;  ///< whose surface
  BodyId body;                       ///< for SurfaceOf::body: which body
  double cell = 0;  ///< edge of the cells of marching cubes [m], 1/16 to 2 spacings; 0 = half a spacing
  SurfaceKernel kernel = SurfaceKernel::isotropic;  ///< contribution of a particle
  int smoothing = 4;  ///< smoothing passes over the mesh, 0 to 100; they keep the volume
  /// For SurfaceOf::liquid. False: the mesh of the solids is the interface of both; the liquid's mesh omits it and
  /// ends inside the solids (by a third of a cell, at most a quarter of a spacing), so that no two sheets coincide
  /// and no gap is visible between them: draw both. True: the liquid's mesh covers the interface too, is closed and
  /// has a volume; there its sheet coincides with that of the solids, and renderers show artefacts.
  bool closed_at_solids = false;
  /// For World::surface_view() on CUDA. False: nothing waits. The size of the mesh then stays on the device: draw it by
  /// SurfaceView::draw. The first surface of a kind (`of`, `kernel`) waits all the same, as does one for which arrays must grow.
  bool wait = true;
};

/// Arguments of an indexed draw that reads them from the device: the layout of VkDrawIndexedIndirectCommand,
/// DrawElementsIndirectCommand (OpenGL) and D3D12_DRAW_INDEXED_ARGUMENTS.
struct SurfaceDraw {
  std::uint32_t indices = 0;         ///< 3 per triangle; 0 where there was not room for the mesh
  std::uint32_t instances = 1;       ///< always
  std::uint32_t first_index = 0;     ///< always
  std::int32_t vertex_offset = 0;    ///< always
  std::uint32_t first_instance = 0;  ///< always
};

/// A surface mesh: every edge belongs to two triangles, except where a liquid's mesh ends inside a solid
/// (SurfaceDesc::closed_at_solids). Vertices are shared. Arrays per vertex are parallel.
struct SurfaceMesh {
  Vec3d origin;                    ///< add it to positions [m]; 0 unless coordinates are too large for float
  std::vector<Vec3f> position;     ///< [m]
  std::vector<Vec3f> normal;       ///< unit, outward
  std::vector<float> temperature;  ///< [degrees Celsius], kernel average of nearby particles
  std::vector<float> liquid_fraction;  ///< 0 solid .. 1 liquid, share of the latent heat; kernel average too
  std::vector<std::uint32_t> body;     ///< 0 = liquid, else body index + 1
  /// MaterialId::index of the particle with the largest weight there; of two with equal weights, the first in
  /// order of cell, then id. Colours then change from vertex to vertex, not in between.
  std::vector<std::uint32_t> material;
  std::vector<std::uint32_t> triangles;  ///< 3 vertices per triangle, counter-clockwise seen from outside
};

/// A surface where the backend made it, for hosts that go on with it there: World::surface_view(). Pointers are null and
/// counts 0 where there is no such surface. Arrays are those of SurfaceMesh.
struct SurfaceView {
  Backend backend = Backend::cpu;  ///< cuda: pointers are into the device's memory
  void* stream =
      nullptr;   ///< cudaStream_t on CUDA: reads enqueued on it come before what overwrites the arrays
  Vec3d origin;  ///< add it to positions [m]
  std::uint64_t vertices = 0;       ///< number of vertices; where nothing waited: how many there is room for
  std::uint64_t triangles = 0;      ///< number of triangles, likewise; one is 3 entries of `triangle`
  const Vec3f* position = nullptr;  ///< per vertex, from `origin` [m]
  const Vec3f* normal = nullptr;    ///< per vertex, outwards, length 1
  const float* temperature = nullptr;       ///< per vertex [degrees Celsius]
  const float* liquid_fraction = nullptr;   ///< per vertex, 0 to 1
  const std::uint32_t* body = nullptr;      ///< per vertex, as SurfaceMesh::body
  const std::uint32_t* material = nullptr;  ///< per vertex, as SurfaceMesh::material
  const std::uint32_t* triangle = nullptr;  ///< 3 vertices per triangle, counter-clockwise seen from outside
  /// How much of `triangle` to draw: 5 words in the backend's memory. Where nothing waited and the mesh had outgrown its
  /// arrays it says nothing for that once; the next call makes room.
  const SurfaceDraw* draw = nullptr;
  std::uint64_t serial = 0;  ///< for World::check_view()
};

}  // namespace v0
}  // namespace meltsim
