// SPDX-License-Identifier: Apache-2.0
// Kernels of the surface: marching cubes, the mesh smoothed, what its vertices carry. A crossed edge of the
// grid is a vertex, so that triangles share vertices wherever cells share edges.
#pragma once

#include "surface/field.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

/// Which corners of a node's cell are inside and which of its three edges are crossed.
template <class T>
struct SurfaceCodeBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const auto b = static_cast<std::uint32_t>(i / w.grid.volume);
    std::uint32_t code = 0;
    if (b < blocks_of(w)) {
      const Index3 n = node_in_block(static_cast<std::uint32_t>(i % w.grid.volume), w.grid.side);
      const std::int32_t last = w.grid.side - 1;
      const bool within = n.x < last && n.y < last && n.z < last;
      for (std::uint32_t c = 0; c < 8; ++c) {
        const Index3 o = corner_offset(c);
        const auto step = static_cast<std::uint32_t>((o.z * w.grid.side + o.y) * w.grid.side + o.x);
        const bool in = within ? w.inside[i + step] != 0u : is_inside(w, node_at(w, b, n + o));
        if (in) code |= 1u << c;
      }
      for (std::uint32_t axis = 0; axis < 3; ++axis)
        if (((code >> (1u << axis) ^ code) & 1u) != 0u) code |= 1u << (8 + axis);
    }
    w.code[i] = code;
  }
};

MELTSIM_HD std::uint32_t crossed_edges(std::uint32_t code) {
  return (code >> 8 & 1u) + (code >> 9 & 1u) + (code >> 10 & 1u);
}

struct SurfaceVertexCountBody {
  const std::uint32_t* code;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const { return crossed_edges(code[i]); }
};

struct SurfaceTriangleCountBody {
  const std::uint32_t* code;
  const core::CubeCase* cases;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const { return cases[code[i] & 255u].triangles; }
};

/// Number of the vertex on a node's edge; the edge is crossed, so the node is in a listed block.
template <class T>
MELTSIM_HD std::uint32_t vertex_on(const SurfaceFrame<T>& w, std::uint32_t node, std::uint32_t axis) {
  const std::uint32_t code = w.code[node];
  return w.vertex_end[node] - crossed_edges(code) + crossed_edges(code & ((256u << axis) - 1u));
}

/// Vertices and triangles of a node's cell.
template <class T>
struct SurfaceEmitBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    if (i + 1 == std::uint64_t{w.max_blocks} * w.grid.volume) {
      w.counts->vertices = w.vertex_end[i];
      w.counts->triangles = w.triangle_end[i];
    }
    const std::uint32_t code = w.code[i];
    if (code == 0u || code == 255u) return;
    const auto node = static_cast<std::uint32_t>(i);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      if ((code >> (8 + axis) & 1u) == 0u) continue;
      const std::uint32_t v = vertex_on(w, node, axis);
      if (v < w.max_vertices) w.vertex_edge[v] = 4u * node + axis;
    }
    const core::CubeCase& cell = w.cases[code & 255u];
    const std::uint32_t first = w.triangle_end[i] - cell.triangles;
    if (w.triangle_end[i] > w.max_triangles) return;
    const std::uint32_t b = node / w.grid.volume;
    const Index3 n = node_in_block(node % w.grid.volume, w.grid.side);
    for (std::uint32_t k = 0; k < 3u * cell.triangles; ++k) {
      const core::CubeEdge e = core::cube_edge(cell.edge[k]);
      const std::uint32_t low = node_at(w, b, n + corner_offset(e.corner));
      w.out_triangles[std::uint64_t{3} * first + k] = low < link_inside ? vertex_on(w, low, e.axis) : 0u;
    }
  }
};

/// Where an edge is crossed, and what its vertex is joined to.
template <class T>
struct SurfaceVertexBody {
  SurfaceFrame<T> w;

  struct Values {
    T all, solid;
  };
  MELTSIM_HD Values values(std::uint32_t node) const {
    if (node == link_inside) return {T(0.5), T(0.5)};
    if (node == link_outside) return {-w.field.level, w.field.level};
    return {w.value[node], w.two_fields ? w.solid_value[node] : T(1)};
  }

  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (v >= vertices_of(w)) return;
    const std::uint32_t edge = w.vertex_edge[v], node = edge >> 2, axis = edge & 3u, b = node / w.grid.volume;
    const Index3 n = node_in_block(node % w.grid.volume, w.grid.side);
    const Index3 along = corner_offset(1u << axis);
    const std::uint32_t far = node_at(w, b, n + along);
    const bool low_in = is_inside(w, node);
    const Values in = values(low_in ? node : far), out = values(low_in ? far : node);
    const Vec3<T> x = node_position(w, coordinates(w, w.block_key[b]), n);
    const auto pick = [axis](Vec3<T> p) { return axis == 0u ? p.x : axis == 1u ? p.y : p.z; };
    // The first of the surfaces that close the set here.
    T t = T(1);
    if (!(out.all > T(0))) t = minimum(t, physics::edge_crossing(in.all, out.all));
    if (!(out.solid > T(0))) t = minimum(t, physics::edge_crossing(in.solid, out.solid));
    const T from = pick(x) + (low_in ? T(0) : w.grid.cell), to = pick(x) + (low_in ? w.grid.cell : T(0));
    const T face = low_in ? pick(w.clip_max) : pick(w.clip_min);
    const bool leaves = low_in ? !(to < face) : !(to > face);
    bool clip = false;
    if (leaves) {
      const T at =
          physics::edge_crossing(std::fabs(face - from), face == from ? T(-1) : -std::fabs(to - face));
      clip = !(t < at);
      t = minimum(t, at);
    }
    const T margin = static_cast<T>(physics::edge_margin);
    t = clamp(t, margin, T(1) - margin);
    const T step = (low_in ? t : T(1) - t) * w.grid.cell;
    const Vec3<T> p{x.x + T(along.x) * step, x.y + T(along.y) * step, x.z + T(along.z) * step};
    w.vertex[v] = with_w(p, clip ? T(1) : T(0));
    w.ring[v] = ring(node, axis, b, n, low_in);
  }

  /// Across the faces on the sides +u, +v, -u, -v of the edge.
  MELTSIM_HD core::SurfaceRing ring(std::uint32_t node, std::uint32_t axis, std::uint32_t b, Index3 n,
                                    bool low_in) const {
    const Index3 along = corner_offset(1u << axis);
    core::SurfaceRing r;
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t side = (axis + 1u + k % 2u) % 3u;
      Index3 s = corner_offset(1u << side);
      const bool below = k >= 2u;
      if (below) s = {-s.x, -s.y, -s.z};
      const std::uint32_t c = node_at(w, b, n + along + s), d = node_at(w, b, n + s);
      const int joined = core::joined_edge(low_in, !low_in, is_inside(w, c), is_inside(w, d));
      // Low node and axis of the edge that it is joined with.
      std::uint32_t low = d, other = axis;
      if (joined != 2) {
        other = side;
        const Index3 base = joined == 1 ? n + along : n;
        low = below ? (joined == 1 ? c : d) : node_at(w, b, base);
      }
      const std::uint32_t to = low < link_inside ? vertex_on(w, low, other) : 0u;
      // Clockwise seen along the axis is counter-clockwise against it.
      r.at[low_in ? k : (4u - k) % 4u] = minimum(to, w.max_vertices - 1u);
    }
    static_cast<void>(node);
    return r;
  }
};

template <class T>
struct SurfaceSmoothBody {
  SurfaceFrame<T> w;
  const Vec4<T>* from;
  Vec4<T>* to;
  T share;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (v >= vertices_of(w)) return;
    const Vec4<T> x = from[v];
    if (x.w != T(0)) {  // on a face of the domain: flat already
      to[v] = x;
      return;
    }
    const core::SurfaceRing r = w.ring[v];
    const Vec3<T> mean =
        (xyz(from[r.at[0]]) + xyz(from[r.at[1]]) + xyz(from[r.at[2]]) + xyz(from[r.at[3]])) * T(0.25);
    to[v] = with_w(physics::smoothed(xyz(x), mean, share), T(0));
  }
};

/// What a vertex hands out.
template <class T>
struct SurfaceAttributesBody {
  SurfaceFrame<T> w;
  const Vec4<T>* vertex;

  struct Sums {
    T weight{}, temperature{}, fraction{}, heaviest{};
    std::uint32_t particle = none;
  };
  MELTSIM_HD Sums average(const Range* rows, Vec3<T> x, std::uint8_t kinds) const {
    const physics::SphKernel<T>& k = w.field.kernel;
    Sums s;
    visit_rows(rows, [&](std::uint32_t j) {
      const Vec4<T> p = w.point[j];
      const Vec3<T> d = x - xyz(p);
      const T r2 = dot(d, d);
      if (!(r2 < k.support2) || (w.mark[j] & kinds) == 0u) return;
      const T weight = p.w * physics::kernel_shape(k, std::sqrt(r2));
      s.weight += weight;
      s.temperature += weight * w.heat[j].temperature;
      s.fraction += weight * w.heat[j].liquid_fraction;
      if (weight > s.heaviest) {
        s.heaviest = weight;
        s.particle = j;
      }
    });
    return s;
  }

  MELTSIM_HD Vec3<T> normal(std::uint64_t v) const {
    const core::SurfaceRing r = w.ring[v];
    const Vec3<T> n =
        cross(xyz(vertex[r.at[0]]) - xyz(vertex[r.at[2]]), xyz(vertex[r.at[1]]) - xyz(vertex[r.at[3]]));
    const T size = length(n);
    if (size > T(1e-6) * w.grid.cell * w.grid.cell) return n * (T(1) / size);
    // Folded onto itself: the direction of the edge.
    const std::uint32_t edge = w.vertex_edge[v], axis = edge & 3u;
    const T sign = w.inside[edge >> 2] != 0u ? T(1) : T(-1);
    return {axis == 0u ? sign : T(0), axis == 1u ? sign : T(0), axis == 2u ? sign : T(0)};
  }

  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (v >= vertices_of(w)) return;
    const Vec3<T> x = xyz(vertex[v]);
    const Range* const rows = w.block_rows + std::uint64_t{9} * ((w.vertex_edge[v] >> 2) / w.grid.volume);
    Sums s = average(rows, x, w.only_solids != 0u ? core::mark_solid : core::mark_liquid);
    if (!(s.weight > T(0))) s = average(rows, x, core::mark_solid | core::mark_liquid);
    const T scale = s.weight > T(0) ? T(1) / s.weight : T(0);
    w.out_position[v] = cast<float>(x - w.shift);
    w.out_normal[v] = cast<float>(normal(v));
    w.out_temperature[v] = static_cast<float>(s.temperature * scale);
    w.out_fraction[v] = static_cast<float>(s.fraction * scale);
    w.out_body[v] = w.only_solids != 0u && s.particle != none ? body_of(w.tag[w.slot_out[s.particle]]) : 0u;
  }
};

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
