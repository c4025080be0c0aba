// SPDX-License-Identifier: Apache-2.0
#include "rehearsal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "expect.hpp"
#include "failure.hpp"
#include "freezing.hpp"
#include "halt.hpp"
#include "observables.hpp"
#include "recorder.hpp"
#include "resolution.hpp"
#include "stepper.hpp"

namespace runner {

namespace {

using Clock = std::chrono::steady_clock;

// Sub-steps times particles of one rehearsal, a second or two of one thread; and when it is broken off all the same.
constexpr double work_limit = 1e6, seconds_limit = 5;
// A body of fewer particles, three along each edge of a cube, melts as no body of the scene does.
constexpr double least_particles = 27;
// A trial that was broken off with less than this share melted says nothing of how the melting goes on.
constexpr double telling = 0.05;

double count(const meltsim::StepResult& now) { return static_cast<double>(now.fluid + now.solid); }

/// Particles of the smallest body that can melt.
double smallest_body(Built& built) {
  double least = meltsim::infinity;
  const auto pieces = built.world.pieces();
  if (!pieces) return 0;
  for (const meltsim::PieceInfo& piece : *pieces)
    if (built.body_melts.at(piece.body.index)) least = std::min(least, static_cast<double>(piece.particles));
  return least;
}

/// Periodic axes and walls may be so many support radii long at least, and a spacing that fits the domain is up to so much larger than the one
/// that was asked for.
double coarseness_of_domain(const Scene& scene, Built& built) {
  constexpr double periodic = 3, walls = 2, fitting = 1.13;
  const meltsim::DomainDesc& domain = scene.world.domain;
  if (!domain.bounded) return meltsim::infinity;
  const meltsim::Vec3d size = domain.max - domain.min;
  const double extents[] = {size.x, size.y, size.z}, support = built.world.resolved().support_radius;
  double most = meltsim::infinity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const meltsim::Face low = domain.faces[2 * axis], high = domain.faces[2 * axis + 1];
    if (low == meltsim::Face::open || high == meltsim::Face::open) continue;
    const double radii = low == meltsim::Face::periodic ? periodic : walls;
    most = std::min(most, extents[axis] / (radii * support * fitting));
  }
  return most;
}

/// How much coarser: as far as the work asks for and the domain, bodies and nozzles allow.
double coarseness(const Scene& scene, Built& built) {
  const double substeps = scene.time.end / built.world.stable_dt();
  const double work = count(built.world.synchronize()) * substeps;
  double most =
      std::min(std::cbrt(smallest_body(built) / least_particles), coarseness_of_domain(scene, built));
  for (const SceneEmitter& emitter : scene.emitters)
    most = std::min(most, least_radius(emitter.desc) / scene.world.spacing);
  const double wanted =
      std::pow(work / work_limit, 0.25);  // particles as its third power, sub-steps as its first
  const double factor = std::min(wanted, most);
  return factor < 1.05 ? 1 : factor;
}

Scene coarser(const Scene& scene, double factor) {
  Scene coarse = scene;
  apply_resolution(coarse, 1 / factor, Quality::balanced);
  coarse.time.end = scene.time.end;
  for (SceneEmitter& emitter : coarse.emitters)
    emitter.desc.max_particles = static_cast<std::uint64_t>(
        std::ceil(static_cast<double>(emitter.desc.max_particles) / std::pow(factor, 3)));
  return coarse;
}

/// [s] The step of a run that has one for all of it, nothing where steps follow the speeds.
std::optional<double> fixed_step(const Scene& scene, Built& built) {
  if (scene.time.adaptive) return std::nullopt;
  const double frame = 1 / scene.time.fps;
  return fixed_frame_dt(0, frame, scene.time.dt.value_or(automatic_dt(built.world.stable_dt(), frame)));
}

}  // namespace

double Rehearsal::melted_at(double time) const {
  if (melting.empty()) return 0;
  const auto after = std::lower_bound(melting.begin(), melting.end(), time,
                                      [](const Sample& sample, double t) { return sample.time < t; });
  if (after != melting.end()) {
    if (after == melting.begin()) return after->melted;
    const auto before = after - 1;
    return before->melted +
           (after->melted - before->melted) * (time - before->time) / (after->time - before->time);
  }
  // By latent heat, as particles melt in whole layers: two that have melted at once say nothing of how it goes on.
  const double last = melting.back().taken, half = taken_at(until / 2);
  if (!(last > 0)) return 0;
  // Between the square root of time, as heat soaks in, and its square, as a flow sets in.
  const double power = half > 0 ? std::clamp(std::log2(last / half), 0.5, 2.0) : 1;
  return std::min(1.0, last * std::pow(time / until, power));
}

double Rehearsal::taken_at(double time) const {
  const auto after = std::lower_bound(melting.begin(), melting.end(), time,
                                      [](const Sample& sample, double t) { return sample.time < t; });
  return after == melting.end() ? 0 : after->taken;
}

double Rehearsal::most_taken() const {
  double most = 0;
  for (const Sample& sample : melting) most = std::max(most, sample.taken);
  return most;
}

double Rehearsal::time_of(double share) const {
  for (const Sample& sample : melting)
    if (sample.melted >= share) return sample.time;
  if (melting.empty() || !(melting.back().taken > 0)) return meltsim::infinity;
  double low = until, high = until;
  for (int i = 0; i < 60 && melted_at(high) < share; ++i) high *= 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (melted_at(middle) < share ? low : high) = middle;
  }
  return high;
}

std::string Rehearsal::with() const {
  return coarseness > 1 ? fmt::format(" with particles {:.2g} times as large", coarseness) : "";
}

namespace {

/// The share that goes until `end`, and when all of it will have.
std::string share_text(const Rehearsal& seen, const Built& built, double end, double most, bool broken_off) {
  const double share = seen.melted_at(end), all = seen.time_of(1);
  const char* verb = !built.melts ? "dissolves" : built.dissolves ? "melts or dissolves" : "melts";
  std::string text;
  if (share >= 1) text = fmt::format("everything {} by about t={:.2g} s", verb, all);
  else if (share < least_share && !broken_off && seen.melting.back().taken >= telling)
    text = fmt::format(
        "next to nothing is molten through by t={:g} s, by when {:.2g} % of the heat for it is taken up", end,
        100 * seen.melting.back().taken);
  else if (share < least_share) text = fmt::format("next to nothing {} by t={:g} s", verb, end);
  else text = fmt::format("about {:.2g} % of the solid by t={:g} s", 100 * share, end);
  if (share >= telling && share < 1 && std::isfinite(all) && most >= 1 && !seen.changes)
    text += fmt::format(", all of it by about t={:.2g} s{}", all, broken_off ? "" : " (extrapolated)");
  if (share < most - least_share) text += fmt::format("; {} makes it faster", pace_keys(built));
  return text;
}

}  // namespace

std::string melting_text(const Rehearsal& seen, const Built& built, double end, double most) {
  if (!seen.untried.empty()) return "not estimated: " + seen.untried;
  const double until = seen.until, melted = seen.melted_at(until);
  if (!seen.stopped.empty())
    return fmt::format("not estimated: a trial{} came to t={:.3g} s only", seen.with(), until);
  const bool broken_off = until < end * (1 - 1e-6) && melted < 1;
  if (!broken_off) return fmt::format("{} (tried{})", share_text(seen, built, end, most, false), seen.with());
  const std::string how = fmt::format("tried{} to t={:.2g} s", seen.with(), until);
  const double taken = seen.melting.back().taken, most_taken = seen.most_taken();
  if (taken < most_taken - least_share)  // it freezes again
    return fmt::format(
        "{:.2g} % of the solid by t={:.2g} s, after {:.2g} % ({}); beyond that it was not tried", 100 * taken,
        until, 100 * most_taken, how);
  if (taken < telling || seen.changes)
    return fmt::format("{:.2g} % of the solid by t={:.2g} s ({}); beyond that it was not tried{}",
                       100 * taken, until, how, seen.changes ? ", as what heats it changes in time" : "");
  return fmt::format("{} (extrapolated: {}, when {:.2g} % had {})", share_text(seen, built, end, most, true),
                     how, 100 * taken,
                     !built.melts      ? "dissolved"
                     : built.dissolves ? "melted or dissolved"
                                       : "melted");
}

std::string freezing_text(const Rehearsal& seen, const Built& built, double end) {
  if (!seen.untried.empty()) return "not estimated: " + seen.untried;
  if (!seen.stopped.empty())
    return fmt::format("not estimated: a trial{} came to t={:.3g} s only", seen.with(), seen.until);
  const bool whole = seen.until >= end * (1 - 1e-6), little = seen.frozen < least_share;
  const std::string until = fmt::format("t={:.2g} s", whole ? end : seen.until);
  return fmt::format("{} by {}{} (tried{}){}",
                     little ? "next to nothing freezes"
                     : seen.frozen >= 1
                         ? "everything that can has frozen"
                         : fmt::format("about {:.2g} % of what can freeze is frozen", 100 * seen.frozen),
                     until, little ? fmt::format("; {} makes it faster", pace_keys(built)) : "", seen.with(),
                     whole || seen.frozen >= 1 ? "" : "; beyond that it was not tried");
}

namespace {

/// What is frozen of what can, since a start at which so many particles had melted and frozen.
double frozen_share(const Scene& scene, Built& built, const meltsim::StepResult& now) {
  if (now.frozen <= now.melted) return 0;
  std::vector<std::string> liquids;
  for (const SceneMaterial& m : scene.materials)
    if (m.desc.freezes) liquids.push_back(m.becomes);
  const meltsim::ParticleData all = expect(built.world.particles());
  std::size_t liquid = 0;
  for (const meltsim::ParticleTag tag : all.tag)
    if (meltsim::is_fluid(tag) && std::find(liquids.begin(), liquids.end(),
                                            built.materials.at(meltsim::material_of(tag))) != liquids.end())
      ++liquid;
  const double frozen = static_cast<double>(now.frozen - now.melted);
  return frozen / (frozen + static_cast<double>(liquid));
}

}  // namespace

namespace {
/// Whether what heats it, or where, does.
bool changes_in_time(const Scene& scene) {
  const auto timed = [](const meltsim::SurfaceHeatDesc& s) {
    return !s.temperature_points.empty() || !s.flux_points.empty();
  };
  const auto& walls = scene.world.domain.heat;
  return timed(scene.world.heat.free_surface) || std::any_of(walls.begin(), walls.end(), timed) ||
         std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [&](const SceneBody& b) { return timed(b.desc.surface); }) ||
         std::any_of(scene.heat_regions.begin(), scene.heat_regions.end(),
                     [](const SceneHeatRegion& r) { return !r.desc.path.empty(); });
}
}  // namespace

Rehearsal rehearse(const Scene& scene, Built& built) {
  Rehearsal seen;
  seen.changes = changes_in_time(scene);
  if (!(scene.time.end > 0)) {
    seen.untried = "time.end is 0";
    return seen;
  }
  seen.coarseness = coarseness(scene, built);
  MachineOptions machine;
  machine.backend = meltsim::Backend::cpu;
  machine.threads = 1;
  try {
    const Scene coarser_scene = coarser(scene, seen.coarseness);
    Built coarse = build_world(coarser_scene, machine);
    seen.coarseness = coarser_scene.world.spacing / scene.world.spacing;
    const Clock::time_point start = Clock::now();
    const double meltable = static_cast<double>(coarse.meltable), longest = scene.time.end / 200;
    // Not coarser and in the same steps it is the run itself: what melts in bursts, as layers of particles do, melts then.
    const std::optional<double> same = seen.coarseness > 1 ? std::nullopt : fixed_step(coarser_scene, coarse);
    double substeps = 0, speed = 0;
    seen.melting.push_back({0, 0, 0});
    SceneStart bodies;
    describe_bodies(coarser_scene, coarse, bodies);
    const double cold = expect(coarse.world.ledger()).latent;
    while (seen.until < scene.time.end * (1 - 1e-9) && seen.melting.back().melted < 1) {
      const double stable = coarse.world.stable_dt(scene.time.adaptive ? speed : 0);
      const double wanted = same ? *same : std::min(stable, longest);
      const double dt = std::min(wanted, scene.time.end - seen.until);
      if (const meltsim::Status status = coarse.world.step(dt); !status) {
        seen.stopped = fmt::format("was refused at t={:.3g} s: {}", seen.until,
                                   refusal_text(scene, status.error().message));
        break;
      }
      const meltsim::StepResult now = coarse.world.synchronize();
      if (now.halted) {
        seen.stopped = fmt::format("diverged at t={:.3g} s: {}; {}", seen.until, halt_text(now.halt_reason),
                                   halt_advice(scene, coarse.world, now, dt, seen.coarseness));
        break;
      }
      speed = now.max_speed;
      seen.until += dt;
      substeps = static_cast<double>(now.steps);
      const double melted = std::min(1.0, static_cast<double>(net_melted(now.melted, now.frozen)) / meltable);
      const double taken =
          bodies.latent > 0 && !coarse.dissolves
              ? std::clamp((expect(coarse.world.ledger()).latent - cold) / bodies.latent, 0.0, 1.0)
              : melted;
      seen.melting.push_back({seen.until, melted, taken});
      if (std::chrono::duration<double>(Clock::now() - start).count() > seconds_limit) break;
    }
    if (seen.stopped.empty()) {
      seen.gone = melted_away(coarser_scene, coarse);
      seen.frozen = frozen_share(coarser_scene, coarse, coarse.world.synchronize());
    }
    if (seen.until > 0) seen.substeps_per_s = substeps / seen.until * seen.coarseness;
  } catch (const Failure& failure) {  // a body too small for the coarser lattice, say
    seen.untried = fmt::format("with coarser particles the scene cannot be built: {}", failure.what());
  }
  return seen;
}

}  // namespace runner
