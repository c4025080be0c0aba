// SPDX-License-Identifier: Apache-2.0
// Kernels of the surface: marching cubes, smoothing, values at vertices. A crossed edge of the
// grid is a vertex, so that triangles share vertices wherever cells share edges.
#pragma once

#include "surface/field.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

/// Which corners of a node's cell are inside and which of its three edges have a vertex: those that are crossed.
/// Where the mesh is not closed at solids, a cell whose corners are all in the liquid or in a solid has no
/// triangles, and an edge has a vertex only if one of the cells around it has triangles. One call per line of nodes
/// along x: a corner is asked once for the two cells beside it.
template <class T>
struct SurfaceCodeBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::int32_t side = w.grid.side;
    const auto line = static_cast<std::uint32_t>(i), along = static_cast<std::uint32_t>(side);
    const std::uint32_t b = line / (along * along), in_block = line % (along * along);
    const bool listed = b < blocks_of(w);
    const Index3 n{0, static_cast<std::int32_t>(in_block % along),
                   static_cast<std::int32_t>(in_block / along)};
    std::uint32_t first[4] = {}, beyond[4] = {};  // nodes where the four lines begin and go on
    for (std::uint32_t c = 0; c < 4u && listed; ++c) {
      const Index3 at = n + Index3{0, static_cast<std::int32_t>(c & 1u), static_cast<std::int32_t>(c >> 1)};
      first[c] = node_at(w, b, at);
      beyond[c] = node_at(w, b, at + Index3{side, 0, 0});
    }
    const auto corners = [&](std::uint32_t x) {  // inside: as bits 0, 2, 4, 6; open: 8 further
      std::uint32_t bits = 0;
      for (std::uint32_t c = 0; c < 4u; ++c) {
        const std::uint32_t node = x == along ? beyond[c] : first[c] < link_inside ? first[c] + x : first[c];
        if (is_inside(w, node)) bits |= 1u << (2u * c);
        if (is_open(w, node)) bits |= 256u << (2u * c);
      }
      return bits;
    };
    const bool leaves_out = w.overlap > T(0);
    std::uint32_t here = listed ? corners(0) : 0u;
    for (std::uint32_t x = 0; x < along; ++x) {
      const std::uint32_t next = listed ? corners(x + 1u) : 0u, both = here | next << 1;
      std::uint32_t code = both & 255u;
      const bool at_solid = leaves_out && code != 0u && code != 255u && both >> 8 == 0u;
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const bool crossed = ((code >> (1u << axis) ^ code) & 1u) != 0u;
        const Index3 at{static_cast<std::int32_t>(x), n.y, n.z};
        if (crossed && (!at_solid || open_around(b, at, axis))) code |= 1u << (8 + axis);
      }
      w.code[line * along + x] = at_solid ? code | core::code_at_solid : code;
      here = next;
    }
  }

  /// Whether any corner of the four cells around an edge is open.
  MELTSIM_HD bool open_around(std::uint32_t b, Index3 n, std::uint32_t axis) const {
    const Index3 u = corner_offset(1u << (axis + 1u) % 3u), v = corner_offset(1u << (axis + 2u) % 3u);
    for (std::int32_t i = -1; i <= 1; ++i)
      for (std::int32_t j = -1; j <= 1; ++j)
        for (std::uint32_t end = 0; end < 2u; ++end) {
          const Index3 along = corner_offset(end << axis);
          if (is_open(w, node_at(w, b,
                                 {n.x + along.x + i * u.x + j * v.x, n.y + along.y + i * u.y + j * v.y,
                                  n.z + along.z + i * u.z + j * v.z})))
            return true;
        }
    return false;
  }
};

MELTSIM_HD std::uint32_t crossed_edges(std::uint32_t code) {
  return (code >> 8 & 1u) + (code >> 9 & 1u) + (code >> 10 & 1u);
}

/// Vertices in the low half, triangles in the high one: one scan for both.
struct SurfaceCountBody {
  const std::uint32_t* code;
  const core::CubeCase* cases;
  MELTSIM_HD std::uint64_t operator()(std::uint64_t i) const {
    const std::uint32_t triangles =
        (code[i] & core::code_at_solid) != 0u ? 0u : cases[code[i] & 255u].triangles;
    return std::uint64_t{triangles} << 32 | crossed_edges(code[i]);
  }
};
MELTSIM_HD std::uint32_t vertex_end(std::uint64_t ends) { return static_cast<std::uint32_t>(ends); }
MELTSIM_HD std::uint32_t triangle_end(std::uint64_t ends) { return static_cast<std::uint32_t>(ends >> 32); }

/// Whether a node's edge has a vertex.
template <class T>
MELTSIM_HD bool has_vertex(const SurfaceFrame<T>& w, std::uint32_t node, std::uint32_t axis) {
  return node < link_inside && (w.code[node] >> (8u + axis) & 1u) != 0u;
}
/// Number of the vertex on a node's edge, which has one, so the node is in a listed block.
template <class T>
MELTSIM_HD std::uint32_t vertex_on(const SurfaceFrame<T>& w, std::uint32_t node, std::uint32_t axis) {
  const std::uint32_t code = w.code[node];
  return vertex_end(w.ends[node]) - crossed_edges(code) + crossed_edges(code & ((256u << axis) - 1u));
}

/// Vertices and triangles of a node's cell.
template <class T>
struct SurfaceEmitBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    if (i + 1 == std::uint64_t{w.max_blocks} * w.grid.volume) {
      w.counts->vertices = vertex_end(w.ends[i]);
      w.counts->triangles = triangle_end(w.ends[i]);
    }
    const std::uint32_t code = w.code[i];
    if (code == 0u || code == 255u) return;
    const auto node = static_cast<std::uint32_t>(i);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      if ((code >> (8 + axis) & 1u) == 0u) continue;
      const std::uint32_t v = vertex_on(w, node, axis);
      if (v < w.max_vertices) w.vertex_edge[v] = 4u * node + axis;
    }
    if ((code & core::code_at_solid) != 0u) return;
    const core::CubeCase& cell = w.cases[code & 255u];
    const std::uint32_t end = triangle_end(w.ends[i]), first = end - cell.triangles;
    if (end > w.max_triangles) return;
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

  struct Crossing {
    T t;           ///< share of the edge inside
    bool at_face;  ///< of the domain, not where the set ends
  };
  static MELTSIM_HD T pick(Vec3<T> p, std::uint32_t axis) {
    return axis == 0u ? p.x : axis == 1u ? p.y : p.z;
  }
  /// Crossing of the edge from the node at x upwards; `in` and `out` are the values at its ends inside and outside.
  MELTSIM_HD Crossing crossed(Vec3<T> x, std::uint32_t axis, bool low_in, Values in, Values out) const {
    // The first of the surfaces that close the set here.
    T t = T(1);
    if (!(out.all > T(0))) t = minimum(t, physics::edge_crossing(in.all, out.all));
    if (!(out.solid > T(0))) t = minimum(t, physics::edge_crossing(in.solid, out.solid));
    const T low = pick(x, axis), high = low + w.grid.cell;
    const T from = low_in ? low : high, to = low_in ? high : low;
    const T face = pick(low_in ? w.clip_max : w.clip_min, axis);
    if (low_in ? to < face : to > face) return {t, false};
    const T at = physics::edge_crossing(std::fabs(face - from), face == from ? T(-1) : -std::fabs(to - face));
    return {minimum(t, at), !(t < at)};
  }

  /// How far from the low node an edge is crossed, t of it inside [m].
  MELTSIM_HD T from_low(T t, bool low_in, T further = T(0)) const {
    const T margin = static_cast<T>(physics::edge_margin);
    t = clamp(t, margin, T(1) - margin) + further;
    return (low_in ? t : T(1) - t) * w.grid.cell;
  }

  /// A vertex p on a face of the domain, of the node n inside. Where that node has vertices on another face, too, one of
  /// the two is moved into the edge between the faces, which is sharp then: that on the face of the higher axis.
  MELTSIM_HD Vec3<T> into_edge(Vec3<T> p, std::uint32_t b, Index3 n, std::uint32_t axis) const {
    const Vec3<T> x = node_position(w, coordinates(w, w.block_key[b]), n);
    const std::uint32_t node = node_at(w, b, n);
    for (std::uint32_t other = 0; other < axis; ++other) {
      const Index3 along = corner_offset(1u << other);
      T at = T(0);
      std::uint32_t faces = 0;
      for (const bool up : {false, true}) {
        const Index3 beyond = up ? n + along : Index3{n.x - along.x, n.y - along.y, n.z - along.z};
        const std::uint32_t out = node_at(w, b, beyond);
        if (is_inside(w, out)) continue;
        const Vec3<T> low = up ? x : x - Vec3<T>{T(along.x), T(along.y), T(along.z)} * w.grid.cell;
        const Crossing c = crossed(low, other, up, values(node), values(out));
        if (!c.at_face) continue;
        at = pick(low, other) + from_low(c.t, up);
        ++faces;
      }
      if (faces == 1u) (other == 0u ? p.x : p.y) = at;
    }
    return p;
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
    const Crossing crossing = crossed(x, axis, low_in, in, out);
    const bool clip = crossing.at_face;
    // Where the mesh ends in a solid it stays where it is: its interior is not there to smooth against.
    const bool ends = w.overlap > T(0) && !clip && !(out.solid > T(0));
    const T step = from_low(crossing.t, low_in, ends ? w.overlap : T(0));
    Vec3<T> p{x.x + T(along.x) * step, x.y + T(along.y) * step, x.z + T(along.z) * step};
    if (clip) p = into_edge(p, b, low_in ? n : n + along, axis);
    w.vertex[v] = with_w(p, clip || ends ? T(1) : T(0));
    w.ring[v] = ring(static_cast<std::uint32_t>(v), axis, b, n, low_in);
  }

  /// Across the faces on the sides +u, +v, -u, -v of the edge; itself where the mesh ends.
  MELTSIM_HD core::SurfaceRing ring(std::uint32_t own, std::uint32_t axis, std::uint32_t b, Index3 n,
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
      const std::uint32_t to = has_vertex(w, low, other) ? vertex_on(w, low, other) : own;
      // Clockwise seen along the axis is counter-clockwise against it.
      r.at[low_in ? k : (4u - k) % 4u] = minimum(to, w.max_vertices - 1u);
    }
    return r;
  }
};

/// Both steps of a pass: a vertex works out where the first takes those it is joined to, which costs less
/// than a launch.
template <class T>
struct SurfaceSmoothBody {
  SurfaceFrame<T> w;
  const Vec4<T>* from;
  Vec4<T>* to;

  struct Moved {
    Vec3<T> x;
    bool fixed;  ///< on a face of the domain: flat already
  };
  /// Where the first step takes a vertex.
  MELTSIM_HD Moved inward(std::uint64_t v, const core::SurfaceRing& r) const {
    const Vec4<T> x = from[v];
    if (x.w != T(0)) return {xyz(x), true};
    const Vec3<T> mean =
        (xyz(from[r.at[0]]) + xyz(from[r.at[1]]) + xyz(from[r.at[2]]) + xyz(from[r.at[3]])) * T(0.25);
    return {physics::smoothed(xyz(x), mean, static_cast<T>(physics::smooth_in)), false};
  }
  MELTSIM_HD Vec3<T> inward(std::uint32_t v) const { return inward(v, w.ring[v]).x; }

  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (v >= vertices_of(w)) return;
    const core::SurfaceRing r = w.ring[v];
    const Moved own = inward(v, r);
    if (own.fixed) {
      to[v] = with_w(own.x, T(1));
      return;
    }
    const Vec3<T> mean = (inward(r.at[0]) + inward(r.at[1]) + inward(r.at[2]) + inward(r.at[3])) * T(0.25);
    to[v] = with_w(physics::smoothed(own.x, mean, static_cast<T>(physics::smooth_out)), T(0));
  }
};

/// All of the mesh where there was room for all that it is made from, else none: parts of it would be holes.
template <class T>
struct SurfaceDrawBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    const core::SurfaceCounts& c = *w.counts;
    const bool fits = c.groups <= w.max_groups && c.blocks <= w.max_blocks && c.vertices <= w.max_vertices &&
                      c.triangles <= w.max_triangles;
    *w.draw = {};
    w.draw->indices = fits ? 3 * c.triangles : 0u;
  }
};

/// Writes the values of a vertex.
template <class T>
struct SurfaceAttributesBody {
  SurfaceFrame<T> w;
  const Vec4<T>* vertex;

  static constexpr bool shared = true;
  struct Sum {
    T weight{}, temperature{}, fraction{}, heaviest{};
    std::uint32_t particle = none;  ///< the heaviest; of two the first in order of cell, then id
    MELTSIM_HD void add(const Sum& o) {
      weight += o.weight;
      temperature += o.temperature;
      fraction += o.fraction;
      if (!(o.heaviest > heaviest)) return;
      heaviest = o.heaviest;
      particle = o.particle;
    }
  };
  MELTSIM_HD Sum average(std::uint64_t v, std::uint32_t part, std::uint32_t parts, std::uint8_t kinds) const {
    const Range* const rows = w.block_rows + std::uint64_t{9} * ((w.vertex_edge[v] >> 2) / w.grid.volume);
    Sum s;
    visit_around<false>(w, rows, part, parts, xyz(vertex[v]), [&](std::uint32_t j, Vec3<T>, T r2) {
      if ((w.mark[j] & kinds) == 0u) return;
      const T weight = w.point[j].w * physics::kernel_shape(w.field.kernel, std::sqrt(r2));
      const core::SurfaceHeat<T> heat = w.heat[j];
      s.add({weight, weight * heat.temperature, weight * heat.liquid_fraction, weight, j});
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
    const T sign = is_inside(w, edge >> 2) ? T(1) : T(-1);
    return {axis == 0u ? sign : T(0), axis == 1u ? sign : T(0), axis == 2u ? sign : T(0)};
  }

  MELTSIM_HD Sum part(std::uint64_t v, std::uint32_t part, std::uint32_t parts) const {
    if (v >= vertices_of(w)) return {};
    return average(v, part, parts, w.only_solids != 0u ? core::mark_solid : core::mark_liquid);
  }
  MELTSIM_HD void finish(std::uint64_t v, Sum s) const {
    if (v >= vertices_of(w)) return;
    if (!(s.weight > T(0))) s = average(v, 0, 1, core::mark_solid | core::mark_liquid);
    const T scale = s.weight > T(0) ? T(1) / s.weight : T(0);
    w.out_position[v] = cast<float>(xyz(vertex[v]) - w.shift);
    w.out_normal[v] = cast<float>(normal(v));
    w.out_temperature[v] = static_cast<float>(s.temperature * scale);
    w.out_fraction[v] = static_cast<float>(s.fraction * scale);
    const std::uint32_t tag = s.particle != none ? w.tag[w.slot_out[s.particle]] : 0u;
    w.out_body[v] = w.only_solids != 0u && s.particle != none ? body_of(tag) : 0u;
    w.out_material[v] = s.particle != none ? material_of(tag) : 0u;
  }
};

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
