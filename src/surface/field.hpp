// SPDX-License-Identifier: Apache-2.0
// The sums that the field is made of.
#pragma once

#include "surface/blocks.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

/// Calls visit(j) for the particles of nine rows.
template <class Visit>
MELTSIM_HD void visit_rows(const Range* rows, const Visit& visit) {
  for (std::uint32_t r = 0; r < 9; ++r)
    for (std::uint32_t j = rows[r].begin; j < rows[r].end; ++j) visit(j);
}

/// Calls visit(j, x') for the particles around x' = x moved by periods, wherever one face is within reach of
/// x. Rows are searched for: few points are near a periodic face.
template <class T, class Visit>
MELTSIM_HD void visit_images(const SurfaceFrame<T>& w, Vec3<T> x, const Visit& visit) {
  const T reach = w.field.kernel.support;
  const auto move = [reach](T at, T low, T high, T period) {
    if (!(period > T(0))) return T(0);
    return at - low < reach ? period : high - at < reach ? -period : T(0);
  };
  const Vec3<T> by{move(x.x, w.clip_min.x, w.clip_max.x, w.period.x),
                   move(x.y, w.clip_min.y, w.clip_max.y, w.period.y),
                   move(x.z, w.clip_min.z, w.clip_max.z, w.period.z)};
  const std::uint32_t axes = (by.x != T(0) ? 1u : 0u) | (by.y != T(0) ? 2u : 0u) | (by.z != T(0) ? 4u : 0u);
  for (std::uint32_t mask = axes; mask != 0u; mask = (mask - 1u) & axes) {
    const Vec3<T> at{x.x + ((mask & 1u) != 0u ? by.x : T(0)), x.y + ((mask & 2u) != 0u ? by.y : T(0)),
                     x.z + ((mask & 4u) != 0u ? by.z : T(0))};
    const Index3 c = cell_at(w, at, 0);
    for (std::uint32_t r = 0; r < 9; ++r) {
      const Range range = particles_in(w, key_row(w, c, r));
      for (std::uint32_t j = range.begin; j < range.end; ++j) visit(j, at);
    }
  }
}

template <class T>
struct FieldSums {
  T all{}, solid{};
};

/// Into the domain: the field goes on beyond its faces as it meets them.
template <class T>
MELTSIM_HD Vec3<T> clipped(const SurfaceFrame<T>& w, Vec3<T> x) {
  return {clamp(x.x, w.clip_min.x, w.clip_max.x), clamp(x.y, w.clip_min.y, w.clip_max.y),
          clamp(x.z, w.clip_min.z, w.clip_max.z)};
}

/// sum V W over `points` (volumes in w) and, where there are two fields, over solids alone. square(j, d):
/// |d|^2, or what stands for it.
template <class T, class SolidVolume, class Square>
MELTSIM_HD FieldSums<T> sums_at(const SurfaceFrame<T>& w, const Range* rows, Vec3<T> x, const Vec4<T>* points,
                                const SolidVolume& solid_volume, const Square& square) {
  const physics::SphKernel<T>& k = w.field.kernel;
  FieldSums<T> s;
  const auto add = [&](std::uint32_t j, Vec3<T> at) {
    const Vec4<T> p = points[j];
    const Vec3<T> d = at - xyz(p);
    const T straight = dot(d, d);
    if (!(straight < k.support2)) return;  // no ellipsoid is longer than its ball
    const T r2 = square(j, d, straight);
    if (!(r2 < k.support2)) return;
    const T shape = physics::kernel_shape(k, std::sqrt(r2));
    s.all += p.w * shape;
    if (w.two_fields) s.solid += solid_volume(j, p.w) * shape;
  };
  visit_rows(rows, [&](std::uint32_t j) { add(j, x); });
  visit_images(w, x, add);
  const T scale = k.w_scale / physics::open_share(w.walls, k, x);
  s.all *= scale;
  s.solid *= scale;
  return s;
}

/// phi and phi of the solids.
template <bool Anisotropic, class T>
MELTSIM_HD FieldSums<T> field_at(const SurfaceFrame<T>& w, const Range* rows, Vec3<T> x) {
  const T* const solid_share = w.solid_share;
  const core::SurfaceShape<T>* const shape = w.shape;
  return sums_at(
      w, rows, x, w.share, [solid_share](std::uint32_t j, T) { return solid_share[j]; },
      [shape](std::uint32_t j, Vec3<T> d, T straight) {
        if (!Anisotropic) return straight;
        const core::SurfaceShape<T> g = shape[j];
        return physics::ellipsoid_distance2(g.diagonal.x, g.diagonal.y, g.diagonal.z, g.diagonal.w, g.yz,
                                            g.zx, d);
      });
}

/// Which way the particles around one lie. Solids look at solids only, so that their surface is theirs alone.
template <class T>
MELTSIM_HD physics::ShapeSums<T> shape_sums(const SurfaceFrame<T>& w, const Range* rows, Vec3<T> x,
                                            bool solid) {
  const physics::SphKernel<T>& k = w.field.kernel;
  const physics::WallView<T> walls = physics::wall_view(w.walls, x);
  physics::ShapeSums<T> s;
  const auto add = [&](std::uint32_t j, Vec3<T> at) {
    if (solid && w.mark[j] != core::mark_solid) return;
    const Vec3<T> d = xyz(w.point[j]) - at;
    const T r2 = dot(d, d);
    if (!(r2 < k.support2)) return;
    physics::add_neighbour(s, k, d, r2);
    if (walls.axes != 0u)
      physics::for_each_image(walls, k.support2, -d,
                              [&](const Vec3<T>& m, T m2) { physics::add_neighbour(s, k, -m, m2); });
  };
  visit_rows(rows, [&](std::uint32_t j) { add(j, x); });
  visit_images(w, x, add);
  return s;
}

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
