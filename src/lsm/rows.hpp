// SPDX-License-Identifier: Apache-2.0
// Whole regions as rows of members along x (physics/shape_matching.hpp): which rows there are, walking them,
// where what is summed along them is kept, and the kernels that sum it. Regions that lack a site go member by
// member (bodies.hpp).
#pragma once

#include "lsm/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

/// Whether v moves and its own row, in the middle of its region, lacks nobody. A whole region is made of such
/// rows: its members are live, and along x there is a straight path from a row's vertex to each of them.
template <class T>
MELTSIM_HD bool has_whole_row(const Frame<T>& w, std::uint64_t v) {
  if (!moves(w, v)) return false;
  const int h = w.f.bodies[w.f.vertex_body[v]].region_half_width;
  if (h < w.row_width) return false;
  const std::uint32_t side = static_cast<std::uint32_t>(2 * h + 1);
  const std::uint32_t* mask = w.f.region_mask + v * w.region_words;
  return core::mask_bits(mask, w.region_words, core::region_bit(h, -h, 0, 0), side) == (1u << side) - 1u;
}

/// visit(vertex, dx) for the members of v's row. Half: w where the compiler may know it, 0: any.
template <int Half, class T, class Visit>
MELTSIM_HD void walk_row(const Frame<T>& w, std::uint64_t v, const BodyRow& b, const Visit& visit) {
  const int h = Half != 0 ? Half : b.region_half_width;
  const std::uint32_t* vertices = w.f.site_vertex + w.f.vertex_site[v];
  for (int dx = -h; dx <= h; ++dx) visit(vertices[dx], dx);
}
template <class T, class Visit>
MELTSIM_HD void for_each_in_row(const Frame<T>& w, std::uint64_t v, const Visit& visit) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  if (b.region_half_width == 2) walk_row<2>(w, v, b, visit);
  else walk_row<0>(w, v, b, visit);
}

/// visit(vertex of the row, dy, dz) for the rows of v's region, which is whole, in layers [first, last) in z.
/// The next row's vertex is looked up while one is visited, so that no visit waits for two loads in turn.
template <int Half, class T, class Visit>
MELTSIM_HD void walk_rows(const Frame<T>& w, std::uint64_t v, const BodyRow& b, int first, int last,
                          const Visit& visit) {
  const int h = Half != 0 ? Half : b.region_half_width;
  if (first == last) return;
  const std::uint32_t* at = w.f.site_vertex + core::site_at(w.f.vertex_site[v], b, 0, -h, first);
  const std::uint32_t to_layer = b.stride_z - static_cast<std::uint32_t>(2 * h) * b.stride_y;
  std::uint32_t next = *at;
  for (int dz = first; dz < last; ++dz)
    for (int dy = -h; dy <= h; ++dy) {
      const std::uint32_t row = next;
      at += dy < h ? b.stride_y : to_layer;
      if (dy < h || dz + 1 < last) next = *at;
      visit(row, dy, dz);
    }
}
template <class T, class Visit>
MELTSIM_HD void for_each_row(const Frame<T>& w, std::uint64_t v, std::uint32_t part, std::uint32_t parts,
                             const Visit& visit) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  const int h = b.region_half_width;
  const int first = core::layer_of_part(h, part, parts), last = core::layer_of_part(h, part + 1u, parts);
  if (h == 2) walk_rows<2>(w, v, b, first, last, visit);
  else walk_rows<0>(w, v, b, first, last, visit);
}

/// Plane k of what is kept per row.
template <class T>
MELTSIM_HD Vec4<T>& row_plane(const Frame<T>& w, std::uint64_t v, std::uint64_t k) {
  return w.f.region_rows[k * w.vertices + v];
}

template <class T>
MELTSIM_HD void put_row_sums(const Frame<T>& w, std::uint64_t v, const physics::RowSums<T>& r) {
  row_plane(w, v, 0) = with_w(r.mu, r.mass);
  row_plane(w, v, 1) = with_w(r.muq, r.mq);
  row_plane(w, v, 2) = with_w(r.mv, r.muu.mixed.x);
  row_plane(w, v, 3) = with_w(r.muxv, r.muu.mixed.y);
  row_plane(w, v, 4) = with_w(r.muu.diagonal, r.muu.mixed.z);
}
template <class T>
MELTSIM_HD physics::RowSums<T> get_row_sums(const Frame<T>& w, std::uint64_t v) {
  const Vec4<T> mu = row_plane(w, v, 0), muq = row_plane(w, v, 1), mv = row_plane(w, v, 2),
                muxv = row_plane(w, v, 3), muu = row_plane(w, v, 4);
  physics::RowSums<T> r;
  r.mass = mu.w;
  r.mq = muq.w;
  r.mu = xyz(mu);
  r.muq = xyz(muq);
  r.muu = {xyz(muu), {mv.w, muxv.w, muu.w}};
  r.mv = xyz(mv);
  r.muxv = xyz(muxv);
  return r;
}

/// Four planes do: the fifth is left as it was.
template <class T>
MELTSIM_HD void put_row_goals(const Frame<T>& w, std::uint64_t v, const physics::RowGoals<T>& g) {
  row_plane(w, v, 0) = with_w(g.displacement, g.z.x);
  row_plane(w, v, 1) = with_w(g.velocity, g.z.y);
  row_plane(w, v, 2) = with_w(g.spin, g.z.z);
  row_plane(w, v, 3) = with_w(g.y, T(0));
}
template <class T>
MELTSIM_HD physics::RowGoals<T> get_row_goals(const Frame<T>& w, std::uint64_t v) {
  const Vec4<T> displacement = row_plane(w, v, 0), velocity = row_plane(w, v, 1), spin = row_plane(w, v, 2),
                y = row_plane(w, v, 3);
  return {xyz(displacement), xyz(velocity), xyz(spin), xyz(y), {displacement.w, velocity.w, spin.w}};
}

/// Sums over the row of members whose middle a vertex is.
template <class T>
struct RowSumsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!has_whole_row(w, v)) return;
    const Vec3<T> x = xyz(w.f.vertex_position[v]), velocity = xyz(w.f.vertex_velocity[v]);
    physics::RowSums<T> sums;
    for_each_in_row(w, v, [&](std::uint32_t j, int dx) {
      const Vec4<T> xj = w.f.vertex_position[j];
      physics::add_to_row<T>(sums, xj.w, spatial::separation(w.grid, xyz(xj), x), T(dx) * w.c.spacing,
                             xyz(w.f.vertex_velocity[j]) - velocity);
    });
    put_row_sums(w, v, sums);
  }
};

/// What RegionsBody does, of whole regions.
template <class T>
struct WholeRegionsBody {
  Frame<T> w;
  static constexpr bool shared = true;
  using Sum = typename RegionsBody<T>::Sum;
  MELTSIM_HD Sum part(std::uint64_t v, std::uint32_t k, std::uint32_t parts) const {
    Sum sums;
    if (!is_whole(w, v)) return sums;
    const Vec3<T> x = xyz(w.f.vertex_position[v]), velocity = xyz(w.f.vertex_velocity[v]);
    for_each_row(w, v, k, parts, [&](std::uint32_t row, int dy, int dz) {
      const Vec3<T> u = spatial::separation(w.grid, xyz(w.f.vertex_position[row]), x);
      physics::add_row<T>(sums, get_row_sums(w, row), u, T(dy) * w.c.spacing, T(dz) * w.c.spacing,
                          xyz(w.f.vertex_velocity[row]) - velocity);
    });
    return sums;
  }
  MELTSIM_HD void finish(std::uint64_t v, const Sum& sums) const {
    if (is_whole(w, v)) RegionsBody<T>{w}.finish(v, sums);
  }
};

/// What the regions of the row whose middle a vertex is want, so far as it is the same for all.
template <class T>
struct RowGoalsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!has_whole_row(w, v)) return;
    const Vec3<T> x = xyz(w.f.vertex_position[v]);
    physics::RowGoals<T> goals;
    for_each_in_row(w, v, [&](std::uint32_t r, int dx) {
      const core::PlacedFit<T> p = core::get_fit(w, r);
      physics::add_to_row(goals, p.fit, T(-dx) * w.c.spacing, spatial::separation(w.grid, x, p.position));
    });
    put_row_goals(w, v, goals);
  }
};

/// What GoalsBody does, of vertices whose regions are whole: they are in the regions of all of those rows.
template <class T>
struct WholeGoalsBody {
  Frame<T> w;
  static constexpr bool shared = true;
  using Sum = GoalSum<T>;
  MELTSIM_HD Sum part(std::uint64_t v, std::uint32_t k, std::uint32_t parts) const {
    Sum s;
    if (!is_whole(w, v)) return s;
    const Vec3<T> x = xyz(w.f.vertex_position[v]), velocity = xyz(w.f.vertex_velocity[v]);
    const T count = T(2 * w.f.bodies[w.f.vertex_body[v]].region_half_width + 1);
    for_each_row(w, v, k, parts, [&](std::uint32_t row, int dy, int dz) {
      const physics::RowGoals<T> goals = get_row_goals(w, row);
      const Vec3<T> u = spatial::separation(w.grid, x, xyz(w.f.vertex_position[row]));
      s.displacement +=
          physics::row_displacement<T>(goals, count, T(-dy) * w.c.spacing, T(-dz) * w.c.spacing, u);
      s.defect += physics::row_velocity_defect(goals, count, u, velocity);
      s.count += count;
    });
    return s;
  }
  MELTSIM_HD void finish(std::uint64_t v, const Sum& s) const {
    if (is_whole(w, v)) GoalsBody<T>{w}.finish(v, s);
  }
};

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
