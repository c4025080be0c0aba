// SPDX-License-Identifier: Apache-2.0
// The sums that the field is made of.
#pragma once

#include "surface/blocks.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

/// Bits of those of points[begin, end), 32 at most, that near(point) lets pass.
template <class T, class Near>
MELTSIM_HD std::uint32_t mark_near(const Vec4<T>* points, std::uint32_t begin, std::uint32_t end,
                                   const Near& near) {
  std::uint32_t bits = 0, k = 0;
  // Four at a time: their loads are under way together.
  for (; begin + k + 4u <= end; k += 4u) {
    const Vec4<T>* const p = points + begin + k;
    const Vec4<T> p0 = p[0], p1 = p[1], p2 = p[2], p3 = p[3];
    bits |= ((near(p0) ? 1u : 0u) | (near(p1) ? 2u : 0u) | (near(p2) ? 4u : 0u) | (near(p3) ? 8u : 0u)) << k;
  }
  for (; begin + k < end; ++k)
    if (near(points[begin + k])) bits |= 1u << k;
  return bits;
}

/// Calls visit(j) for the particles in rows [first, last) whose points near() lets pass, in order. One in six
/// does. The threads of a warp first test all of them, in few instructions, and then wait for the longest of their
/// sums, not for a near particle at each test.
template <class T, class Near, class Visit>
MELTSIM_HD void visit_near(const Range* rows, std::uint32_t first, std::uint32_t last, const Vec4<T>* points,
                           const Near& near, const Visit& visit) {
  struct Found {
    std::uint32_t begin, bits;
  };
  constexpr std::uint32_t room = 24;  // nine rows of 64; a denser set takes several turns
  Found found[room];
  std::uint32_t r = first, begin = 0, end = 0;
  for (bool more = true; more;) {
    std::uint32_t n = 0;
    while (n < room) {
      if (!(begin < end)) {
        more = r < last;
        if (!more) break;
        begin = rows[r].begin;
        end = rows[r].end;
        ++r;
        continue;
      }
      const std::uint32_t past = minimum(begin + 32u, end);
      const std::uint32_t bits = mark_near(points, begin, past, near);
      if (bits != 0u) found[n++] = {begin, bits};
      begin = past;
    }
    if (n == 0u) continue;
    Found f = found[0];
    for (std::uint32_t k = 0;;) {
      visit(f.begin + static_cast<std::uint32_t>(lowest_bit(f.bits)));
      f.bits &= f.bits - 1u;
      if (f.bits != 0u) continue;
      if (++k == n) break;
      f = found[k];
    }
  }
}

/// Rows of one of `parts` parts of a sum (exec_cpu.hpp: gather): all nine, or a layer of cells in z.
MELTSIM_HD Range rows_of_part(std::uint32_t part, std::uint32_t parts) {
  if (parts == 1u) return {0, 9};
  return {3u * part, 3u * part + 3u};
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
      const Range range = particles_of(w, groups_in(w, key_row(w, c, r)));
      for (std::uint32_t j = range.begin; j < range.end; ++j) visit(j, at);
    }
  }
}

template <class T>
struct FieldSums {
  T all{}, solid{};
  MELTSIM_HD void add(const FieldSums& o) {
    all += o.all;
    solid += o.solid;
  }
};

/// Into the domain: the field goes on beyond its faces as it meets them.
template <class T>
MELTSIM_HD Vec3<T> clipped(const SurfaceFrame<T>& w, Vec3<T> x) {
  return {clamp(x.x, w.clip_min.x, w.clip_max.x), clamp(x.y, w.clip_min.y, w.clip_max.y),
          clamp(x.z, w.clip_min.z, w.clip_max.z)};
}

/// visit(j, d, r^2) for the particles j within H_s of x, d = x - x_j: a part of all, those across periodic
/// faces with the first.
template <bool Periodic, class T, class Visit>
MELTSIM_HD void visit_around(const SurfaceFrame<T>& w, const Range* rows, std::uint32_t part,
                             std::uint32_t parts, Vec3<T> x, const Visit& visit) {
  const T support2 = w.field.kernel.support2;
  const Range share = rows_of_part(part, parts);
  const auto apart = [](Vec3<T> at, const Vec4<T>& p) { return at - xyz(p); };
  visit_near(
      rows, share.begin, share.end, w.point,
      [&](const Vec4<T>& p) {
        const Vec3<T> d = apart(x, p);
        return dot(d, d) < support2;
      },
      [&](std::uint32_t j) {
        const Vec3<T> d = apart(x, w.point[j]);
        visit(j, d, dot(d, d));
      });
  if constexpr (Periodic) {
    if (part == 0u)
      visit_images(w, x, [&](std::uint32_t j, Vec3<T> at) {
        const Vec3<T> d = apart(at, w.point[j]);
        const T r2 = dot(d, d);
        if (r2 < support2) visit(j, d, r2);
      });
  }
}

/// sum V W around a particle, and of solids alone where there are two fields; without W's scale.
template <bool Periodic, class T>
MELTSIM_HD FieldSums<T> volume_around(const SurfaceFrame<T>& w, const Range* rows, std::uint32_t part,
                                      std::uint32_t parts, Vec3<T> x) {
  FieldSums<T> s;
  visit_around<Periodic>(w, rows, part, parts, x, [&](std::uint32_t j, Vec3<T>, T r2) {
    const T share = w.point[j].w * physics::kernel_shape(w.field.kernel, std::sqrt(r2));
    s.all += share;
    if (w.two_fields && (w.mark[j] & core::mark_solid) != 0u) s.solid += share;
  });
  return s;
}

/// Second moments of the positions around a particle. For a solid only solids count, so that its surface does not depend on liquid.
template <bool Periodic, class T>
MELTSIM_HD physics::ShapeSums<T> shape_around(const SurfaceFrame<T>& w, const Range* rows, std::uint32_t part,
                                              std::uint32_t parts, Vec3<T> x, bool solid) {
  const physics::SphKernel<T>& k = w.field.kernel;
  const physics::WallView<T> walls = physics::wall_view(w.walls, x);
  physics::ShapeSums<T> s;
  visit_around<Periodic>(w, rows, part, parts, x, [&](std::uint32_t j, Vec3<T> d, T r2) {
    if (solid && w.mark[j] != core::mark_solid) return;
    physics::add_neighbour(s, k, -d, r2);
    if (walls.axes != 0u)
      physics::for_each_image(walls, k.support2, d,
                              [&](const Vec3<T>& m, T m2) { physics::add_neighbour(s, k, -m, m2); });
  });
  return s;
}

/// Nodes along x that are worked out together, so that a particle is read, and found near, once for all of
/// them. As many as a block has along an edge at cells of half a spacing, all or (step 2) every second one.
template <bool Anisotropic, int Step>
inline constexpr std::uint32_t most_in_line = ((Anisotropic ? 6 : 5) + Step - 1) / Step;

template <class T, std::uint32_t N>
struct LineSums {
  T all[N] = {}, solid[N] = {};
  MELTSIM_HD void add(const LineSums& o) {
    for (std::uint32_t k = 0; k < N; ++k) {
      all[k] += o.all[k];
      solid[k] += o.solid[k];
    }
  }
};

/// Square of the distance d from the center of particle j, in its own measure. across: the part of it that is not along x.
template <bool Anisotropic, class T>
MELTSIM_HD T square_from(const SurfaceFrame<T>& w, std::uint32_t j, Vec3<T> d, T across) {
  if constexpr (Anisotropic) {
    const core::SurfaceShape<T>& g = w.shape[j];
    return physics::ellipsoid_distance2(g.diagonal.x, g.diagonal.y, g.diagonal.z, g.diagonal.w, g.yz, g.zx,
                                        d);
  } else {
    return d.x * d.x + across;
  }
}

/// phi and phi of the solids at (x[k], y, z), k < count, without W's scale; x ascends. The rest of x may hold
/// anything.
template <bool Anisotropic, bool Periodic, class T, std::uint32_t N>
MELTSIM_HD LineSums<T, N> field_along(const SurfaceFrame<T>& w, const Range* rows, std::uint32_t part,
                                      std::uint32_t parts, const T (&x)[N], std::uint32_t count, T y, T z) {
  const physics::SphKernel<T>& kernel = w.field.kernel;
  LineSums<T, N> s;
  const auto add = [&](std::uint32_t j, std::uint32_t k, Vec3<T> d, T across, T share, T solid) {
    const T shape =
        physics::kernel_shape(kernel, std::sqrt(square_from<Anisotropic>(w, j, d, across)));  // 0 beyond H_s
    s.all[k] += share * shape;
    s.solid[k] += solid * shape;
  };
  const Range share = rows_of_part(part, parts);
  const T low = x[0], high = x[count - 1u];
  visit_near(
      rows, share.begin, share.end, w.share,
      [&](const Vec4<T>& p) {  // no ellipsoid is longer than its ball
        const Vec3<T> d{clamp(p.x, low, high) - p.x, y - p.y, z - p.z};
        return dot(d, d) < kernel.support2;
      },
      [&](std::uint32_t j) {
        const Vec4<T> p = w.share[j];
        const T solid = w.two_fields ? w.solid_share[j] : T(0);
        const T dy = y - p.y, dz = z - p.z, across = dy * dy + dz * dz;
        for (std::uint32_t k = 0; k < N; ++k) add(j, k, {x[k] - p.x, dy, dz}, across, p.w, solid);
      });
  if constexpr (Periodic) {
    if (part != 0u) return s;
    for (std::uint32_t k = 0; k < count; ++k)
      visit_images(w, Vec3<T>{x[k], y, z}, [&](std::uint32_t j, Vec3<T> at) {
        const Vec4<T> p = w.share[j];
        const Vec3<T> d = at - xyz(p);
        add(j, k, d, d.y * d.y + d.z * d.z, p.w, w.two_fields ? w.solid_share[j] : T(0));
      });
  }
  return s;
}

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
