// SPDX-License-Identifier: Apache-2.0
// Kinematic bodies: motions that the host sets, and their checks ahead of a step.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Liquid that is hit at this share of the sound speed is compressed by a quarter:
/// (1 + 7 v/c)^(1/7) = 1.24 from the Tait equation at the pressure rho v c of a stopped sound wave.
constexpr double largest_mach = 0.5;
/// Whether q is a unit quaternion within single precision.
constexpr double unit_tolerance = 1e-3;

/// Speed of the fastest point within reach of the pivot [m/s].
double speed_of(const physics::RigidPlace& p, double reach) {
  const double spin = length(p.angular_velocity);
  return length(p.velocity) + (spin > 0 ? spin * reach : 0);
}
double norm_of(const Quat<double>& q) { return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z); }
}  // namespace

std::uint32_t WorldImpl::next_number() {
  static std::atomic<std::uint32_t> worlds{0};
  std::uint32_t number = 0;
  while (number < 2)  // 0 is the null handle's, 1 that of materials named by their index
    number = worlds.fetch_add(1, std::memory_order_relaxed) + 1;
  return number;
}

Status WorldImpl::check_body(const char* call, BodyId id) const {
  if (valid(id)) return {};
  if (id.index < bodies_.size() && id.generation == bodies_[id.index].generation)
    return invalid(call, ": body: \"", bodies_[id.index].desc.name, "\" was removed; do not use its handle");
  return invalid(call, ": body: no body of this World has index ", id.index, " and generation ",
                 id.generation,
                 "; pass what add_solid() of this World returned, and nothing that was removed");
}

/// Where a vertex of a kinematic body is relative to the pivot in the frame of the body as built [m].
Vec3d WorldImpl::rest_of(std::uint32_t body, std::uint32_t vertex, const BodyExtent& extent) const {
  if (extent.points != nullptr)
    return physics::mesh_point_at(extent.points[vertex - bodies_[body].first_vertex], extent.at).position;
  const core::BodyMotionRow& row = lattice_.rests[body];
  const core::BodyRow& b = lattice_.bodies[body];
  const std::uint32_t site = lattice_.vertex_site[vertex] - b.first_site, layer = site % b.stride_z;
  return row.low + Vec3d{double(layer % b.stride_y), double(layer / b.stride_y), double(site / b.stride_z)} *
                       row.spacing;
}

Status WorldImpl::set_motion(BodyId id, const BodyMotion& m) {
  if (Status s = check_body("set_motion", id); !s) return s;
  const BodyRecord& body = bodies_[id.index];
  const std::string what = "set_motion: body \"" + body.desc.name + "\": ";
  if (!body.kinematic())
    return invalid(what, "motion: only a kinematic body can be moved; ",
                   body.proxy() ? "use set_proxy" : "build it with SolidDesc::motion kinematic");
  if (m.position && !finite(*m.position)) return invalid(what, "position: must be finite, got ", *m.position);
  if (!finite(m.velocity)) return invalid(what, "velocity: must be finite, got ", m.velocity);
  if (!finite(m.angular_velocity))
    return invalid(what, "angular_velocity: must be finite, got ", m.angular_velocity);
  BodyMotion motion = m;
  if (m.orientation) {
    const double norm = norm_of(*m.orientation);
    if (!(std::fabs(norm - 1) <= unit_tolerance))
      return invalid(what, "orientation: must be a unit quaternion, its norm is ", norm,
                     "; divide it by that");
    Quat<double>& q = *motion.orientation;
    q = {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
  }
  if (m.teleport && !m.position && !m.orientation)
    return invalid(what, "teleport: needs a position or an orientation; set one of them, or drop teleport");
  if (m.teleport) {
    const physics::RigidPlace place = motion_for(id.index, motion, 0).first;
    if (Status s = inside_walls(id.index, place, extent_of(id.index, 0, false)); !s) return s;
    if (Status s = clear_for_teleport(id.index, place); !s) return s;
  }
  motions_[id.index] = motion;
  bodies_[id.index].desc.path.clear();
  return {};
}

Result<BodyMotion> WorldImpl::motion(BodyId id) {
  if (Status s = check_body("motion", id); !s) return s.error();
  if (!bodies_[id.index].kinematic())
    return invalid("motion: body \"", bodies_[id.index].desc.name,
                   "\": not kinematic; pieces() has the motion of others");
  if (halted_) fetch_state();
  const physics::RigidPlace p = physics::place_at(state_.motion[id.index], time);
  BodyMotion m;
  m.position = p.position + origin_;
  m.orientation = p.orientation;
  m.velocity = p.velocity;
  m.angular_velocity = p.angular_velocity;
  return m;
}

/// The motion from now on; dt: of the next step [s].
physics::RigidMotion WorldImpl::motion_for(std::uint32_t body, const BodyMotion& m, double dt) const {
  physics::RigidMotion r;
  r.from = time;
  r.until = m.teleport ? time : time + dt;
  r.first = physics::place_at(state_.motion[body], time);
  r.first.velocity = m.velocity;
  r.first.angular_velocity = m.angular_velocity;
  if (m.teleport) {
    if (m.position) r.first.position = *m.position - origin_;
    if (m.orientation) r.first.orientation = *m.orientation;
    r.then = r.first;
    return r;
  }
  if (m.position) r.first.velocity = (*m.position - origin_ - r.first.position) * (1 / dt);
  if (m.orientation) {
    const Quat<double>& q = r.first.orientation;
    r.first.angular_velocity =
        physics::rotation_vector(physics::composed(*m.orientation, {q.w, -q.x, -q.y, -q.z})) * (1 / dt);
  }
  r.then = physics::moved_on(r.first, dt);
  if (m.position) r.then.position = *m.position - origin_;
  if (m.orientation) r.then.orientation = *m.orientation;
  r.then.velocity = m.velocity;
  r.then.angular_velocity = m.angular_velocity;
  return r;
}

/// Refuses a place that reaches through a wall: particles beyond it would push liquid a second time, beside the wall's
/// images.
Status WorldImpl::inside_walls(std::uint32_t body, const physics::RigidPlace& place,
                               const BodyExtent& extent) const {
  if (!desc.domain.bounded) return {};
  const Vec3d low = desc.domain.min - origin_, high = desc.domain.max - origin_;
  // Rounding: a body may be built with a particle in the plane of a wall.
  const double slack = 1e-6 * desc.spacing;
  const auto beyond = [&](Vec3d x) {
    const double over[] = {low.x - x.x, x.x - high.x, low.y - x.y, x.y - high.y, low.z - x.z, x.z - high.z};
    for (std::size_t face = 0; face < 6; ++face)
      if (desc.domain.faces[face] == Face::wall && over[face] > slack) return true;
    return false;
  };
  const BodyRecord& b = bodies_[body];
  bool outside = false;
  for (int corner = 0; corner < 8; ++corner)
    outside = outside || beyond(physics::point_of(place, {corner & 1 ? extent.low.x : extent.high.x,
                                                          corner & 2 ? extent.low.y : extent.high.y,
                                                          corner & 4 ? extent.low.z : extent.high.z})
                                    .position);
  if (!outside) return {};
  for (std::uint32_t v = b.first_vertex; v < b.first_vertex + b.vertices; ++v) {
    const Vec3d x = physics::point_of(place, rest_of(body, v, extent)).position;
    if (beyond(x))
      return invalid(b.proxy()       ? "set_proxy"
                     : deforms(body) ? "update_mesh"
                     : on_path(body) ? "step: path"
                                     : "set_motion",
                     ": body \"", b.desc.name, "\": ", deforms(body) ? "vertices" : "position",
                     ": would reach through a wall at ", x + origin_, "; keep it within the domain ",
                     desc.domain.min, " to ", desc.domain.max);
  }
  return {};
}

/// Checks a body's motion during dt from a time on.
Status WorldImpl::check_motion(std::uint32_t body, const physics::RigidMotion& m, const BodyExtent& extent,
                               double from, double dt) const {
  const BodyRecord& b = bodies_[body];
  const physics::RigidPlace now = physics::place_at(m, from);
  const double rigid = speed_of(now, extent.reach), speed = rigid + extent.speed;
  // The motion after the end of the step holds at that end, too.
  const double rigid_later = b.proxy() ? 0 : speed_of(physics::place_at(m, from + dt), extent.reach),
               later = rigid_later + extent.later;
  const double most = largest_mach * sound_speed_;
  if (!(std::max(speed, later) <= most) &&
      (any_liquid() || std::any_of(bodies_.begin(), bodies_.end(),
                                   [](const BodyRecord& other) { return !other.desc.fixed; }))) {
    const bool by_mesh = speed > most ? extent.speed > rigid : extent.later > rigid_later;
    return invalid(b.proxy()       ? "set_proxy"
                   : by_mesh       ? "update_mesh"
                   : on_path(body) ? "step: path"
                                   : "set_motion",
                   ": body \"", b.desc.name, "\": ",
                   !by_mesh       ? "velocity:"
                   : speed > most ? "vertices: a particle"
                                  : "velocities: a particle",
                   " would move at ", std::max(speed, later), " m/s, more than half the sound speed of ",
                   sound_speed_, " m/s; move it less in a step, or build it with max_speed of at least ",
                   std::max(speed, later), " m/s");
  }
  if (!b.proxy() && !(speed > 0)) return {};
  return inside_walls(body, physics::place_at(m, from + dt), extent);
}

/// Forgets what a host set for a body, which then goes on as before.
void WorldImpl::forget_motion(std::size_t body) {
  motions_[body].reset();
  proxies_[body].reset();
  meshes_[body].set = false;
}

/// Motions for a step of dt, and the fastest of all bodies in it. One that is refused is forgotten: it would stop the World until the host
/// finds another.
Status WorldImpl::plan_motions(double dt) {
  steered_.clear();
  reshaped_.clear();
  double fastest = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const BodyRecord& b = bodies_[i];
    const auto body = static_cast<std::uint32_t>(i);
    if (b.proxy() && !b.gone && proxies_[i]) {
      const physics::RigidMotion m = motion_for(*proxies_[i], dt);
      if (Status s = check_motion(body, m, extent_of(body, 0, false), time, 0); !s) {
        forget_motion(i);
        return s;
      }
      steered_.push_back(
          {body, proxies_[i]->teleport, m, b.reach, physics::largest_closing_mach * sound_speed_});
      fastest = std::max(fastest, length(m.first.velocity) + length(m.first.angular_velocity) * b.reach);
    }
    if (!b.kinematic() || b.gone) continue;
    if (meshes_[i].set) plan_mesh(body, dt);
    if (on_path(i))
      if (Status s = check_path(body, dt, fastest); !s) return s;
    const physics::RigidMotion m = motions_[i]  ? motion_for(body, *motions_[i], dt)
                                   : on_path(i) ? path_motion(i, time)
                                                : state_.motion[i];
    const BodyExtent extent = extent_of(body, dt, true);
    if (Status s = on_path(i) ? Status{} : check_motion(body, m, extent, time, dt); !s) {
      forget_motion(i);
      return s;
    }
    if (motions_[i]) steered_.push_back({body, motions_[i]->teleport, m, 0, 0});
    if (meshes_[i].set)
      reshaped_.push_back({body, lattice_.rests[i].first_point, b.vertices, meshes_[i].points.data()});
    const physics::RigidPlace now = physics::place_at(m, time);
    fastest =
        std::max(fastest, length(now.velocity) + length(now.angular_velocity) * extent.reach + extent.speed);
  }
  carried_speed_ = fastest;
  return {};
}

bool WorldImpl::on_path(std::size_t body) const {
  return !bodies_[body].desc.path.empty() && !motions_[body];
}

/// Of a body on a path, about a time [s]; in stored coordinates.
physics::RigidMotion WorldImpl::path_motion(std::size_t body, double at) const {
  const BodyRecord& b = bodies_[body];
  const Vec3d axis = b.desc.path_axis * (1 / length(b.desc.path_axis));
  return physics::motion_on(b.desc.path.data(), static_cast<std::uint32_t>(b.desc.path.size()), axis,
                            b.pivot - origin_, at);
}

/// Checks the parts of its path that lie in the next dt, and how fast it is there. A path that is refused stays.
Status WorldImpl::check_path(std::uint32_t body, double dt, double& fastest) const {
  const std::vector<PosePoint>& path = bodies_[body].desc.path;
  const auto points = static_cast<std::uint32_t>(path.size());
  const double end = time + dt;
  for (double from = time, until = end; from < end; from = until) {
    const std::uint32_t next = physics::points_until(path.data(), points, from);
    until = next < points ? std::min(path[next].time, end) : end;
    const physics::RigidMotion m = path_motion(body, from);
    const BodyExtent extent = extent_of(body, dt, true);
    if (Status s = check_motion(body, m, extent, from, until - from); !s) return s;
    const physics::RigidPlace now = physics::place_at(m, from);
    fastest =
        std::max(fastest, length(now.velocity) + length(now.angular_velocity) * extent.reach + extent.speed);
  }
  return {};
}

/// Bodies that come to another part of their path now, ahead of a part of a step; first: of the step, in which others are steered, too.
void WorldImpl::follow_paths(bool first) {
  if (!first) steered_.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (!bodies_[i].kinematic() || bodies_[i].gone || !on_path(i)) continue;
    const physics::RigidMotion m = path_motion(i, time), &now = state_.motion[i];
    if (m.from == now.from && m.until == now.until) continue;
    steered_.push_back({static_cast<std::uint32_t>(i), false, m, 0, 0});
  }
}

/// Largest sub-step in which no kinematic body crosses more of H than a particle may [s].
double WorldImpl::motion_dt() const {
  return carried_speed_ > 0 ? desc.courant * core::support_of(desc) / carried_speed_ : infinity;
}

}  // namespace v0
}  // namespace meltsim
