// SPDX-License-Identifier: Apache-2.0
#include "halt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "explicit_heat.hpp"
#include "failure.hpp"
#include "numbers.hpp"
#include "stepper.hpp"

namespace runner {

std::string halt_text(const std::string& reason) {
  const std::size_t colon = reason.find(": ");
  return colon != std::string::npos && reason.compare(0, 9, "sub-step ") == 0 ? reason.substr(colon + 2)
                                                                              : reason;
}

namespace {

/// Temperatures that a liquid has at the start, or comes with [degrees Celsius].
std::pair<double, double> start_temperatures(const Scene& scene, const std::string& material) {
  std::pair<double, double> range{meltsim::infinity, -meltsim::infinity};
  const auto see = [&range](double t) { range = {std::min(range.first, t), std::max(range.second, t)}; };
  for (const SceneFluid& fluid : scene.fluids)
    if (fluid.material == material) see(fluid.desc.temperature);
  for (const SceneEmitter& emitter : scene.emitters)
    if (emitter.material == material) see(emitter.desc.temperature);
  for (const SceneMaterial& solid : scene.materials)
    if (solid.becomes == material && std::isfinite(solid.desc.melting_point)) see(solid.desc.melting_point);
  return range;
}

/// What a scene can do beside what the library advises where too many sub-steps or super-steps are needed.
std::string viscosity_advice(const Scene& scene, const std::string& message) {
  if (message.find("more than max_substeps") == std::string::npos) return "";
  const bool implicit = message.find("viscosity needs") != std::string::npos;
  if (!implicit && scene.world.viscosity != meltsim::Viscosity::explicit_) return "";
  std::string text =
      implicit ? "" : "; where it is viscosity that limits sub-steps, solver.viscosity: implicit";
  for (const SceneMaterial& m : scene.materials) {
    const auto& points = m.desc.viscosity_points;
    const auto most = std::max_element(points.begin(), points.end(),
                                       [](const auto& a, const auto& b) { return a.value < b.value; });
    const auto [coldest, hottest] = start_temperatures(scene, m.desc.name);
    if (most == points.end() || !(coldest <= hottest)) continue;
    if (most->temperature >= coldest && most->temperature <= hottest) continue;
    const std::string here =
        coldest < hottest ? fmt::format("{:g} to {:g} C", coldest, hottest) : fmt::format("{:g} C", coldest);
    text += fmt::format(
        "; of materials.{}.viscosity the largest value counts, {:g} Pa s at {:g} C, which nothing has at the "
        "start ({}): cap the table",
        m.desc.name, most->value, most->temperature, here);
  }
  return text;
}

}  // namespace

std::string refusal_text(const Scene& scene, const std::string& message) {
  const std::string call = "set_motion: body \"";
  if (message.compare(0, call.size(), call) != 0) return message + viscosity_advice(scene, message);
  for (const SceneBody& body : scene.bodies) {
    const std::string named = call + body.desc.name + "\": ";
    if (body.desc.name.empty() || message.compare(0, named.size(), named) != 0) continue;
    return fmt::format("{}: {} (\"{}\"): {}", body.source.where, body.source.path, body.desc.name,
                       message.substr(named.size()));
  }
  return message.substr(call.size() - 6);
}

void refuse_long_dt(const Scene& scene, const meltsim::World& world) {
  if (scene.time.adaptive || !scene.time.dt) return;
  const double dt = fixed_frame_dt(0, 1 / scene.time.fps, *scene.time.dt), stable = world.stable_dt();
  const double substeps = std::ceil(dt / stable - 1e-9);
  if (substeps <= scene.world.max_substeps) return;
  throw Failure(ExitCode::scene,
                fmt::format("{}: time.dt: {:g} s needs {:.0f} sub-steps of at most {:.6g} s, more than "
                            "solver.max_substeps {}; use time.dt {:g}, or stepping: adaptive",
                            scene.time.dt_where, *scene.time.dt, substeps, stable, scene.world.max_substeps,
                            rounded_down(stable * scene.world.max_substeps, 2)));
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
