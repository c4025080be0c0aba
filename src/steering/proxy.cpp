// SPDX-License-Identifier: Apache-2.0
// Proxies: rigid bodies that a host's physics engine owns; and forces on bodies that a host watches.
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Whether q is a unit quaternion within single precision.
constexpr double unit_tolerance = 1e-3;

bool is_zero(const Mat3<double>& a) {
  for (const auto& row : a.m)
    for (const double v : row)
      if (v != 0) return false;
  return true;
}

double trace(const Mat3<double>& a) { return a.m[0][0] + a.m[1][1] + a.m[2][2]; }

/// Whether no eigenvalue of a symmetric matrix is below `least`.
bool at_least(Mat3<double> a, double least) {
  for (int k = 0; k < 3; ++k) a.m[k][k] -= least;
  const auto minor = [&](int i, int j) { return a.m[i][i] * a.m[j][j] - a.m[i][j] * a.m[j][i]; };
  return a.m[0][0] >= 0 && a.m[1][1] >= 0 && a.m[2][2] >= 0 && minor(0, 1) >= 0 && minor(1, 2) >= 0 &&
         minor(2, 0) >= 0 && determinant(a) >= 0;
}

/// Whether lattice points are connected through their 26 direct neighbours.
bool one_piece(const std::vector<Vec3i>& points) {
  std::set<std::tuple<int, int, int>> left;
  for (const Vec3i& p : points) left.insert({p.x, p.y, p.z});
  std::vector<std::tuple<int, int, int>> stack{*left.begin()};
  left.erase(left.begin());
  while (!stack.empty()) {
    const auto [x, y, z] = stack.back();
    stack.pop_back();
    for (int k = 0; k < 27; ++k) {
      const auto found = left.find({x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1});
      if (found == left.end()) continue;
      stack.push_back(*found);
      left.erase(found);
    }
  }
  return left.empty();
}

}  // namespace

/// Checks of the members of a description that only proxies have.
Status WorldImpl::check_proxy(const SolidDesc& s, const std::string& what) const {
  if (s.motion != Motion::proxy) {
    if (s.mass != 0) return invalid(what, "mass: only of proxies; set motion to proxy, or leave it out");
    if (!is_zero(s.inertia))
      return invalid(what, "inertia: only of proxies; set motion to proxy, or leave it out");
    return {};
  }
  if (!(std::isfinite(s.mass) && s.mass > 0))
    return invalid(what, "mass: a proxy needs the mass that its host gives it, finite and > 0 kg, got ",
                   s.mass);
  if (materials[s.material.index].melts_into && desc.heat.model != HeatModel::none)
    return invalid(
        what, "material: \"", materials[s.material.index].name,
        "\" can melt, and the host would not know of it; use motion rigid, or a material that does "
        "not melt");
  if (materials[s.material.index].dissolves_in)
    return invalid(
        what, "material: \"", materials[s.material.index].name,
        "\" dissolves, and the host would not know of it; use motion rigid, or a material that does "
        "not dissolve");
  if (s.growth != 0)
    return invalid(what, "growth: a proxy has the mass that its host gives it and does not grow, got ",
                   s.growth, "; leave it out, or use motion rigid");
  if (is_zero(s.inertia)) return {};
  const double size = trace(s.inertia);
  if (!std::isfinite(size) || !(size > 0)) return invalid(what, "inertia: must be finite and positive");
  Mat3<double> second;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (!(std::fabs(s.inertia.m[i][j] - s.inertia.m[j][i]) <= 1e-6 * size))
        return invalid(what, "inertia: must be symmetric, got ", s.inertia.m[i][j], " and ",
                       s.inertia.m[j][i], " across the diagonal");
      second.m[i][j] = (i == j ? 0.5 * size : 0.0) - s.inertia.m[i][j];
    }
  if (!at_least(s.inertia, 1e-9 * size) || !at_least(second, -1e-6 * size))
    return invalid(what,
                   "inertia: no principal moment may be 0 or exceed the sum of the other two; give the "
                   "inertia about the centre of mass, in kg m^2");
  return {};
}

/// Fills in the inertia: of the mass spread evenly over cubes about the points.
Status WorldImpl::make_proxy(const std::string& what, const std::vector<Vec3i>& points,
                             const std::vector<Vec3d>& positions, Vec3d center, SolidDesc& s) const {
  if (!one_piece(points))
    return invalid(what, "shape: a proxy is one piece, and this shape is several at a spacing of ",
                   desc.spacing, " m; connect them, or add a proxy for each");
  if (!is_zero(s.inertia)) return {};
  const double each = s.mass / double(positions.size()), cube = each * desc.spacing * desc.spacing / 6;
  for (const Vec3d& p : positions) {
    const Vec3d r = p - center;
    add_outer(s.inertia, -each, r, r);
    for (int k = 0; k < 3; ++k) s.inertia.m[k][k] += each * dot(r, r) + cube;
  }
  return {};
}

Status WorldImpl::set_proxy(BodyId id, const ProxyState& given) {
  if (Status s = check_body("set_proxy", id); !s) return s;
  const BodyRecord& body = bodies_[id.index];
  const std::string what = "set_proxy: body \"" + body.desc.name + "\": ";
  if (!body.proxy())
    return invalid(what, "motion: not a proxy; build it with SolidDesc::motion proxy",
                   body.kinematic() ? ", or use set_motion" : "");
  if (!finite(given.position)) return invalid(what, "position: must be finite, got ", given.position);
  if (!finite(given.velocity)) return invalid(what, "velocity: must be finite, got ", given.velocity);
  if (!finite(given.angular_velocity))
    return invalid(what, "angular_velocity: must be finite, got ", given.angular_velocity);
  if (!finite(given.acceleration))
    return invalid(what, "acceleration: must be finite, got ", given.acceleration);
  ProxyState state = given;
  Quat<double>& q = state.orientation;
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(std::fabs(norm - 1) <= unit_tolerance))
    return invalid(what, "orientation: must be a unit quaternion, its norm is ", norm, "; divide it by that");
  q = {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
  if (state.teleport) {
    const physics::RigidPlace place = motion_for(state, 0).first;
    if (Status s = inside_walls(id.index, place, extent_of(id.index, 0, false)); !s) return s;
    if (Status s = clear_for_teleport(id.index, place); !s) return s;
  }
  proxies_[id.index] = state;
  return {};
}

/// The state in the form of the device (physics/proxy.hpp), for a step of dt.
physics::RigidMotion WorldImpl::motion_for(const ProxyState& state, double dt) const {
  physics::RigidMotion m;
  m.from = time;
  m.until = time + dt;
  m.first = {state.position - origin_, state.orientation, state.velocity, state.angular_velocity};
  m.then.position = state.acceleration;
  return m;
}

Result<ProxyState> WorldImpl::proxy(BodyId id) {
  if (Status s = check_body("proxy", id); !s) return s.error();
  if (!bodies_[id.index].proxy())
    return invalid("proxy: body \"", bodies_[id.index].desc.name,
                   "\": not a proxy; motion() has the motion of kinematic bodies, pieces() that of others");
  fetch_state();
  const physics::RigidMotion& m = state_.motion[id.index];
  ProxyState s;
  s.position = m.first.position + origin_;
  s.orientation = m.first.orientation;
  s.velocity = m.first.velocity;
  s.angular_velocity = m.first.angular_velocity;
  s.acceleration = m.then.position;
  return s;
}

Status WorldImpl::watch_forces(BodyId id, bool on) {
  if (Status s = check_body("watch_forces", id); !s) return s;
  BodyRecord& body = bodies_[id.index];
  if (!on && body.proxy())
    return invalid("watch_forces: body \"", body.desc.name,
                   "\": on: a proxy is always watched, since its host needs what acts on it");
  if (body.watched == on) return {};
  const bool planned = takes_new_plan() && !engine->host_captures();
  if (!planned) fetch_state();
  body.watched = on;
  lattice_.bodies[id.index].watched = on ? 1u : 0u;
  core::BodyForceTotals& forces = state_.forces[id.index] = {};
  if (!planned) {
    dirty_ = true;
    return {};
  }
  if (Status s = engine->set_body(id.index, lattice_.bodies[id.index]); !s) return s;
  if (on)
    if (Status s = engine->set_forces(id.index, body.first_vertex, forces); !s) return s;
  edited_in_place();
  return {};
}

/// Ahead of an upload: places of a body's particles are first summed relative to one of them.
void WorldImpl::place_forces() {
  state_.forces.resize(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].watched || state_.forces[b].seconds != 0) continue;
    const std::uint32_t first = state_.vertex_id[bodies_[b].first_vertex];
    if (first < state_.position.size()) state_.forces[b].center = state_.position[first];
  }
}

std::uint64_t WorldImpl::watched_bodies() const {
  return static_cast<std::uint64_t>(
      std::count_if(bodies_.begin(), bodies_.end(), [](const BodyRecord& b) { return b.watched; }));
}

Result<std::vector<BodyForces>> WorldImpl::take_forces() {
  core::ReadParts parts;
  parts.forces = true;
  const auto s = read_now(parts);
  if (!s) return s.error();
  state_stale_ = state_stale_ || !s->forces.empty();  // the device begins anew
  return forces_of(*s, watched(), origin_, time);
}

std::vector<bool> WorldImpl::watched() const {
  std::vector<bool> all(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) all[b] = bodies_[b].watched;
  return all;
}

std::vector<BodyForces> WorldImpl::forces_of(const core::StateReading& s, const std::vector<bool>& watched,
                                             Vec3d origin, double at) const {
  std::vector<BodyForces> all;
  const auto put = [](Impulse& to, const core::Impulses& from) {
    to.linear = from.linear;
    to.angular = from.angular;
  };
  for (std::size_t b = 0; b < std::min(s.forces.size(), watched.size()); ++b) {
    if (!watched[b]) continue;
    const core::BodyForceTotals& t = s.forces[b].totals;
    BodyForces f;
    f.body = id_of(b);
    f.seconds = t.seconds;
    put(f.total, t.all);
    put(f.pressure, t.pressure);
    put(f.contact, t.contact);
    f.viscosity.linear = t.all.linear - t.pressure.linear - t.contact.linear;
    f.viscosity.angular = t.all.angular - t.pressure.angular - t.contact.angular;
    f.heat = t.heat;
    f.position = t.center + origin;
    if (bodies_[b].proxy() || bodies_[b].kinematic()) {
      const physics::RigidMotion& m = s.forces[b].motion;
      const physics::RigidPlace p = bodies_[b].proxy() ? m.first : physics::place_at(m, at);
      f.position = p.position + origin;
      f.orientation = p.orientation;
      f.velocity = p.velocity;
      f.angular_velocity = p.angular_velocity;
    }
    all.push_back(f);
  }
  return all;
}

}  // namespace v0
}  // namespace meltsim
