// SPDX-License-Identifier: Apache-2.0
#include "check_paths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "expect.hpp"
#include "failure.hpp"
#include "meltsim/physics/path.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

using meltsim::Vec3d;

// Of a spacing: places are read in single precision. A body that gets no further is left to the library.
constexpr double slack = 1e-3;
// Spacings that a body that turns moves between two looks, and how many there are at most.
constexpr double look = 0.1, most_looks = 1e6;
const char* const face_names[] = {"-x", "+x", "-y", "+y", "-z", "+z"};

/// Where and when a way ends.
struct Exit {
  int face;
  double after;         ///< [s] from now
  bool certain = true;  ///< in the steps of every run
};

/// Of particles, whose centres lie half a spacing inside the bounds.
std::optional<Exit> way_out(const meltsim::DomainDesc& domain, const meltsim::Box& bounds,
                            const Vec3d& velocity, double spacing) {
  std::optional<Exit> first;
  const auto face = [&](int number, double room, double speed) {
    if (domain.faces[static_cast<std::size_t>(number)] != meltsim::Face::wall || !(speed > 0)) return;
    const double after = (room + (0.5 + slack) * spacing) / speed;
    if (!first || after < first->after) first = Exit{number, after};
  };
  face(0, bounds.min.x - domain.min.x, -velocity.x);
  face(1, domain.max.x - bounds.max.x, velocity.x);
  face(2, bounds.min.y - domain.min.y, -velocity.y);
  face(3, domain.max.y - bounds.max.y, velocity.y);
  face(4, bounds.min.z - domain.min.z, -velocity.z);
  face(5, domain.max.z - bounds.max.z, velocity.z);
  return first;
}

/// A body that turns, or moves along a path: the ends of its rows of particles, which reach as far as it does, and the corners of the box around them.
class Turning {
 public:
  Turning(const Scene& scene, Built& built, meltsim::BodyId body)
      : domain_(scene.world.domain),
        spacing_(scene.world.spacing),
        now_(built.world.time()),
        desc_(scene.bodies.at(body.index).desc) {
    const meltsim::BodyMotion motion = expect(built.world.motion(body));
    start_.position = *motion.position;
    start_.velocity = motion.velocity;
    start_.angular_velocity = motion.angular_velocity;
    const meltsim::ParticleData now = expect(built.world.particles());
    std::map<std::pair<long, long>, std::pair<Vec3d, Vec3d>> rows;
    for (std::size_t i = 0; i < now.id.size(); ++i) {
      if (!meltsim::is_solid(now.tag[i]) || meltsim::body_of(now.tag[i]) != body.index + 1) continue;
      const Vec3d arm = now.position[i] - start_.position;
      const std::pair<long, long> row{std::lround(arm.y / spacing_ * 4), std::lround(arm.z / spacing_ * 4)};
      auto& ends = rows.emplace(row, std::pair{arm, arm}).first->second;
      if (arm.x < ends.first.x) ends.first = arm;
      if (arm.x > ends.second.x) ends.second = arm;
    }
    for (const auto& [row, ends] : rows)
      for (const Vec3d& arm : {ends.first, ends.second}) add(arm);
  }

  /// When it is first beyond a wall. `frame`: every run ends a step at least so often [s].
  std::optional<Exit> way_out(double until, double frame) const {
    const std::vector<meltsim::PosePoint>& path = desc_.path;
    const double rate = length(start_.angular_velocity), arm = std::max(reach_, spacing_);
    if ((!(rate > 0) && path.empty()) || arms_.empty()) return std::nullopt;
    double speed = length(start_.velocity) + rate * arm;
    for (std::size_t k = 1; k < path.size(); ++k)
      speed = std::max(speed, (length(path[k].displacement - path[k - 1].displacement) +
                               std::fabs(path[k].angle - path[k - 1].angle) * arm) /
                                  (path[k].time - path[k - 1].time));
    if (!(speed > 0)) return std::nullopt;
    // What turns about a place that stays comes round to where it was; at the end of a path it rests.
    if (!path.empty()) until = std::min(until, path.back().time - now_ + frame);
    else if (length(start_.velocity) == 0) until = std::min(until, 2 * pi / rate);
    const double step = std::max(look * spacing_ / speed, until / most_looks);
    for (double t = step; t < until; t += step) {
      const std::optional<int> face = beyond(t);
      if (!face) continue;
      bool certain = true;
      for (double later = t; certain && later < std::min(t + frame, until); later += step)
        certain = beyond(later).has_value();
      return Exit{*face, first_beyond(t - step, t), certain};
    }
    return std::nullopt;
  }

 private:
  /// Of two times, the body beyond a wall at the later one alone.
  double first_beyond(double before, double after) const {
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (before + after);
      (beyond(middle) ? after : before) = middle;
    }
    return after;
  }

  static constexpr double pi = 3.14159265358979323846;

  void add(const Vec3d& arm) {
    if (arms_.empty()) box_ = {arm, arm};
    arms_.push_back(arm);
    reach_ = std::max(reach_, length(arm));
    box_.min = {std::min(box_.min.x, arm.x), std::min(box_.min.y, arm.y), std::min(box_.min.z, arm.z)};
    box_.max = {std::max(box_.max.x, arm.x), std::max(box_.max.y, arm.y), std::max(box_.max.z, arm.z)};
  }

  std::optional<int> wall_behind(const Vec3d& x) const {
    const double over[] = {domain_.min.x - x.x, x.x - domain_.max.x, domain_.min.y - x.y,
                           x.y - domain_.max.y, domain_.min.z - x.z, x.z - domain_.max.z};
    for (int face = 0; face < 6; ++face)
      if (domain_.faces[static_cast<std::size_t>(face)] == meltsim::Face::wall &&
          over[face] > slack * spacing_)
        return face;
    return std::nullopt;
  }

  meltsim::physics::RigidPlace place_after(double after) const {
    const std::vector<meltsim::PosePoint>& path = desc_.path;
    if (path.empty()) return meltsim::physics::moved_on(start_, after);
    const Vec3d axis = desc_.path_axis * (1 / length(desc_.path_axis));
    const auto points = static_cast<std::uint32_t>(path.size());
    return meltsim::physics::place_at(
        meltsim::physics::motion_on(path.data(), points, axis, start_.position, now_ + after), now_ + after);
  }

  /// The wall that a particle is beyond after a time [s].
  std::optional<int> beyond(double after) const {
    const meltsim::physics::RigidPlace place = place_after(after);
    bool near = false;
    for (int corner = 0; corner < 8; ++corner)
      near = near || wall_behind(meltsim::physics::point_of(place, {corner & 1 ? box_.min.x : box_.max.x,
                                                                    corner & 2 ? box_.min.y : box_.max.y,
                                                                    corner & 4 ? box_.min.z : box_.max.z})
                                     .position);
    if (!near) return std::nullopt;
    for (const Vec3d& arm : arms_)
      if (const auto face = wall_behind(meltsim::physics::point_of(place, arm).position)) return face;
    return std::nullopt;
  }

  const meltsim::DomainDesc& domain_;
  double spacing_, now_;
  const meltsim::SolidDesc& desc_;
  meltsim::physics::RigidPlace start_;  ///< of a body on a path, as built
  std::vector<Vec3d> arms_;
  meltsim::Box box_{};
  double reach_ = 0;
};

/// What is said of a kinematic body that reaches through a wall; nothing where it does not.
std::optional<std::string> refused_way(const Scene& scene, const meltsim::PieceInfo& piece,
                                       const meltsim::BodyMotion& motion, const std::optional<Exit>& exit,
                                       double now, double end) {
  if (!exit || !(now + exit->after < end)) return std::nullopt;
  const SceneBody& body = scene.bodies.at(piece.body.index);
  if (!body.desc.path.empty()) {
    const auto path = body.source.keys.find("path");
    return fmt::format(
        "{}: {}.path: takes \"{}\" through the wall {} at t={:.3g} s, before time.end {:g} s: the run would "
        "be refused there; "
        "use time.end {:.2g} or less, another path, or a domain with more room",
        path == body.source.keys.end() ? body.source.where : path->second, body.source.path, piece.name,
        face_names[exit->face], now + exit->after, end, rounded_down(now + exit->after, 2));
  }
  const bool turns = length(motion.angular_velocity) > 0;
  const char* const key = turns ? "angular_velocity" : "velocity";
  const auto found = body.source.keys.find(key);
  const std::string where = found == body.source.keys.end() ? body.source.where : found->second;
  const Vec3d v = turns ? motion.angular_velocity : motion.velocity;
  return fmt::format(
      "{}: {}.{}: [{:g}, {:g}, {:g}] {} \"{}\" through the wall {} at t={:.3g} s, before time.end {:g} s: "
      "the "
      "run would be refused there; use time.end {:.2g} or less, {}, or a domain with more room",
      where, body.source.path, key, v.x, v.y, v.z, turns ? "rad/s turns" : "m/s takes", piece.name,
      face_names[exit->face], now + exit->after, end, rounded_down(now + exit->after, 2),
      turns ? "another pivot"
            : fmt::format("a velocity of at most {:.2g} of this one",
                          rounded_down(exit->after / (end - now), 2)));
}

std::optional<Exit> way_of(const Scene& scene, Built& built, const meltsim::PieceInfo& piece,
                           const meltsim::BodyMotion& motion, double left) {
  if (!(length(motion.angular_velocity) > 0) && scene.bodies.at(piece.body.index).desc.path.empty())
    return way_out(scene.world.domain, piece.bounds, motion.velocity, scene.world.spacing);
  return Turning(scene, built, piece.body).way_out(left, 1 / scene.time.fps);
}

double along(const Vec3d& v, std::size_t axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// A face that things fall towards.
struct Fall {
  std::size_t axis = 1;
  double down = -1;  ///< direction along the axis
  std::size_t face = 2;
};

/// Of gravity along an axis, where that face is open.
std::optional<Fall> open_below(const meltsim::WorldDesc& world) {
  const Vec3d g = world.gravity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(std::fabs(along(g, axis)) > 0.99 * length(g))) continue;
    const double down = along(g, axis) > 0 ? 1 : -1;
    const std::size_t face = 2 * axis + (down > 0 ? 1 : 0);
    if (world.domain.faces[face] == meltsim::Face::open) return Fall{axis, down, face};
  }
  return std::nullopt;
}

/// Whether something of `other` is straight below the top of `box`.
bool is_below(const meltsim::Box& other, const meltsim::Box& box, const Fall& fall) {
  if (!(other.min.x <= other.max.x)) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis == fall.axis) continue;
    if (along(other.max, axis) <= along(box.min, axis) || along(other.min, axis) >= along(box.max, axis))
      return false;
  }
  return fall.down < 0 ? along(other.min, fall.axis) < along(box.max, fall.axis)
                       : along(other.max, fall.axis) > along(box.min, fall.axis);
}

bool holds(const SceneBody& body) {
  return body.desc.fixed || body.desc.motion == meltsim::Motion::fixed ||
         body.desc.motion == meltsim::Motion::kinematic;
}

/// Bodies that fall out and on and on: only liquid is removed at an open face.
std::vector<std::string> falls_out(const Scene& scene, Built& built, double end) {
  std::vector<std::string> warnings;
  const std::optional<Fall> fall = open_below(scene.world);
  if (!fall || !scene.emitters.empty() || !scene.force_fields.empty()) return warnings;
  const double g = length(scene.world.gravity);
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces())) {
    const SceneBody& body = scene.bodies.at(piece.body.index);
    const double start = along(piece.velocity, fall->axis);
    if (holds(body) || length(piece.velocity) > 1.01 * std::fabs(start)) continue;
    const auto below = [&](const auto& o) { return is_below(o.desc.shape.bounds(), piece.bounds, *fall); };
    if (std::any_of(scene.fluids.begin(), scene.fluids.end(), below) ||
        std::any_of(scene.bodies.begin(), scene.bodies.end(),
                    [&](const SceneBody& o) { return holds(o) && below(o); }))
      continue;
    const double way = fall->down < 0
                           ? along(piece.bounds.max, fall->axis) - along(scene.world.domain.min, fall->axis)
                           : along(scene.world.domain.max, fall->axis) - along(piece.bounds.min, fall->axis);
    const double speed = start * fall->down,
                 out = body.desc.held_until + (std::sqrt(speed * speed + 2 * g * way) - speed) / g;
    if (!(out < end)) continue;
    warnings.push_back(fmt::format(
        "{}: {}: \"{}\" falls out of the domain through its open face {} by t={:.2g} s, before time.end {:g} "
        "s: "
        "only liquid is removed there, and a run ends when a body is too fast; close the face "
        "(domain.walls: {{{}: wall}}), put a fixed body as a floor below it, or use time.end {:.2g} or less",
        body.source.where, body.source.path, piece.name, face_names[fall->face], out, end,
        face_names[fall->face], rounded_down(out, 2)));
  }
  return warnings;
}

/// Liquid with nothing below it, all of which is gone before the end.
std::vector<std::string> liquid_falls_out(const Scene& scene, double end) {
  const std::optional<Fall> fall = open_below(scene.world);
  if (!fall || scene.fluids.empty() || !scene.emitters.empty() || !scene.force_fields.empty()) return {};
  double out = 0;
  for (const SceneFluid& fluid : scene.fluids) {
    const meltsim::Box box = fluid.desc.shape.bounds();
    const auto below = [&](const SceneBody& o) { return is_below(o.desc.shape.bounds(), box, *fall); };
    if (std::any_of(scene.bodies.begin(), scene.bodies.end(), below)) return {};
    const double way = fall->down < 0
                           ? along(box.max, fall->axis) - along(scene.world.domain.min, fall->axis)
                           : along(scene.world.domain.max, fall->axis) - along(box.min, fall->axis);
    const double g = length(scene.world.gravity), speed = along(fluid.desc.velocity, fall->axis) * fall->down;
    out = std::max(out, (std::sqrt(std::max(0.0, speed * speed + 2 * g * way)) - speed) / g);
  }
  if (!(out < end)) return {};
  return {fmt::format(
      "{}: domain.walls: gravity points out of the open face {} and nothing is below the liquid: all of it "
      "falls out of the domain by t={:.2g} s, before time.end {:g} s; close the face (domain.walls: {{{}: "
      "wall}}), put a fixed body as a floor below it, or turn solver.gravity",
      scene.domain.where.empty() ? scene.where : scene.domain.where, face_names[fall->face], out, end,
      face_names[fall->face])};
}

}  // namespace

std::vector<std::string> check_paths(const Scene& scene, Built& built, double end) {
  std::vector<std::string> warnings;
  if (!scene.world.domain.bounded) return warnings;
  const double now = built.world.time();
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces())) {
    const SceneBody& body = scene.bodies.at(piece.body.index);
    if (body.desc.motion != meltsim::Motion::kinematic) continue;
    const meltsim::BodyMotion motion = expect(built.world.motion(piece.body));
    const std::optional<Exit> exit = way_of(scene, built, piece, motion, end - now);
    const std::optional<std::string> text = refused_way(scene, piece, motion, exit, now, end);
    if (!text) continue;
    if (exit->certain && !scene.time.until_melted && !built.body_melts.at(piece.body.index))
      throw Failure(ExitCode::scene, *text);
    warnings.push_back(*text);
  }
  for (std::string& warning : falls_out(scene, built, end)) warnings.push_back(std::move(warning));
  for (std::string& warning : liquid_falls_out(scene, end)) warnings.push_back(std::move(warning));
  return warnings;
}

}  // namespace runner
