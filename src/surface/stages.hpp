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
  ex.for_each(w.max_groups, SurfaceDeepBody<T>{w});
  const std::uint64_t cells = std::uint64_t{27} * w.max_groups;
  ex.for_each(cells, SurfaceOwnsBody<T>{w});
  ex.scan(cells, SurfaceOwnsCountBody{w.owns}, w.owns);
  ex.for_each(cells, SurfaceBlocksBody<T>{w});
  ex.for_each(std::uint64_t{27} * w.max_blocks, SurfaceLinksBody<T>{w});
}

template <class E, class T>
void build(E& ex, const SurfaceFrame<T>& w, int smoothing) {
  blocks(ex, w);
  const std::uint64_t nodes = std::uint64_t{w.max_blocks} * w.grid.volume;
  ex.for_each(nodes, SurfaceNodesBody<T>{w});
  ex.for_each(nodes, SurfaceCodeBody<T>{w});
  ex.scan(nodes, SurfaceVertexCountBody{w.code}, w.vertex_end);
  ex.scan(nodes, SurfaceTriangleCountBody{w.code, w.cases}, w.triangle_end);
  ex.for_each(nodes, SurfaceEmitBody<T>{w});
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
