// SPDX-License-Identifier: Apache-2.0
// Rows and planes of members (physics/shape_matching.hpp: BoxSums): their members, walking them, and what their sums
// are relative to. The row about a vertex are the live ones within w of it along x, the plane about it the rows about
// those within w along y. A vertex that has melted has them, too; where no vertex ever was, there are none.
// Regions that are made of such planes are told when they are filled (topology/region_bodies.hpp: is_boxed).
#pragma once

#include "frame/lattice.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

using core::BodyRow;
using core::Frame;
using core::none;

/// A vertex that shape matching moves: live and of a free body.
template <class T>
MELTSIM_HD bool moves(const Frame<T>& w, std::uint64_t v) {
  return w.f.vertex_state[v] == core::vertex_live && w.f.bodies[w.f.vertex_body[v]].motion == core::body_free;
}

/// Whether rows and planes about v are summed.
template <class T>
MELTSIM_HD bool has_boxes(const Frame<T>& w, std::uint64_t v) {
  const BodyRow& b = w.f.bodies[w.f.vertex_body[v]];
  return b.motion == core::body_free && b.region_half_width >= w.row_width;
}

/// Whether v moves and its region is summed by planes. After lsm.gather.
template <class T>
MELTSIM_HD bool is_boxed(const Frame<T>& w, std::uint64_t v) {
  return moves(w, v) && w.f.vertex_velocity[v].w > T(0);
}

/// Vertex at `steps` along an axis from v, or none.
template <int Axis, class T>
MELTSIM_HD std::uint32_t vertex_along(const Frame<T>& w, std::uint64_t v, const BodyRow& b, int steps) {
  const std::int64_t stride = Axis == 0 ? 1 : Axis == 1 ? b.stride_y : b.stride_z;
  const std::uint32_t n = w.f.site_vertex[static_cast<std::int64_t>(w.f.vertex_site[v]) + steps * stride];
  return core::is_vertex(n) ? n : none;
}

/// The live ones of the row about v: bit k is the one at k - w.
template <class T>
MELTSIM_HD std::uint32_t live_in_row(const Frame<T>& w, std::uint64_t v) {
  return w.f.row_live[v] & ~core::row_changed;
}

/// visit(vertex, k) for them.
template <int Half, class T, class Visit>
MELTSIM_HD void walk_row(const Frame<T>& w, std::uint64_t v, const BodyRow& b, const Visit& visit) {
  const int h = Half != 0 ? Half : b.region_half_width;
  const std::uint32_t live = live_in_row(w, v);
  for (int k = -h; k <= h; ++k)
    if (((live >> (k + h)) & 1u) != 0u) visit(vertex_along<0>(w, v, b, k), k);
}
template <class T, class Visit>
MELTSIM_HD void for_each_in_row(const Frame<T>& w, std::uint64_t v, const Visit& visit) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  if (b.region_half_width == 2) walk_row<2>(w, v, b, visit);
  else walk_row<0>(w, v, b, visit);
}

/// A live vertex of the row (Axes = 1) or plane (2) about v, v itself if it can be; none where there is none.
template <int Axes, class T>
MELTSIM_HD std::uint32_t someone_in(const Frame<T>& w, std::uint64_t v) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  const int h = b.region_half_width;
  for (int k = 0; k <= (Axes == 1 ? 0 : 2 * h); ++k) {
    const int dy = (k & 1) != 0 ? (k + 1) / 2 : -(k / 2);  // 0, 1, -1, 2, ...
    const std::uint32_t row = dy == 0 ? static_cast<std::uint32_t>(v) : vertex_along<1>(w, v, b, dy);
    const std::uint32_t live = row == none ? 0u : live_in_row(w, row);
    if (((live >> h) & 1u) != 0u) return row;
    if (live != 0u) return vertex_along<0>(w, row, b, lowest_bit(live) - h);
  }
  return none;
}

/// Reference of the sums of a box: position and velocity of one of its members.
template <class T>
struct BoxOrigin {
  Vec3<T> position{}, velocity{};
  bool exists = false;
};
template <int Axes, class T>
MELTSIM_HD BoxOrigin<T> box_origin(const Frame<T>& w, std::uint64_t v) {
  Vec4<T> x = w.f.vertex_position[v];
  std::uint64_t who = v;
  if (!(x.w > T(0))) {  // does not move
    who = someone_in<Axes>(w, v);
    if (who == none) return {};
    x = w.f.vertex_position[who];
  }
  return {xyz(x), xyz(w.f.vertex_velocity[who]), true};
}

/// visit(vertex, k, origin) for the non-empty rows (Axes = 1) or planes (2) within w of v along the next axis.
template <int Axes, int Half, class T, class Visit>
MELTSIM_HD void walk_boxes(const Frame<T>& w, std::uint64_t v, const BodyRow& b, const Visit& visit) {
  const int h = Half != 0 ? Half : b.region_half_width;
  for (int k = -h; k <= h; ++k) {
    const std::uint32_t box = vertex_along<Axes>(w, v, b, k);
    if (box == none) continue;
    const BoxOrigin<T> origin = box_origin<Axes>(w, box);
    if (origin.exists) visit(box, k, origin);
  }
}
template <int Axes, class T, class Visit>
MELTSIM_HD void for_each_box(const Frame<T>& w, std::uint64_t v, const Visit& visit) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  if (b.region_half_width == 2) walk_boxes<Axes, 2>(w, v, b, visit);
  else walk_boxes<Axes, 0>(w, v, b, visit);
}

/// |R_v|.
template <class T>
MELTSIM_HD std::uint32_t region_members(const Frame<T>& w, std::uint64_t v) {
  return w.f.region_members[v] & ~core::boxed_region;
}

/// Members of v's region in layer dz.
template <class T>
MELTSIM_HD std::uint32_t layer_members(const Frame<T>& w, std::uint64_t v, int dz) {
  const int h = w.f.bodies[w.f.vertex_body[v]].region_half_width;
  const auto side = static_cast<std::uint32_t>(2 * h + 1), all = side * side;
  if (region_members(w, v) == all * side) return all;
  const std::uint32_t* mask = w.f.region_mask + v * w.region_words;
  const std::uint32_t first = core::region_bit(h, -h, -h, dz);
  std::uint32_t n = 0;
  for (std::uint32_t at = 0; at < all; at += 31u)
    n += popcount(core::mask_bits(mask, w.region_words, first + at, minimum(all - at, 31u)));
  return n;
}

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
