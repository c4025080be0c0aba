// SPDX-License-Identifier: Apache-2.0
// Kernels of rays: one thread follows one ray through the cells of the particles. Formulas: meltsim/physics/ray.hpp.
#pragma once

#include "frame/ray_rows.hpp"
#include "sampling/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

/// Largest number of samples along a ray: it reaches at least this many quarters of a spacing.
inline constexpr std::uint32_t most_ray_places = 1u << 18;

template <class T>
struct ParticleBoundsBody {
  Frame<T> w;
  MELTSIM_HD core::ParticleBounds operator()(std::uint64_t i) const {
    core::ParticleBounds b;
    if (is_removed(w.f.tag[i])) return b;
    b.low = b.high = cast<double>(xyz(w.f.position[i]));
    return b;
  }
};

template <class T>
struct RayBody {
  Frame<T> w;
  core::RayRoom room;

  MELTSIM_HD void operator()(std::uint64_t n) const {
    const core::RayQuery ray = room.rays[n];
    core::RayRow hit;
    hit.distance = ray.length;
    const Vec3<double> low = cast<double>(w.c.domain_min), high = cast<double>(w.c.domain_max);
    const bool bounded = low.x < high.x;
    if (bounded && (room.sought & ray_walls) != 0u) meet_walls(ray, low, high, hit);
    if ((room.sought & (ray_liquid | ray_bodies)) != 0u && room.bounds->low.x <= room.bounds->high.x) {
      const auto reach = static_cast<double>(w.c.kernel.support);
      const Vec3<double> margin{reach, reach, reach};
      physics::RaySpan span = physics::ray_in_box(ray.from, ray.along, room.bounds->low - margin,
                                                  room.bounds->high + margin, hit.distance);
      if (bounded) {
        const physics::RaySpan in = physics::ray_in_box(ray.from, ray.along, low, high, hit.distance);
        span.enter = maximum(span.enter, in.enter);
        span.leave = minimum(span.leave, in.leave);
      }
      if (span.enter <= span.leave) march(ray, span, hit);
    }
    room.hits[n] = hit;
  }

 private:
  /// Sums around a place, whether any particle is in a cell beside it, and which is nearest.
  struct Around {
    physics::MediumSums<T> sums;
    bool any = false;
    std::uint32_t solid = core::none, liquid = core::none;  ///< slots
  };

  MELTSIM_HD static Vec3<double> at(const core::RayQuery& ray, double t) { return ray.from + ray.along * t; }

  MELTSIM_HD void meet_walls(const core::RayQuery& ray, Vec3<double> low, Vec3<double> high,
                             core::RayRow& hit) const {
    const physics::RaySpan s = physics::ray_in_box(ray.from, ray.along, low, high, ray.length);
    if (s.enter > 0 || s.enter > s.leave || s.face < 0) return;  // from outside, or it ends inside
    if (((w.c.walls.faces >> s.face) & 1u) == 0u) return;
    hit.what = static_cast<std::uint32_t>(RayTarget::wall);
    hit.distance = s.leave;
    hit.normal = physics::wall_normal<double>(s.face);
    hit.wall = static_cast<std::uint32_t>(s.face);
  }

  MELTSIM_HD Around around(Vec3<double> place) const {
    Around a;
    const Vec3<T> x = cast<T>(place);
    const auto walls = physics::wall_view(w.c.walls, x);
    const spatial::CellPlace cell = spatial::place_at(w.grid, x);
    for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
      const core::Range range = spatial::row_around(w, cell, r);
      if (range.begin == range.end) continue;
      a.any = true;
      spatial::EveryNth all{0u, 1u};
      spatial::visit_range(w, x, range, all, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& d, T r2) {
        const std::uint32_t tag = w.f.tag[j];
        if (is_removed(tag)) return;
        const bool liquid = is_fluid(tag);
        a.sums.fill.add(w.c.kernel, walls, liquid, xj.w, d, r2);
        T& nearest = liquid ? a.sums.nearest_liquid2 : a.sums.nearest_solid2;
        if (!(r2 < nearest)) return;
        nearest = r2;
        (liquid ? a.liquid : a.solid) = j;
      });
    }
    return a;
  }

  MELTSIM_HD physics::Medium medium(const Around& a) const {
    return physics::medium_at(w.c.kernel, w.c.spacing, a.sums, room.sought);
  }

  /// Distance at which the ray leaves the cell that it is in at t.
  MELTSIM_HD double past_cell(const core::RayQuery& ray, double t) const {
    const core::Grid<T>& g = w.grid;
    const Vec3<double> x = at(ray, t);
    const spatial::CellPlace cell = spatial::place_at(g, cast<T>(x));
    const double along[3] = {ray.along.x, ray.along.y, ray.along.z}, here[3] = {x.x, x.y, x.z},
                 min[3] = {static_cast<double>(g.min.x), static_cast<double>(g.min.y),
                           static_cast<double>(g.min.z)},
                 per[3] = {static_cast<double>(g.inv_cell.x), static_cast<double>(g.inv_cell.y),
                           static_cast<double>(g.inv_cell.z)};
    const std::int32_t index[3] = {cell.x, cell.y, cell.z};
    double exit = 1e300;
    for (int k = 0; k < 3; ++k) {
      if (along[k] == 0) continue;
      const double border = min[k] + (index[k] + (along[k] > 0 ? 1 : 0)) / per[k];
      exit = minimum(exit, maximum((border - here[k]) / along[k], 0.0));
    }
    return t + exit;
  }

  MELTSIM_HD void march(const core::RayQuery& ray, const physics::RaySpan& span, core::RayRow& hit) const {
    const double step = 0.25 * static_cast<double>(w.c.spacing);
    double before = span.enter, t = span.enter;
    Around a;
    physics::Medium found = physics::Medium::nothing;
    for (std::uint32_t n = 0; n < most_ray_places; ++n) {
      a = around(at(ray, t));
      found = medium(a);
      if (found != physics::Medium::nothing || t >= span.leave) break;
      before = t;
      t = a.any ? t + step : maximum(t + step, past_cell(ray, t));
      t = minimum(t, span.leave);
    }
    if (found == physics::Medium::nothing) return;
    constexpr int halvings = 14;
    for (int n = 0; n < halvings && before < t; ++n) {
      const double middle = 0.5 * (before + t);
      const Around here = around(at(ray, middle));
      const physics::Medium there = medium(here);
      if (there == physics::Medium::nothing) {
        before = middle;
      } else {
        t = middle;
        a = here;
        found = there;
      }
    }
    const bool liquid = found == physics::Medium::liquid;
    const std::uint32_t slot = liquid ? a.liquid : a.solid;
    hit.what = static_cast<std::uint32_t>(liquid ? RayTarget::liquid : RayTarget::body);
    hit.wall = core::none;
    hit.distance = t;
    if (slot != core::none) {
      hit.particle = w.f.id[slot];
      if (!liquid) hit.body = body_of(w.f.tag[slot]) - 1u;
    }
    hit.normal = normal_at(ray, t, found, slot);
  }

  /// Down the gradient of the level; where that is 0, away from the nearest particle, or else against the ray.
  MELTSIM_HD Vec3<double> normal_at(const core::RayQuery& ray, double t, physics::Medium of,
                                    std::uint32_t slot) const {
    const Vec3<double> x = at(ray, t);
    const double h = 0.25 * static_cast<double>(w.c.spacing);
    const auto level = [&](Vec3<double> offset) {
      return static_cast<double>(physics::surface_level(w.c.kernel, around(x + offset).sums, of));
    };
    Vec3<double> down{level({-h, 0, 0}) - level({h, 0, 0}), level({0, -h, 0}) - level({0, h, 0}),
                      level({0, 0, -h}) - level({0, 0, h})};
    if (!(length(down) > 1e-6) && slot != core::none)
      down = cast<double>(spatial::separation(w.grid, cast<T>(x), xyz(w.f.position[slot])));
    if (!(length(down) > 0)) down = -ray.along;
    return down * (1 / length(down));
  }
};

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
