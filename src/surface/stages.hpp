// SPDX-License-Identifier: Apache-2.0
// The surface from particles to mesh. Nothing here waits: what is found is counted, and where it was more
// than there is room for the host does it again with more.
#pragma once

#include "surface/bodies.hpp"
#include "surface/mesh_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

/// Particles into cells; which blocks of nodes lie near the surface.
template <class E, class T>
void blocks(E& ex, const SurfaceFrame<T>& w) {
  ex.for_each(w.particles, SurfaceKeysBody<T>{w});
  ex.sort(w.particles, w.grid.key_bits, w.key, w.slot, w.key_out, w.slot_out);
  ex.scan(w.particles, SurfaceHeadBody<T>{w}, w.group_of);
  ex.for_each(w.particles, SurfaceGroupsBody<T>{w});
  ex.for_each(std::uint64_t{9} * w.max_groups, SurfaceRowsBody<T>{w});
  ex.for_each(w.particles, SurfaceShareBody<T>{w});
  if (w.anisotropic) ex.for_each(w.particles, SurfaceShapeBody<T>{w});
  ex.for_each(w.max_groups, SurfaceDeepBody<T>{w});
  const std::uint64_t cells = std::uint64_t{27} * w.max_groups;
  ex.for_each(cells, SurfaceOwnsBody<T>{w});
  ex.scan(cells, SurfaceOwnsCountBody{w.owns}, w.owns);
  ex.for_each(cells, SurfaceBlocksBody<T>{w});
  ex.for_each(std::uint64_t{27} * w.max_blocks, SurfaceLinksBody<T>{w});
}

template <bool Anisotropic, class E, class T>
void nodes(E& ex, const SurfaceFrame<T>& w) {
  const std::uint64_t half = static_cast<std::uint64_t>(w.grid.side + 1) / 2;
  if (w.coarse_first) ex.for_each(w.max_blocks * half * half * half, SurfaceCoarseBody<T, Anisotropic>{w});
  ex.for_each(std::uint64_t{w.max_blocks} * w.grid.volume, SurfaceNodesBody<T, Anisotropic>{w});
}

template <class E, class T>
void build(E& ex, const SurfaceFrame<T>& w, int smoothing) {
  blocks(ex, w);
  if (w.anisotropic) nodes<true>(ex, w);
  else nodes<false>(ex, w);
  const std::uint64_t all = std::uint64_t{w.max_blocks} * w.grid.volume;
  ex.for_each(all, SurfaceCodeBody<T>{w});
  ex.scan(all, SurfaceVertexCountBody{w.code}, w.vertex_end);
  ex.scan(all, SurfaceTriangleCountBody{w.code, w.cases}, w.triangle_end);
  ex.for_each(all, SurfaceEmitBody<T>{w});
  ex.for_each(w.max_vertices, SurfaceVertexBody<T>{w});
  for (int pass = 0; pass < smoothing; ++pass) {
    ex.for_each(w.max_vertices, SurfaceSmoothBody<T>{w, w.vertex, w.vertex_next, T(physics::smooth_in)});
    ex.for_each(w.max_vertices, SurfaceSmoothBody<T>{w, w.vertex_next, w.vertex, T(physics::smooth_out)});
  }
  ex.for_each(w.max_vertices, SurfaceAttributesBody<T>{w, w.vertex});
}

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
