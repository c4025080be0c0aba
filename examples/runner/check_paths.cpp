// SPDX-License-Identifier: Apache-2.0
#include "check_paths.hpp"

#include <fmt/format.h>

#include <optional>

#include "expect.hpp"
#include "failure.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

// Of a spacing: places are read in single precision. A body that gets no further is left to the library.
constexpr double slack = 1e-3;
const char* const face_names[] = {"-x", "+x", "-y", "+y", "-z", "+z"};

/// Where and when a way ends.
struct Exit {
  int face;
  double after;  ///< [s] from now
};

/// Of particles, whose centres lie half a spacing inside the bounds.
std::optional<Exit> way_out(const meltsim::DomainDesc& domain, const meltsim::Box& bounds,
                            const meltsim::Vec3d& velocity, double spacing) {
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

}  // namespace

std::vector<std::string> check_paths(const Scene& scene, Built& built, double end) {
  std::vector<std::string> warnings;
  const meltsim::DomainDesc& domain = scene.world.domain;
  if (!domain.bounded) return warnings;
  const double now = built.world.time();
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces())) {
    const SceneBody& body = scene.bodies.at(piece.body.index);
    if (body.desc.motion != meltsim::Motion::kinematic) continue;
    const meltsim::BodyMotion motion = expect(built.world.motion(piece.body));
    if (length(motion.angular_velocity) > 0) continue;  // where it turns to is left to the library
    const std::optional<Exit> exit = way_out(domain, piece.bounds, motion.velocity, scene.world.spacing);
    if (!exit || !(now + exit->after < end)) continue;
    const auto key = body.source.keys.find("velocity");
    const std::string where = key == body.source.keys.end() ? body.source.where : key->second;
    const meltsim::Vec3d v = motion.velocity;
    const std::string text = fmt::format(
        "{}: {}.velocity: [{:g}, {:g}, {:g}] m/s takes \"{}\" through the wall {} at t={:.3g} s, "
        "before time.end {:g} s: the run would be refused there; use time.end {:.2g} or less, a "
        "velocity of at most {:.2g} of this one, or a domain with more room",
        where, body.source.path, v.x, v.y, v.z, piece.name, face_names[exit->face], now + exit->after, end,
        rounded_down(now + exit->after, 2), rounded_down(exit->after / (end - now), 2));
    if (!scene.time.until_melted && !built.body_melts.at(piece.body.index))
      throw Failure(ExitCode::scene, text);
    warnings.push_back(text);
  }
  return warnings;
}

}  // namespace runner
