// SPDX-License-Identifier: Apache-2.0
// `meltsim check`: builds the world, says what a run would be, and measures a few steps and a frame of it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "build_world.hpp"
#include "check_paths.hpp"
#include "check_units.hpp"
#include "commands.hpp"
#include "deep_bodies.hpp"
#include "enclosed_liquid.hpp"
#include "expect.hpp"
#include "explicit_heat.hpp"
#include "failure.hpp"
#include "freezing.hpp"
#include "halt.hpp"
#include "heat_balance.hpp"
#include "heat_regions.hpp"
#include "library_error.hpp"
#include "meltsim/physics/artificial_viscosity.hpp"
#include "meltsim/physics/flow_curve.hpp"
#include "meltsim/physics/surface_tension.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"
#include "missing_mass.hpp"
#include "numbers.hpp"
#include "rehearsal.hpp"
#include "room_to_melt.hpp"
#include "run_directory.hpp"
#include "saturation.hpp"
#include "show/frame_export.hpp"
#include "show/programs.hpp"
#include "stepper.hpp"
#include "thin_layers.hpp"
#include "thin_walls.hpp"

namespace runner {

namespace {

// Steps are timed for so long, the first one left out: it prepares what others use.
constexpr double timing_s = 0.4;

// A scene that begins empty is filled with so many particles, for so long at most, before anything of it is measured.
constexpr double enough_particles = 1000, filling_s = 2;

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// "0.42 s", "3 min": an estimate has no more digits than it deserves.
std::string about(double seconds) {
  if (seconds < 1) return "a second";
  if (seconds < 100) return fmt::format("{:.2g} s", seconds);
  if (seconds < 6000) return fmt::format("{:.2g} min", seconds / 60);
  if (seconds < 72 * 3600) return fmt::format("{:.2g} hours", seconds / 3600);
  return fmt::format("{:.2g} days", seconds / 86400);
}

class Check {
 public:
  Check(const Scene& scene, Built& built, bool verbose)
      : scene_(scene),
        built_(built),
        now_(built.world.synchronize()),
        balance_(heat_balance(scene, built)),
        verbose_(verbose) {
    for (const std::string& warning : scene.warnings) warn(warning);
    for (const std::string& warning : missing_mass(scene, built)) warn(warning);
    for (const std::string& warning : room_to_melt(scene, built)) warn(warning);
    for (const std::string& warning : deep_bodies(scene)) warn(warning);
    for (const std::string& warning : thin_walls(scene, built)) warn(warning);
    for (const std::string& warning : thin_layers(scene, built)) warn(warning);
    for (const std::string& warning : enclosed_liquid(scene, built)) warn(warning);
    for (const std::string& warning : uneven_regions(scene)) warn(warning);
    if (now_.solid > 0)
      for (const std::string& warning : softer_than_asked(built)) warn(warning);
  }

  void print() {
    fmt::print("{}{}\n", scene_.name, scene_.title.empty() ? "" : ": " + scene_.title);
    line("backend", backend_text(built_.world));
    print_particles();
    print_bodies();
    print_viscosity();
    print_species();
    print_tension();
    print_yield();
    print_time();
    if (!doubts_.empty()) try_first_step();
    const meltsim::Plan plan = built_.world.plan();
    line("memory", memory_text(built_));
    if (verbose_) print_parts();
    std::fflush(stdout);  // what follows takes seconds
    std::optional<Rehearsal> rehearsal;
    if (built_.meltable > 0) rehearsal = rehearse(scene_, built_);
    if (rehearsal) see_what_melted_away(*rehearsal);
    print_sources();
    print_heat();
    print_freezing();
    print_melting(rehearsal);
    print_cost(rehearsal);
    if (verbose_) fmt::print("\n{}\n", plan.to_string());
    for (const std::string& warning : warnings_) fmt::print("warning: {}\n", warning);
    fmt::print("{}{}\n",
               warnings_.empty()
                   ? "ok"
                   : fmt::format("ok, {} warning{}", warnings_.size(), warnings_.size() == 1 ? "" : "s"),
               verbose_ ? "" : "; --verbose says more");
  }

 private:
  static void line(const char* label, const std::string& text) { fmt::print("{:<12}{}\n", label, text); }

  void print_particles() {
    const meltsim::Resolved resolved = built_.world.resolved();
    const double ratio = resolved.support_radius / scene_.world.spacing;
    line("particles",
         fmt::format("{} liquid and {} solid, {:.4g} m apart; support {:.4g} m", count_text(now_.fluid),
                     count_text(now_.solid), scene_.world.spacing, resolved.support_radius));
    if (now_.fluid + now_.solid == 0 && scene_.emitters.empty()) warn("the scene holds no particles");
    if (ratio > 4) {
      warn(fmt::format(
          "support is {:.3g} spacings: above 4 it smooths detail away and costs {:.0f} neighbours", ratio,
          4.19 * ratio * ratio * ratio));
    }
  }

  std::string body_text(const meltsim::PieceInfo& piece) const {
    const SceneBody& body = scene_.bodies.at(piece.body.index);
    return fmt::format("\"{}\": {} particles of {}, {:.6g} kg, {:g} C{}", piece.name,
                       count_text(piece.particles), body.material, piece.mass, body.desc.temperature,
                       body.desc.fixed                              ? ", fixed"
                       : body.desc.motion == meltsim::Motion::rigid ? ", rigid"
                                                                    : "");
  }

  void print_bodies() {
    const std::vector<meltsim::PieceInfo> pieces = expect(built_.world.pieces());
    if (verbose_)
      for (const meltsim::PieceInfo& piece : pieces) line("body", body_text(piece));
    else if (!pieces.empty())
      line("body", body_text(pieces[0]) +
                       (pieces.size() > 1 ? fmt::format("; and {} more", pieces.size() - 1) : std::string()));
  }

  /// What is in proportion to the viscosity of a material, `scale` times it; from the least to the largest of a table.
  static std::string of_viscosity(const meltsim::MaterialDesc& m, double scale) {
    double least = m.viscosity, largest = m.viscosity;
    if (!m.viscosity_points.empty()) {
      least = largest = m.viscosity_points.front().value;
      for (const meltsim::PropertyPoint& point : m.viscosity_points)
        least = std::min(least, point.value), largest = std::max(largest, point.value);
    }
    return least == largest ? fmt::format("{:.2g}", scale * least)
                            : fmt::format("{:.2g} to {:.2g}", scale * least, scale * largest);
  }

  /// Of each liquid as its viscosity stands in the scene, and what the artificial one adds.
  void print_viscosity() {
    if (now_.fluid == 0 && scene_.emitters.empty()) return;
    const meltsim::Resolved resolved = built_.world.resolved();
    const double added = meltsim::physics::artificial_kinematic_viscosity(
        scene_.world.artificial_viscosity, resolved.sound_speed, resolved.support_radius);
    std::string text = fmt::format("sound {:.4g} m/s{}", resolved.sound_speed,
                                   scene_.world.sound_speed > 0 ? "" : " (auto)");
    if (added > 0) {
      text += fmt::format("; artificial_viscosity {:g} acts like {:.2g} m^2/s",
                          scene_.world.artificial_viscosity, added);
      for (const SceneMaterial& material : scene_.materials) {
        const auto of_this = [&](const auto& o) { return o.material == material.desc.name; };
        const bool flows = std::any_of(scene_.fluids.begin(), scene_.fluids.end(), of_this) ||
                           std::any_of(scene_.emitters.begin(), scene_.emitters.end(), of_this);
        if (!flows) continue;
        text += fmt::format(", {} itself has {}", material.desc.name,
                            of_viscosity(material.desc, 1 / material.desc.density));
        break;
      }
    }
    line("liquid", text);
    print_stages(resolved);
  }

  /// Sub-step that the scene takes at rest [s]; what a step of a scene needs is in proportion to it, rounded up.
  double substep() const {
    const double stable = built_.world.stable_dt(), frame = 1 / scene_.time.fps;
    if (scene_.time.adaptive) return std::min({stable, frame, scene_.time.dt.value_or(frame)});
    const double dt = fixed_frame_dt(0, frame, scene_.time.dt.value_or(automatic_dt(stable, frame)));
    return dt / std::max(1.0, std::ceil(dt / stable - 1e-9));
  }

  /// Where viscosity would limit the sub-step.
  void print_stages(const meltsim::Resolved& r) {
    if (r.viscosity == meltsim::Viscosity::implicit) {
      const std::string of = fmt::format("{} stage{}", r.viscous_stages, r.viscous_stages == 1 ? "" : "s");
      line("viscosity",
           fmt::format("implicit, {} per sub-step; explicit, sub-steps would be at most {:.3g} s",
                       r.viscous_supersteps == 1 ? of : fmt::format("{} times {}", r.viscous_supersteps, of),
                       r.viscous_dt));
      const double needed = std::floor(substep() / r.stable_dt * r.viscous_supersteps);
      if (const int most = scene_.world.max_substeps; needed > most)
        doubt(
            fmt::format("viscosity takes at least {:.0f} super-steps of {} stages per sub-step, more than "
                        "solver.max_substeps {}: "
                        "steps will be refused; raise solver.max_substeps, use a shorter time.dt or a larger "
                        "particles.spacing, and check viscosity and yield_stress",
                        needed, r.viscous_stages, most));
      else if (r.viscous_supersteps > 2)
        warn(
            fmt::format("viscosity takes {} sweeps over all neighbours per sub-step; a larger "
                        "particles.spacing takes fewer; viscosities are in Pa s (water 0.001, honey 10)",
                        r.viscous_stages * r.viscous_supersteps));
    } else if (r.viscous_dt <= r.stable_dt) {
      line("viscosity", fmt::format("explicit: limits sub-steps to {:.3g} s", r.viscous_dt));
    }
  }

  /// What yield stress does in the scene, and how much of it the spacing resolves.
  void print_yield() {
    const double dx = scene_.world.spacing, g = length(scene_.world.gravity);
    const meltsim::Resolved r = built_.world.resolved();
    const double speed = speed_of(scene_, true), depth = g > 0 ? speed * speed / (2 * g) : 0;
    for (const SceneMaterial& material : scene_.materials) {
      const meltsim::MaterialDesc& m = material.desc;
      double yield = m.yield_stress_points.empty() ? m.yield_stress : 0, least = yield;
      std::string stress = fmt::format("{:g} Pa", yield);
      if (!m.yield_stress_points.empty()) {
        stress.clear();
        least = m.yield_stress_points.front().value;
        for (const meltsim::PropertyPoint& point : m.yield_stress_points) {
          yield = std::max(yield, point.value);
          least = std::min(least, point.value);
          stress +=
              fmt::format("{}{:g} Pa at {:g} C", stress.empty() ? "" : ", ", point.value, point.temperature);
        }
      }
      if (!(yield > 0)) continue;
      const double consistency = m.viscosity_points.empty() ? m.viscosity : m.viscosity_points.front().value;
      std::string text = fmt::format("{}: {}", m.name, stress);
      if (g > 0) {
        const double bank = 2 * yield / (m.density * g);
        text += fmt::format("; a bank of {:.2g} m stands{}, {:.2g} spacings", bank,
                            least < yield ? " at most" : "", bank / dx);
        if (bank < dx && !(least < yield))
          warn(
              fmt::format("materials.{}: a bank of {:.2g} m stands by itself, {:.2g} spacings: how thick "
                          "layers stay is not "
                          "resolved; use a particles.spacing of {:.2g} or less",
                          m.name, bank, bank / dx, bank / 2));
        if (consistency > 0 && speed > 0)
          text += fmt::format(
              ", Bingham number {:.2g} at {:.2g} m/s, a fall of {:.2g} m, {:.2g} at a tenth of that speed",
              meltsim::physics::bingham_number(yield, consistency, m.flow_index, speed, depth), speed, depth,
              meltsim::physics::bingham_number(yield, consistency, m.flow_index, 0.1 * speed, depth));
      }
      line("yield", text + fmt::format("; {:.3g} Pa s at rest",
                                       yield * m.regularisation +
                                           consistency * std::pow(m.regularisation, 1 - m.flow_index)));
    }
  }

  /// How thin the layers of a species are in liquid as fast as the scene's, beside the spacing. What flows along a length L at
  /// speed v has a layer of sqrt(D L/v).
  std::string species_text(const SceneMaterial& m) {
    const auto solvent = std::find_if(scene_.materials.begin(), scene_.materials.end(),
                                      [&m](const SceneMaterial& o) { return o.desc.name == m.dissolves_in; });
    const meltsim::MaterialDesc& liquid = solvent->desc;
    const std::string name = fmt::format("{} in {}: ", m.desc.name, m.dissolves_in);
    // Of what runs faster than motion, its own pace counts.
    const double diffusivity = m.desc.diffusivity_in * scene_.world.solute.time_scale;
    if (!(diffusivity > 0)) return name + "solute.time_scale is 0, nothing dissolves or mixes";
    const double viscosity =
        liquid.viscosity_points.empty() ? liquid.viscosity : liquid.viscosity_points.front().value;
    const double speed = speed_of(scene_, true), dx = scene_.world.spacing, peclet = speed * dx / diffusivity;
    std::string text = name + fmt::format("Schmidt number {:.3g}", viscosity / liquid.density / diffusivity);
    if (speed > 0)
      text += fmt::format(
          ", v dx/D {:.2g} at {:.2g} m/s, the largest speed that is to be expected: layers of {:.2g} "
          "spacings",
          peclet, speed, 1 / std::sqrt(peclet));
    const bool dissolves = std::any_of(scene_.bodies.begin(), scene_.bodies.end(),
                                       [&m](const SceneBody& b) { return b.material == m.desc.name; });
    if (!dissolves) return text;
    if (m.desc.transfer_coefficient)
      return text + fmt::format(
                        "; bodies dissolve at {:.3g} m/s, by diffusion over one spacing it would be {:.2g} "
                        "(Damkoehler number k dx/D {:.3g})",
                        *m.desc.transfer_coefficient, m.desc.diffusivity_in / dx,
                        *m.desc.transfer_coefficient * dx / m.desc.diffusivity_in);
    if (peclet > 1)
      warn(fmt::format(
          "materials.{}: bodies dissolve by diffusion over one spacing, D/dx = {:.2g} m/s, as the layer at "
          "them is not resolved; give transfer_coefficient (stirred water has 1e-5 to 1e-4 m/s)",
          m.desc.name, m.desc.diffusivity_in / dx));
    return text;
  }

  void print_species() {
    std::vector<std::string> all;
    for (const SceneMaterial& m : scene_.materials)
      if (!m.dissolves_in.empty()) all.push_back(species_text(m));
    if (all.empty()) return;
    const std::size_t shown = verbose_ ? all.size() : 1;
    for (std::size_t k = 0; k < shown; ++k)
      line("species", all[all.size() - 1 - k] + (shown < all.size() && k + 1 == shown
                                                     ? fmt::format("; and {} more", all.size() - shown)
                                                     : std::string()));
    for (const Saturation& s : saturations(scene_, built_)) line("", saturation_text(s));
    if (const int sweeps = built_.world.resolved().solute_supersteps; sweeps > 1) {
      line("", fmt::format("{} sweeps over all neighbours per species and sub-step", sweeps));
      const double taken = std::ceil(sweeps * substep() / built_.world.stable_dt() - 1);
      if (const int most = scene_.world.solute.max_supersteps; taken > most)
        doubt(fmt::format(
            "species need at least {:.0f} sweeps per sub-step, more than solute.max_supersteps {}: steps "
            "will be refused; "
            "check diffusivity_in and transfer_coefficient, or lower solute.time_scale",
            taken, most));
    }
  }

  /// Whether the tension of a liquid sets the sub-step: by its own bound, or by the sound speed that was derived from it.
  bool tension_binds(const meltsim::MaterialDesc& m) const {
    using namespace meltsim::physics;
    const meltsim::Resolved r = built_.world.resolved();
    const double dx = scene_.world.spacing, same = 1 + 1e-6;
    if (r.viscosity == meltsim::Viscosity::explicit_ && r.viscous_dt <= r.stable_dt * same) return false;
    if (!(scene_.world.sound_speed > 0) &&
        r.sound_speed <= same * tension_sound_speed(m.surface_tension, m.density, dx))
      return true;
    return tension_dt(m.surface_tension, m.density, dx, lattice_laplacian_sum(r.support_radius, dx)) <=
           same * r.stable_dt;
  }

  /// What surface tension is up against, and how much of it the spacing resolves.
  void print_tension() {
    const double dx = scene_.world.spacing, g = length(scene_.world.gravity);
    for (const SceneMaterial& material : scene_.materials) {
      const meltsim::MaterialDesc& m = material.desc;
      if (!(m.surface_tension > 0)) continue;
      std::string text =
          fmt::format("{}: {:g} N/m; over one spacing Ohnesorge number {}", m.name, m.surface_tension,
                      of_viscosity(m, 1 / std::sqrt(m.density * m.surface_tension * dx)));
      if (g > 0) {
        const double reach = std::sqrt(m.surface_tension / (m.density * g));
        text += fmt::format(", Bond number {:.2g}; capillary length {:.3g} m, {:.2g} spacings",
                            dx * dx / (reach * reach), reach, reach / dx);
        if (reach < 2 * dx)
          warn(fmt::format(
              "materials.{}: the capillary length, {:.3g} m, is {:.2g} spacings: drops and menisci are "
              "not resolved; use a particles.spacing of {:.2g} or less",
              m.name, reach, reach / dx, reach / 3));
      }
      if (tension_binds(m))
        text += fmt::format("; it sets the sub-step, {:.3g} s{}", built_.world.resolved().stable_dt,
                            scene_.world.sound_speed > 0 ? "" : ", by the sound speed that drops need");
      if (const double ratio = built_.world.resolved().support_radius / dx; std::abs(ratio - 2.5) > 0.01)
        text += fmt::format("; it is measured at a support_radius of 2.5 spacings, here {:.3g}", ratio);
      line("tension", text);
    }
  }

  void print_time() {
    const SceneTime& time = scene_.time;
    const double stable = built_.world.stable_dt(), frame = 1 / time.fps;
    const double efficiency = built_.world.resolved().heat_efficiency;
    if (efficiency < 1)
      warn(fmt::format(
          "heat.model paper delivers {:.0f} % of the diffusivity asked for at a sub-step of {:.4g} s; "
          "its energy drifts (thermal_J in stats.csv). heat.model: enthalpy delivers all of it",
          100 * efficiency, stable));
    if (const std::string warning = explicit_heat_warning(scene_, built_.world, substep()); !warning.empty())
      warn(warning);
    const std::string span = fmt::format("to t={:g} s{}, {:g} frames per second; ", time.end,
                                         time.until_melted ? " or until melted" : "", time.fps);
    if (time.adaptive) {
      line("time", span + fmt::format("adaptive, stable dt {:.4g} s at rest", stable));
      return;
    }
    const double wanted = time.dt.value_or(automatic_dt(stable, frame));
    const double dt = fixed_frame_dt(0, frame, wanted),
                 substeps = std::max(1.0, std::ceil(dt / stable - 1e-9));
    line("time",
         span + fmt::format("{:.0f} steps of {:.4g} s{}, stable dt {:.4g} s at rest",
                            std::ceil(time.end / dt - 1e-6), dt,
                            substeps > 1 ? fmt::format(" in {:.0f} sub-steps each", substeps) : "", stable));
    if (std::abs(dt - wanted) > 1e-9 * wanted) {
      warn(fmt::format("dt {:g} s does not divide the frame interval {:g} s; a run uses {:.6g} s", wanted,
                       frame, dt));
    }
  }

  /// Behind --verbose: what the particles came from.
  void print_parts() {
    std::uint64_t placed = 0;
    for (std::size_t i = 0; i < scene_.fluids.size(); ++i) {
      const std::uint64_t count = built_.fluid_particles[i];
      placed += count;
      line(fmt::format("fluids[{}]", i).c_str(),
           fmt::format("{} particles of {}, {:g} C", count_text(count), scene_.fluids[i].material,
                       scene_.fluids[i].desc.temperature));
      print_left_out(scene_.fluids[i].desc, count);
    }
    for (const SceneEmitter& emitter : scene_.emitters) print_emitter(emitter);
    line("overlaps", placed > now_.fluid ? count_text(placed - now_.fluid) +
                                               " liquid particles lay inside bodies and were carved away"
                                         : "none");
  }

  void print_left_out(const meltsim::FluidDesc& fluid, std::uint64_t count) {
    const meltsim::WorldDesc& world = scene_.world;
    const meltsim::Vec3d origin = world.domain.bounded ? world.domain.min : meltsim::Vec3d{};
    std::vector<meltsim::Vec3i> points;
    if (const meltsim::Status sampled = fluid.shape.lattice_points(origin, world.spacing, points); !sampled)
      line("", "what was left out is not known: " + sampled.error().message);
    if (points.size() > count)
      line("",
           fmt::format("{} more are nearer to a wall than half a spacing or where there is liquid already",
                       count_text(points.size() - count)));
  }

  /// Particles that an emitter brings until the end of the scene; filling() has those of a reservoir.
  double emitted(const meltsim::EmitterDesc& desc) const {
    return emitted_volume(scene_, desc) / std::pow(scene_.world.spacing, 3);
  }

  /// What fills the domain up to the highest level beyond an open face, less what is there.
  double filling() const {
    const meltsim::WorldDesc& world = scene_.world;
    const meltsim::Vec3d size = world.domain.max - world.domain.min, g = world.gravity;
    const double pull = length(g);
    double most = 0;
    for (const SceneEmitter& emitter : scene_.emitters) {
      if (!emitter.desc.level || !(pull > 0)) continue;
      const double floor = std::min(-dot(world.domain.min, g), -dot(world.domain.max, g)) / pull;
      const double high = std::fabs(dot(size, g)) / pull;
      const double volume = size.x * size.y * size.z * (*emitter.desc.level - floor) / high;
      most = std::max(most, volume / std::pow(world.spacing, 3));
    }
    return std::max(0.0, most - static_cast<double>(now_.fluid + now_.solid));
  }

  void print_emitter(const SceneEmitter& emitter) {
    const meltsim::EmitterDesc& desc = emitter.desc;
    if (desc.level) {
      line("emitter", fmt::format("\"{}\": {} up to {:g} m beyond an open face, {:g} C", desc.name,
                                  emitter.material, *desc.level, desc.temperature));
      return;
    }
    line("emitter", fmt::format("\"{}\": about {} particles of {} by t={:g} s, {:g} C", desc.name,
                                count_text(static_cast<std::uint64_t>(emitted(desc))), emitter.material,
                                std::min(desc.until, scene_.time.end), desc.temperature));
  }

  /// How far and how fast a region moves.
  static std::string path_text(const std::vector<meltsim::PathPoint>& path) {
    double far = 0, fastest = 0;
    for (std::size_t k = 1; k < path.size(); ++k) {
      const double step = length(path[k].displacement - path[k - 1].displacement);
      far += step;
      fastest = std::max(fastest, step / (path[k].time - path[k - 1].time));
    }
    return fmt::format("{:.3g} m from t={:g} s to {:g} s, at most {:.3g} m/s", far, path.front().time,
                       path.back().time, fastest);
  }

  /// [W] Of heat.regions.
  void print_sources() {
    for (const RegionPower& r : region_powers(scene_, built_)) {
      const bool stays = r.region->desc.path.empty();
      if (r.particles == 0 && stays) idle_regions_.push_back(r.region->desc.name);
      line(
          "source",
          fmt::format("\"{}\": {:.4g} W in the {} particles that are in it at the start{}{}",
                      r.region->desc.name, r.power, count_text(r.particles),
                      r.region->desc.from > 0 ? fmt::format(", from t={:g} s on", r.region->desc.from)
                                              : std::string(),
                      stays ? std::string() : fmt::format("; it moves, {}", path_text(r.region->desc.path))));
    }
    const bool still = now_.fluid == 0 && scene_.emitters.empty() &&
                       std::all_of(scene_.bodies.begin(), scene_.bodies.end(), [](const SceneBody& b) {
                         return b.desc.fixed || b.desc.motion == meltsim::Motion::fixed;
                       });
    if (!still || !heat_sources_text(scene_, idle_regions_).empty()) return;  // else liquid may come
    for (const std::string& name : idle_regions_)
      warn(fmt::format(
          "heat.regions: nothing is in \"{}\", and nothing comes there: it heats nothing; move it", name));
  }

  void print_heat() {
    const bool melts = std::any_of(scene_.materials.begin(), scene_.materials.end(),
                                   [](const SceneMaterial& m) { return !m.becomes.empty(); });
    if (built_.meltable == 0 || !melts) return;
    const std::string others = heat_sources_text(scene_, idle_regions_);
    if (balance_) line("heat", heat_balance_text(*balance_, others));
    else if (!others.empty()) line("heat", "also from " + others);
  }

  /// Where a trial melted all that liquid freezes onto, nothing freezes any more.
  void see_what_melted_away(const Rehearsal& rehearsal) {
    if (rehearsal.gone.empty()) return;
    const bool cold = balance_ && balance_->end_temperature < balance_->melting_point;
    for (const std::string& warning :
         will_not_freeze(scene_, rehearsal.gone, cold, "in a trial" + rehearsal.with()))
      warn(warning);
    if (balance_) balance_->freezes_onto = false;
  }

  /// What liquid freezes onto: lattice sites of bodies alone.
  void print_freezing() {
    for (const std::string& warning : nothing_to_freeze_onto(scene_)) warn(warning);
    for (const SceneMaterial& m : scene_.materials) {
      if (!m.desc.freezes) continue;
      bool there = false, grows = false;
      for (const SceneBody& body : scene_.bodies) {
        if (body.material != m.desc.name) continue;
        there = true;
        grows = grows || body.desc.growth > 0;
      }
      if (there && !grows)
        line("freezing",
             fmt::format("of \"{}\" only where a body of \"{}\" has melted before; `growth` lets it grow",
                         m.becomes, m.desc.name));
    }
  }

  /// Share of the solid that can melt or dissolve at all: in an insulated box, what the heat in it is enough for, and what saturates the liquid;
  /// else 1.
  double most_that_melts() const {
    return most_that_goes(scene_, built_,
                          !balance_ || !heat_sources_text(scene_).empty() ? 1 : balance_->melts);
  }

  /// Whether a scene is about what freezes: nothing in it melts.
  bool only_freezes(const Rehearsal& seen) const {
    if (seen.melted_at(std::min(seen.until, scene_.time.end)) >= least_share) return false;
    return seen.frozen >= least_share || (balance_ && balance_->freezes > 0 && balance_->freezes_onto);
  }

  void print_melting(const std::optional<Rehearsal>& rehearsal) {
    if (!rehearsal) return;
    if (only_freezes(*rehearsal)) line("freezing", freezing_text(*rehearsal, built_, scene_.time.end));
    else
      line(built_.melts ? "melting" : "dissolving",
           melting_text(*rehearsal, built_, scene_.time.end, most_that_melts()));
    if (!rehearsal->stopped.empty())
      warn(fmt::format("a trial{} {}; the run is likely to end so, too", rehearsal->with(),
                       rehearsal->stopped));
  }

  /// [s] The end of a run, which may come when everything has melted.
  double run_end(const std::optional<Rehearsal>& rehearsal) const {
    if (!scene_.time.until_melted || !rehearsal || most_that_melts() < 1) return scene_.time.end;
    return std::min(scene_.time.end, rehearsal->time_of(1) + scene_.time.tail);
  }

  void print_cost(const std::optional<Rehearsal>& rehearsal) {
    const double end = run_end(rehearsal), frames = std::ceil(end * scene_.time.fps - 1e-6) + 1;
    const double start = particles();
    double more = 0;
    for (const SceneEmitter& emitter : scene_.emitters) more += emitted(emitter.desc);
    more = std::max(more, filling());
    if (start == 0) fill(end, std::min(0.5 * more, enough_particles));
    if (particles() == 0) {
      line("run", "not estimated: there are no particles at the start, and none came in a trial");
      line("disk", "likewise");
      return;
    }
    const double growth = (start + 0.5 * more) / particles();  // emitters fill up evenly, near enough
    double frame_bytes = 0, frame_s = 0;
    measure_frame(frame_bytes, frame_s);
    double per_substep = 0, substeps = 0;
    measure_steps(end, per_substep, substeps);
    if (per_substep > 0) {
      if (rehearsal) substeps = std::max(substeps, end * rehearsal->substeps_per_s);
      line("run", fmt::format("about {} here: {:.2g} sub-steps of {:.3g} ms, {:.0f} frames",
                              about(growth * (substeps * per_substep + frames * frame_s)), substeps,
                              1e3 * growth * per_substep, frames));
    }
    line("disk", fmt::format("about {} in {:.0f} frames ({}), and a page of less than 10 MB",
                             bytes_text(growth * frames * frame_bytes), frames,
                             scene_.output.formats.empty()
                                 ? "none"
                                 : fmt::format("{}", fmt::join(scene_.output.formats, ","))));
  }

  double particles() const { return static_cast<double>(now_.fluid + now_.solid); }

  /// Goes on until emitters have brought so many particles.
  void fill(double end, double wanted) {
    const double dt = timing_dt();
    const Clock::time_point start = Clock::now();
    while (particles() < wanted && built_.world.time() < end && since(start) < filling_s) {
      if (!built_.world.step(dt)) return;
      now_ = built_.world.synchronize();
      if (now_.halted) return;
    }
  }

  /// [s] The longest step that is one sub-step.
  double timing_dt() {
    const double frame = 1 / scene_.time.fps, stable = built_.world.stable_dt();
    return std::min(
        {frame, scene_.time.dt.value_or(meltsim::infinity), std::isfinite(stable) ? stable : frame});
  }

  /// A frame as a run writes it, of the particles that are there.
  void measure_frame(double& bytes, double& seconds) {
    const Scratch scratch;
    std::filesystem::create_directory(scratch.file("frames"));
    FrameExport frame(scene_, {scratch.path(), {}}, {});
    const Clock::time_point start = Clock::now();
    if (frame.any()) {
      meltsim::ReadRequest request;
      request.particles = true;
      const meltsim::ParticleFrame particles =
          expect(built_.world.take(expect(built_.world.request(request)))).particles;
      if (frame.wants_shapes()) {
        const FrameShapes shapes = frame.shapes(built_.world, 0, particles);
        frame.write(0, 0, particles, &shapes);
      } else {
        frame.write(0, 0, particles, nullptr);
      }
    }
    seconds = since(start);
    for (const auto& entry : std::filesystem::directory_iterator(scratch.file("frames")))
      bytes += static_cast<double>(entry.file_size());
  }

  /// How long a sub-step takes, and how many a run at rest takes. The World is stepped and of no use afterwards.
  void measure_steps(double end, double& per_substep, double& substeps) {
    const double dt = timing_dt();
    substeps = std::max(0.0, std::ceil(end / dt - 1e-6));
    if (!built_.world.step(dt)) {  // the sub-steps of a run may be shorter
      if (built_.world.steps() == 0) try_first_step();
      return;
    }
    built_.world.synchronize();
    const std::uint64_t before = built_.world.steps();
    const Clock::time_point start = Clock::now();
    std::uint64_t done = 0;
    while (since(start) < timing_s) {
      for (int i = 0; i < adaptive_steps_per_batch; ++i)
        if (!built_.world.step(dt)) return;
      if (built_.world.synchronize().halted) return;
      done = built_.world.steps() - before;
    }
    per_substep = since(start) / static_cast<double>(std::max<std::uint64_t>(done, 1));
  }

  void warn(const std::string& text) { warnings_.push_back(text); }
  /// Of steps that a run is likely to refuse.
  void doubt(const std::string& text) {
    doubts_.push_back(text);
    warn(text);
  }

  /// [s] The first step of a run.
  double first_dt() const {
    const double stable = built_.world.stable_dt(), frame = 1 / scene_.time.fps;
    if (scene_.time.adaptive) return std::min({stable, frame, scene_.time.dt.value_or(frame)});
    return fixed_frame_dt(0, frame, scene_.time.dt.value_or(automatic_dt(stable, frame)));
  }

  /// Fails as a run does where its first step is refused. One that is taken is work for nothing: what is certain is asked for alone.
  void try_first_step() {
    const meltsim::Status status = built_.world.step(first_dt());
    if (status) return;
    std::fflush(stdout);
    for (const std::string& warning : warnings_)
      if (std::count(doubts_.begin(), doubts_.end(), warning) == 0) fmt::print("warning: {}\n", warning);
    throw Failure(exit_code(status.error().code),
                  fmt::format("{}: a run is refused at its first step: {}", scene_.file,
                              refusal_text(scene_, status.error().message)));
  }

  const Scene& scene_;
  Built& built_;
  meltsim::StepResult now_;
  std::optional<HeatBalance> balance_;
  bool verbose_;
  std::vector<std::string> warnings_, doubts_;
  std::vector<std::string> idle_regions_;  ///< with nothing in them at the start
};

}  // namespace

int cmd_check(const SceneOptions& options, const MachineOptions& machine, bool verbose) {
  Scene scene = load_scene(options);
  scene.settle = {};  // nothing here asks how liquid starts
  Built built = build_world(scene, machine);
  for (std::string& warning : check_paths(scene, built, scene.time.end))
    scene.warnings.push_back(std::move(warning));
  built.probes =
      add_probes(built.world, built.body_ids, scene);  // they are checked, and cost what they cost in a run
  built.start_bytes = built.world.plan().bytes;
  refuse_long_dt(scene, built.world);
  Check(scene, built, verbose).print();
  return 0;
}

}  // namespace runner
