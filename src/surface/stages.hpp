// SPDX-License-Identifier: Apache-2.0
// The surface from particles to mesh. Nothing here waits: items found are counted, and if there are more
// than the buffers hold, the host repeats the call with larger ones.
#pragma once

#include <type_traits>
#include <utility>

#include "surface/bodies.hpp"
#include "surface/mesh_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

/// Calls f(whether an axis is periodic), known when f is compiled: few are, and the others need fewer
/// registers.
template <class T, class Function>
void with_periods(const SurfaceFrame<T>& w, const Function& f) {
  if (w.period.x > T(0) || w.period.y > T(0) || w.period.z > T(0)) f(std::true_type{});
  else f(std::false_type{});
}

/// Particles into cells; which blocks of nodes lie near the surface.
template <class E, class T>
void blocks(E& ex, const SurfaceFrame<T>& w) {
  ex.for_each(w.particles, SurfaceKeysBody<T>{w});
  ex.sort(w.particles, w.grid.key_bits, w.key, w.slot, w.key_out, w.slot_out);
  ex.for_each(w.particles, SurfaceHeadBody<T>{w});
  ex.scan(w.particles, SurfaceCountsBody{w.group_of}, w.group_of);
  ex.for_each(w.particles, SurfaceGroupsBody<T>{w});
  ex.for_each(std::uint64_t{9} * w.max_groups, SurfaceRowsBody<T>{w});
  with_periods(w, [&](auto periodic) {
    ex.gather(w.particles, SurfaceShareBody<T, periodic()>{w});
    if (w.anisotropic) ex.gather(w.particles, SurfaceShapeBody<T, periodic()>{w});
  });
  ex.for_each(w.max_groups, SurfaceMarkBody<T>{w});
  ex.for_each(w.max_groups, SurfaceDeepBody<T>{w});
  const std::uint64_t cells = std::uint64_t{27} * w.max_groups;
  ex.for_each(cells, SurfaceOwnsBody<T>{w});
  ex.scan(cells, SurfaceCountsBody{w.owns}, w.owns);
  ex.for_each(cells, SurfaceBlocksBody<T>{w});
  ex.for_each(std::uint64_t{27} * w.max_blocks, SurfaceLinksBody<T>{w});
}

template <bool Anisotropic, bool Periodic, class E, class T>
void nodes(E& ex, const SurfaceFrame<T>& w) {
  const auto pass = [&](const auto& body) {
    ex.gather(std::uint64_t{w.max_blocks} * body.lines_of_block(), body);
  };
  if (w.coarse_first) pass(SurfaceNodesBody<T, Anisotropic, Periodic, 2>{w});
  pass(SurfaceNodesBody<T, Anisotropic, Periodic, 1>{w});
}

template <class E, class T>
void build(E& ex, const SurfaceFrame<T>& w, int smoothing) {
  blocks(ex, w);
  with_periods(w, [&](auto periodic) {
    if (w.anisotropic) nodes<true, periodic()>(ex, w);
    else nodes<false, periodic()>(ex, w);
  });
  const std::uint64_t all = std::uint64_t{w.max_blocks} * w.grid.volume;
  ex.for_each(all / static_cast<std::uint64_t>(w.grid.side), SurfaceCodeBody<T>{w});
  ex.scan(all, SurfaceCountBody{w.code, w.cases}, w.ends);
  ex.for_each(all, SurfaceEmitBody<T>{w});
  ex.for_each(w.max_vertices, SurfaceVertexBody<T>{w});
  Vec4<T>*now = w.vertex, *next = w.vertex_next;
  for (int pass = 0; pass < smoothing; ++pass) {
    ex.for_each(w.max_vertices, SurfaceSmoothBody<T>{w, now, next});
    std::swap(now, next);
  }
  ex.gather(w.max_vertices, SurfaceAttributesBody<T>{w, now});
  ex.for_each(1, SurfaceDrawBody<T>{w});
}

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
