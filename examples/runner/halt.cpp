// SPDX-License-Identifier: Apache-2.0
#include "halt.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "explicit_heat.hpp"
#include "numbers.hpp"

namespace runner {

std::string halt_text(const std::string& reason) {
  const std::size_t colon = reason.find(": ");
  return colon != std::string::npos && reason.compare(0, 9, "sub-step ") == 0 ? reason.substr(colon + 2)
                                                                              : reason;
}

std::string refusal_text(const Scene& scene, const std::string& message) {
  const std::string call = "set_motion: body \"";
  if (message.compare(0, call.size(), call) != 0) return message;
  for (const SceneBody& body : scene.bodies) {
    const std::string named = call + body.desc.name + "\": ";
    if (body.desc.name.empty() || message.compare(0, named.size(), named) != 0) continue;
    return fmt::format("{}: {} (\"{}\"): {}", body.source.where, body.source.path, body.desc.name,
                       message.substr(named.size()));
  }
  return message.substr(call.size() - 6);
}

namespace {

/// A body that has left through an open face, which only liquid is removed at, where the halt is of its particle; or empty.
std::string fallen_body(const Scene& scene, meltsim::World& world, const std::string& reason) {
  const meltsim::DomainDesc& domain = scene.world.domain;
  const auto pieces = world.pieces();
  if (!domain.bounded || !pieces) return {};
  const char* const names[] = {"-x", "+x", "-y", "+y", "-z", "+z"};
  for (const meltsim::PieceInfo& piece : *pieces) {
    const std::string& name = scene.bodies.at(piece.body.index).desc.name;
    if (reason.find("(body \"" + name + "\")") == std::string::npos) continue;
    const meltsim::Box& b = piece.bounds;
    const bool beyond[] = {b.max.x<domain.min.x, b.min.x> domain.max.x,
                           b.max.y<domain.min.y, b.min.y> domain.max.y,
                           b.max.z<domain.min.z, b.min.z> domain.max.z};
    for (std::size_t face = 0; face < 6; ++face)
      if (beyond[face] && domain.faces[face] == meltsim::Face::open)
        return fmt::format(
            "body \"{}\" has left the domain through its open face {} and is at ({:.3g}, {:.3g}, {:.3g}) m; "
            "only liquid is removed there: close the face (domain.walls: {{{}: wall}}), put a fixed body as "
            "a "
            "floor below it, or end the run before (time.end)",
            name, names[face], piece.center.x, piece.center.y, piece.center.z, names[face]);
  }
  return {};
}

}  // namespace

// A shorter step can help where the largest speed is one that things may have, not one that came of numbers gone wrong.
std::string halt_advice(const Scene& scene, meltsim::World& world, const meltsim::StepResult& result,
                        double dt, double coarseness) {
  if (const std::string fallen = fallen_body(scene, world, result.halt_reason); !fallen.empty())
    return fallen;
  constexpr double worth_trying = 1e-3;
  const double stable = world.stable_dt(), speed = result.max_speed;
  double limit = dt / 2;
  if (stable > 0) limit = std::min(limit, stable);
  if (speed > 0) limit = std::min(limit, scene.world.courant * world.resolved().support_radius / speed);
  const bool heat =
      (result.heat_bound_exceeded && result.halt_reason.find("not finite") != std::string::npos) ||
      result.halt_reason.find("enthalpy is not finite") != std::string::npos;
  const std::string cure = heat ? explicit_heat_cure(scene, world) : "";
  if (!cure.empty()) return cure;
  const bool numbers =
      result.halt_reason.find("not finite") != std::string::npos || !(limit > worth_trying * dt);
  if (numbers) {
    return "a shorter step will not help: look for an extreme density, stiffness, speed or temperature, and "
           "for "
           "things that overlap or stand in a wall";
  }
  limit = rounded_down(limit / coarseness, 1);
  return scene.time.adaptive ? fmt::format("try time.dt {:g} or a smaller solver.courant", limit)
                             : fmt::format("try dt {:g} or stepping: adaptive", limit);
}

}  // namespace runner
