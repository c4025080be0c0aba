// SPDX-License-Identifier: Apache-2.0
// Regions as planes of rows of members (physics/shape_matching.hpp: BoxSums, BoxGoals): storage of the sums over
// rows and planes, and the kernels that compute them. Regions not made of planes are summed member by member
// (bodies.hpp).
#pragma once

#include "lsm/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

using physics::BoxGoals;
using physics::BoxSums;

/// Plane k of the storage per vertex. Sums of planes and goals are in region_rows; sums of rows are used up before
/// fits are computed, so most of them are in region_fit.
template <class T>
MELTSIM_HD Vec4<T>& kept(const Frame<T>& w, std::uint64_t v, std::uint64_t k) {
  return w.f.region_rows[k * w.vertices + v];
}
template <class T>
MELTSIM_HD Vec4<T>& kept_early(const Frame<T>& w, std::uint64_t v, std::uint64_t k) {
  return k < 4u ? w.f.region_fit[k * w.vertices + v] : kept(w, v, k + 2u);
}

template <class T>
MELTSIM_HD void put_box(const Frame<T>& w, std::uint64_t v, const BoxSums<T, 1>& r) {
  kept_early(w, v, 0) = with_w(r.mu, r.mass);
  kept_early(w, v, 1) = with_w(r.muq[0], r.mq[0]);
  kept_early(w, v, 2) = with_w(r.mv, r.muu.mixed.x);
  kept_early(w, v, 3) = with_w(r.muxv, r.muu.mixed.y);
  kept_early(w, v, 4) = with_w(r.muu.diagonal, r.muu.mixed.z);
}
template <class T>
MELTSIM_HD void get_box(const Frame<T>& w, std::uint64_t v, BoxSums<T, 1>& r) {
  const Vec4<T> mu = kept_early(w, v, 0), muq = kept_early(w, v, 1), mv = kept_early(w, v, 2),
                muxv = kept_early(w, v, 3), muu = kept_early(w, v, 4);
  r.mass = mu.w;
  r.mq[0] = muq.w;
  r.mu = xyz(mu);
  r.muq[0] = xyz(muq);
  r.muu = {xyz(muu), {mv.w, muxv.w, muu.w}};
  r.mv = xyz(mv);
  r.muxv = xyz(muxv);
}

template <class T>
MELTSIM_HD void put_box(const Frame<T>& w, std::uint64_t v, const BoxSums<T, 2>& p) {
  kept(w, v, 0) = with_w(p.mu, p.mass);
  kept(w, v, 1) = with_w(p.muq[0], p.mq[0]);
  kept(w, v, 2) = with_w(p.muq[1], p.mq[1]);
  kept(w, v, 3) = with_w(p.mv, p.muu.mixed.x);
  kept(w, v, 4) = with_w(p.muxv, p.muu.mixed.y);
  kept(w, v, 5) = with_w(p.muu.diagonal, p.muu.mixed.z);
}
template <class T>
MELTSIM_HD void get_box(const Frame<T>& w, std::uint64_t v, BoxSums<T, 2>& p) {
  const Vec4<T> mu = kept(w, v, 0), x = kept(w, v, 1), y = kept(w, v, 2), mv = kept(w, v, 3),
                muxv = kept(w, v, 4), muu = kept(w, v, 5);
  p.mass = mu.w;
  p.mq[0] = x.w;
  p.mq[1] = y.w;
  p.mu = xyz(mu);
  p.muq[0] = xyz(x);
  p.muq[1] = xyz(y);
  p.muu = {xyz(muu), {mv.w, muxv.w, muu.w}};
  p.mv = xyz(mv);
  p.muxv = xyz(muxv);
}

template <class T>
MELTSIM_HD void put_box(const Frame<T>& w, std::uint64_t v, const BoxGoals<T, 1>& g) {
  kept(w, v, 0) = with_w(g.displacement, g.columns[1].x);
  kept(w, v, 1) = with_w(g.velocity, g.columns[1].y);
  kept(w, v, 2) = with_w(g.spin, g.columns[1].z);
  kept(w, v, 3) = with_w(g.columns[0], T(0));
}
template <class T>
MELTSIM_HD void get_box(const Frame<T>& w, std::uint64_t v, BoxGoals<T, 1>& g) {
  const Vec4<T> displacement = kept(w, v, 0), velocity = kept(w, v, 1), spin = kept(w, v, 2),
                y = kept(w, v, 3);
  g = {xyz(displacement), xyz(velocity), xyz(spin), {xyz(y), {displacement.w, velocity.w, spin.w}}};
}

template <class T>
MELTSIM_HD void put_box(const Frame<T>& w, std::uint64_t v, const BoxGoals<T, 2>& g) {
  kept(w, v, 4) = with_w(g.displacement, g.columns[0].x);
  kept(w, v, 5) = with_w(g.velocity, g.columns[0].y);
  kept(w, v, 6) = with_w(g.spin, g.columns[0].z);
}
template <class T>
MELTSIM_HD void get_box(const Frame<T>& w, std::uint64_t v, BoxGoals<T, 2>& g) {
  const Vec4<T> displacement = kept(w, v, 4), velocity = kept(w, v, 5), spin = kept(w, v, 6);
  g = {xyz(displacement), xyz(velocity), xyz(spin), {{displacement.w, velocity.w, spin.w}}};
}

/// Sums over the row about a vertex.
template <class T>
struct RowSumsBody {
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!has_boxes(w, v)) return;
    const BoxOrigin<T> o = box_origin<1>(w, v);
    if (!o.exists) return;
    BoxSums<T, 1> sums;
    for_each_in_row(w, v, [&](std::uint32_t j, int k) {
      const Vec4<T> xj = w.f.vertex_position[j];
      physics::add_member<T>(sums, xj.w, spatial::separation(w.grid, xyz(xj), o.position), T(k) * w.c.spacing,
                             xyz(w.f.vertex_velocity[j]) - o.velocity);
    });
    put_box(w, v, sums);
  }
};

/// Sums over the rows or planes within w of v along the next axis, relative to o.
template <class T, int Axes>
MELTSIM_HD BoxSums<T, Axes + 1> sum_boxes(const Frame<T>& w, std::uint64_t v, const BoxOrigin<T>& o) {
  BoxSums<T, Axes + 1> sums;
  for_each_box<Axes>(w, v, [&](std::uint32_t j, int k, const BoxOrigin<T>& at) {
    BoxSums<T, Axes> box;
    get_box(w, j, box);
    physics::add_box<T, Axes>(sums, box, spatial::separation(w.grid, at.position, o.position),
                              T(k) * w.c.spacing, at.velocity - o.velocity);
  });
  return sums;
}

/// Sums over the plane about a vertex, row by row.
template <class T>
struct PlaneSumsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!has_boxes(w, v)) return;
    const BoxOrigin<T> o = box_origin<2>(w, v);
    if (o.exists) put_box(w, v, sum_boxes<T, 1>(w, v, o));
  }
};

/// The work of RegionMotionBody, plane by plane.
template <class T>
struct BoxedRegionMotionBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!is_boxed(w, v)) return;
    const BoxOrigin<T> o{xyz(w.f.vertex_position[v]), xyz(w.f.vertex_velocity[v]), true};
    RegionMotionBody<T>{w}.finish(v, {physics::region_of(sum_boxes<T, 2>(w, v, o))});
  }
};

/// Sum of the goals that the regions of the row about a vertex have for a common member.
template <class T>
struct RowGoalsBody {
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!has_boxes(w, v)) return;
    const BoxOrigin<T> o = box_origin<1>(w, v);
    if (!o.exists) return;
    BoxGoals<T, 1> goals;
    for_each_in_row(w, v, [&](std::uint32_t r, int k) {
      const core::PlacedFit<T> p = core::get_fit(w, r);
      physics::add_goals<T, 0>(goals, physics::goals_of(p.fit), T(1), T(-k) * w.c.spacing,
                               spatial::separation(w.grid, o.position, p.position));
    });
    put_box(w, v, goals);
  }
};

/// Regions in the row (Axes = 1) about `box`, or in the plane (2) about it, which is k from v.
template <int Axes, class T>
MELTSIM_HD std::uint32_t regions_in(const Frame<T>& w, std::uint64_t v, std::uint32_t box, int k) {
  return Axes == 1 ? popcount(live_in_row(w, box)) : layer_members(w, v, k);
}

/// The same of the rows or planes within w of v along the next axis, of a member at x.
template <class T, int Axes>
MELTSIM_HD BoxGoals<T, Axes + 1> sum_goals(const Frame<T>& w, std::uint64_t v, Vec3<T> x) {
  BoxGoals<T, Axes + 1> goals;
  for_each_box<Axes>(w, v, [&](std::uint32_t j, int k, const BoxOrigin<T>& at) {
    BoxGoals<T, Axes> box;
    get_box(w, j, box);
    physics::add_goals<T, Axes>(goals, box, T(regions_in<Axes>(w, v, j, k)), T(-k) * w.c.spacing,
                                spatial::separation(w.grid, x, at.position));
  });
  return goals;
}

/// Sum of the goals of the regions of the plane about a vertex, row by row.
template <class T>
struct PlaneGoalsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!has_boxes(w, v)) return;
    const BoxOrigin<T> o = box_origin<2>(w, v);
    if (o.exists) put_box(w, v, sum_goals<T, 1>(w, v, o.position));
  }
};

/// The work of GoalsBody, plane by plane: v is in the regions of the members of its own region.
template <class T>
struct BoxedGoalsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!is_boxed(w, v)) return;
    const BoxGoals<T, 3> goals = sum_goals<T, 2>(w, v, xyz(w.f.vertex_position[v]));
    const T count = T(region_members(w, v));
    GoalsBody<T>{w}.finish(v,
                           {goals.displacement, goals.velocity - xyz(w.f.vertex_velocity[v]) * count, count});
  }
};

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
