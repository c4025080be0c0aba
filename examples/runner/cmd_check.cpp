// SPDX-License-Identifier: Apache-2.0
// `meltsim check`: builds the world, takes no step, and says what a run would be.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "build_world.hpp"
#include "commands.hpp"
#include "expect.hpp"
#include "heat_balance.hpp"
#include "numbers.hpp"
#include "stepper.hpp"

namespace runner {

namespace {

constexpr double pi = 3.14159265358979323846;

class Check {
 public:
  Check(const Scene& scene, Built& built) : scene_(scene), built_(built), now_(built.world.synchronize()) {}

  void print() {
    fmt::print("{}{}\n", scene_.name, scene_.title.empty() ? "" : ": " + scene_.title);
    fmt::print("backend     {}\n", backend_text(built_.world));
    print_particles();
    print_numbers();
    print_time();
    const meltsim::Plan plan = built_.world.plan();
    fmt::print("memory      {} for the World\n", bytes_text(static_cast<double>(plan.bytes)));
    if (const auto balance = heat_balance(built_))
      fmt::print("heat        {}\n", heat_balance_text(*balance));
    fmt::print("\n{}\n", plan.to_string());
    for (const std::string& warning : warnings_) fmt::print("warning: {}\n", warning);
    fmt::print("{}\n", warnings_.empty() ? "ok"
                                         : fmt::format("ok, {} warning{}", warnings_.size(),
                                                       warnings_.size() == 1 ? "" : "s"));
  }

 private:
  void print_particles() {
    std::uint64_t placed = 0;
    for (std::size_t i = 0; i < scene_.fluids.size(); ++i) {
      const std::uint64_t count = built_.fluid_particles[i];
      placed += count;
      fmt::print("fluids[{}]   {} particles of {}, {:g} C\n", i, count_text(count), scene_.fluids[i].material,
                 scene_.fluids[i].desc.temperature);
      print_left_out(scene_.fluids[i].desc, count);
    }
    print_bodies();
    for (const SceneEmitter& emitter : scene_.emitters) print_emitter(emitter);
    fmt::print("total       {} liquid and {} solid particles\n", count_text(now_.fluid),
               count_text(now_.solid));
    if (placed > now_.fluid) {
      fmt::print("overlaps    {} liquid particles lay inside bodies and were carved away\n",
                 count_text(placed - now_.fluid));
    } else {
      fmt::print("overlaps    none\n");
    }
    if (now_.fluid + now_.solid == 0 && scene_.emitters.empty()) warn("the scene holds no particles");
  }

  void print_left_out(const meltsim::FluidDesc& fluid, std::uint64_t count) {
    const meltsim::WorldDesc& world = scene_.world;
    const meltsim::Vec3d origin = world.domain.bounded ? world.domain.min : meltsim::Vec3d{};
    const std::uint64_t points = fluid.shape.lattice_points(origin, world.spacing).size();
    if (points > count)
      fmt::print(
          "            {} more are nearer to a wall than half a spacing or where there is liquid already\n",
          count_text(points - count));
  }

  void print_bodies() {
    for (const meltsim::PieceInfo& piece : expect(built_.world.pieces())) {
      const SceneBody& body = scene_.bodies.at(piece.body.index);
      fmt::print("body        \"{}\": {} particles of {}, {:.6g} kg, {:g} C{}\n", piece.name,
                 count_text(piece.particles), body.material, piece.mass, body.desc.temperature,
                 body.desc.fixed ? ", fixed" : "");
    }
  }

  void print_emitter(const SceneEmitter& emitter) {
    const meltsim::EmitterDesc& desc = emitter.desc;
    const double until = std::min(desc.until, scene_.time.end);
    const double volume = pi * desc.radius * desc.radius * desc.speed * std::max(0.0, until - desc.from);
    const auto count = static_cast<std::uint64_t>(volume / std::pow(scene_.world.spacing, 3));
    fmt::print("emitter     \"{}\": about {} particles of {} by t={:g} s, {:g} C\n", desc.name,
               count_text(count), emitter.material, until, desc.temperature);
  }

  void print_numbers() {
    const meltsim::Resolved resolved = built_.world.resolved();
    const double ratio = resolved.support_radius / scene_.world.spacing;
    fmt::print("particles   spacing {:.4g} m, support {:.4g} m ({:.3g} spacings)\n", scene_.world.spacing,
               resolved.support_radius, ratio);
    fmt::print("sound       {:.4g} m/s{}\n", resolved.sound_speed,
               scene_.world.sound_speed > 0 ? "" : " (auto)");
    if (ratio > 4) {
      warn(fmt::format(
          "support is {:.3g} spacings: above 4 it smooths detail away and costs {:.0f} neighbours", ratio,
          4.19 * ratio * ratio * ratio));
    }
  }

  void print_time() {
    const SceneTime& time = scene_.time;
    const double stable = built_.world.stable_dt(), frame = 1 / time.fps;
    fmt::print("time        {} stepping to t={:g} s{}, {:g} frames per second\n",
               time.adaptive ? "adaptive" : "fixed", time.end, time.until_melted ? " or until melted" : "",
               time.fps);
    fmt::print("stable dt   {:.4g} s at rest; motion lowers it\n", stable);
    const double efficiency = built_.world.resolved().heat_efficiency;
    if (efficiency < 1)
      warn(fmt::format(
          "heat.model paper delivers {:.0f} % of the diffusivity asked for at a sub-step of {:.4g} s; "
          "its energy drifts (thermal_J in stats.csv). heat.model: enthalpy delivers all of it",
          100 * efficiency, stable));
    if (time.adaptive) return;
    const double wanted = time.dt.value_or(automatic_dt(stable, frame));
    const double dt = fixed_frame_dt(0, frame, wanted),
                 substeps = std::max(1.0, std::ceil(dt / stable - 1e-9));
    fmt::print("dt          {:.4g} s, {:.0f} sub-step{} each, {:.0f} steps\n", dt, substeps,
               substeps > 1 ? "s" : "", std::ceil(time.end / dt - 1e-6));
    if (substeps > scene_.world.max_substeps) {
      warn(fmt::format("dt {:g} s needs {:.0f} sub-steps, more than solver.max_substeps {}; try dt {:.2g}",
                       dt, substeps, scene_.world.max_substeps, stable * scene_.world.max_substeps));
    } else if (substeps > 1) {
      warn(fmt::format("dt {:g} s is above the stable {:.3g} s, so each step is split into {:.0f}", dt,
                       stable, substeps));
    }
    if (std::abs(dt - wanted) > 1e-9 * wanted) {
      warn(fmt::format("dt {:g} s does not divide the frame interval {:g} s; a run uses {:.6g} s", wanted,
                       frame, dt));
    }
  }

  void warn(const std::string& text) { warnings_.push_back(text); }

  const Scene& scene_;
  Built& built_;
  meltsim::StepResult now_;
  std::vector<std::string> warnings_;
};

}  // namespace

int cmd_check(const SceneOptions& options, const MachineOptions& machine) {
  const Scene scene = load_scene(options);
  Built built = build_world(scene, machine);
  Check(scene, built).print();
  return 0;
}

}  // namespace runner
