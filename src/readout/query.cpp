// SPDX-License-Identifier: Apache-2.0
// Spatial queries: rays and what lies in a shape.
#include <cmath>
#include <vector>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {

/// Its direction, of length 1.
Result<Vec3d> checked_direction(const Ray& r, const std::string& what) {
  if (!finite(r.origin)) return invalid(what, "origin: must be finite, got ", r.origin);
  if (!finite(r.direction)) return invalid(what, "direction: must be finite, got ", r.direction);
  // Scaled first, so that the square of no length overflows or vanishes.
  const double most =
      std::max({std::fabs(r.direction.x), std::fabs(r.direction.y), std::fabs(r.direction.z)});
  if (!(most > 0)) return invalid(what, "direction: must not be 0");
  if (!(r.length > 0)) return invalid(what, "length: must be > 0, got ", r.length);
  const Vec3d scaled{r.direction.x / most, r.direction.y / most, r.direction.z / most};
  return scaled * (1 / length(scaled));
}
}  // namespace

Result<std::vector<RayHit>> WorldImpl::cast_rays(const std::vector<Ray>& rays, std::uint32_t sought) {
  if (rays.empty()) return invalid("cast_rays: rays: there are none; pass at least one");
  if (rays.size() > most_rays)
    return Error{ErrorCode::capacity,
                 core::text("cast_rays: rays: at most ", std::uint64_t{most_rays}, ", got ",
                            std::uint64_t{rays.size()}, "; cast them in several calls")};
  if (sought == 0 || (sought & ~ray_all) != 0)
    return invalid("cast_rays: sought: must be a sum of ray_liquid, ray_bodies and ray_walls, got ", sought);
  std::vector<core::RayQuery> asked;
  asked.reserve(rays.size());
  for (std::size_t k = 0; k < rays.size(); ++k) {
    const Ray& r = rays[k];
    const auto along = checked_direction(r, core::text("cast_rays: rays[", std::uint64_t{k}, "]: "));
    if (!along) return along.error();
    asked.push_back({r.origin - origin_, *along, r.length});
  }
  if (Status s = prepare(); !s) return s.error();
  for (std::size_t k = 0; k < rays.size(); ++k)
    asked[k].from = rays[k].origin - origin_;  // it may have moved
  std::vector<core::RayRow> rows;
  if (Status s = engine->follow_rays(asked, sought, rows); !s) return s.error();
  std::vector<RayHit> hits(rays.size());
  for (std::size_t k = 0; k < hits.size(); ++k) {
    const core::RayRow& row = rows[k];
    RayHit& h = hits[k];
    h.what = static_cast<RayTarget>(row.what);
    h.point = rays[k].origin;
    if (h.what == RayTarget::nothing) continue;
    h.distance = row.distance;
    h.point = rays[k].origin + asked[k].along * row.distance;
    h.normal = row.normal;
    if (row.body < bodies_.size()) h.body = id_of(row.body);
    if (row.wall < 6) h.wall = static_cast<int>(row.wall);
    h.particle = row.particle;
  }
  return hits;
}

Result<Overlap> WorldImpl::overlap(const Shape& shape) {
  if (Status s = shape.validate(); !s)
    return Error{s.error().code, core::text("overlap: shape: ", s.error().message)};
  const Box box = shape.bounds();
  if (const auto there = particles_in(box.min - origin_, box.max - origin_); !there) return there.error();
  Overlap o;
  std::vector<std::uint64_t> solid(bodies_.size(), 0);
  for (const core::FoundParticle& p : found_) {
    if (!shape.contains(p.position + origin_)) continue;
    if (is_solid(p.tag)) {
      ++solid[body_of(p.tag) - 1u];
    } else {
      ++o.liquid;
      o.liquid_volume += p.volume;
    }
  }
  for (std::size_t b = 0; b < solid.size(); ++b)
    if (solid[b] != 0) o.bodies.push_back({id_of(b), solid[b]});
  return o;
}

}  // namespace v0
}  // namespace meltsim
