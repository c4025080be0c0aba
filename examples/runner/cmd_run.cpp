// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "check_paths.hpp"
#include "commands.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "halt.hpp"
#include "load_scene.hpp"
#include "numbers.hpp"
#include "resolution.hpp"
#include "run.hpp"
#include "trade_watch.hpp"

namespace runner {

Scene load_scene(const SceneOptions& options) {
  Scene scene = load_scene(options.scene, options.set);
  apply_resolution(scene, options.scale, options.quality);
  return scene;
}

namespace {

void apply_run_options(Scene& scene, const RunOptions& options) {
  if (options.time) scene.time.end = *options.time;
  if (options.fps) scene.time.fps = *options.fps;
  if (options.frames) scene.time.end = static_cast<double>(*options.frames) / scene.time.fps;
  if (options.formats) scene.output.formats = *options.formats;
}

std::string particles_text(Built& built, const Scene& scene) {
  const meltsim::StepResult now = built.world.synchronize();
  return fmt::format("{}: {} liquid and {} solid particles, spacing {:.4g} m, memory {}", scene.name,
                     count_text(now.fluid), count_text(now.solid), scene.world.spacing, memory_text(built));
}

/// How far liquid went, and if that is farther than it should where something holds it.
void tell_settled(Built& built, Log& log) {
  const meltsim::Settled& s = built.settled;
  const double spacings = s.farthest / built.world.desc().spacing;
  log.info(fmt::format("at rest: {:.3g} s in {} sub-steps, liquid moved by at most {:.2g} spacings",
                       s.seconds, s.substeps, spacings));
  if (spacings > 1)
    log.warn(
        fmt::format("solver.settle: liquid flowed up to {:.2g} spacings while it came to rest: nothing "
                    "holds it there; put a body in its way, or leave settle out",
                    spacings));
}

/// A directory that is there already, locked before the long work of building the scene.
std::optional<RunDirectory> existing_directory(const RunOptions& options) {
  if (options.resume) return resumed_run_directory(options.out);
  if (options.overwrite && exists(options.out)) return named_run_directory(options.out);
  if (!options.out.empty()) refuse_existing(options.out);
  return std::nullopt;
}

RunDirectory new_directory(const Scene& scene, const RunOptions& options) {
  return options.out.empty() ? new_run_directory(scene.name) : named_run_directory(options.out);
}

/// Settings chosen for an error, and what they were chosen from.
struct Chosen {
  std::shared_ptr<Tuning> tuning;
  meltsim::trade::Study study;
  meltsim::trade::Choice choice;
  TradeRequest request;
};

Chosen choose(const Scene& scene, const RunOptions& options, Log& log) {
  Chosen chosen;
  std::vector<std::string> names;
  if (!options.of.empty()) names.push_back(options.of);
  chosen.tuning = std::make_shared<Tuning>(scene, options.machine, names, "--of");
  TradeRequest& request = chosen.request;
  request.of = chosen.tuning->observables().front().desc.name;
  request.by_option = options.max_error.has_value();
  request.max_error = request.by_option ? *options.max_error : *scene.trade.max_error;
  request.asked_by = request.by_option ? fmt::format("--max-error {:g}%", 100 * request.max_error)
                                       : scene.trade.max_error_where + ": trade.max_error";
  TuneOptions tune;
  tune.seconds = options.time_limit;
  tune.cache = options.cache;
  log.info(fmt::format("choosing settings for {} within {:g} %: probes of at most {:g} s", request.of,
                       100 * request.max_error, tune.seconds));
  chosen.study = chosen.tuning->study(tune);
  for (const std::string& note : chosen.study.notes) log.warn(note);
  if (chosen.study.cut_short)
    log.warn("probes took longer than --time-limit and were cut short; another time they may differ");
  chosen.choice = choose_settings(*chosen.tuning, chosen.study, request);
  const meltsim::trade::Known& known = chosen.tuning->known();
  log.info(fmt::format("{} probes in {:.1f} s{}", chosen.study.probes.size(), chosen.study.wall_s,
                       chosen.tuning->from_cache() ? " (from the cache)" : ""));
  log.info("chosen: " + chosen.tuning->settings_text(chosen.choice.knobs));
  log.info(fmt::format("expected: error of {} {}, {} of computing", request.of,
                       error_text(known, chosen.choice.error), about_text(chosen.choice.seconds)));
  return chosen;
}

/// A part of run.json in a directory that says which settings were chosen for that run; null: there is none.
Json part_of_run(const std::string& directory, const char* part) {
  const std::string file = directory + "/run.json";
  if (!exists(file)) return {};
  const Json json = Json::parse(read_file(file), nullptr, false);
  if (!json.is_object() || !json.contains(part) || !json[part].is_object()) return {};
  return json[part].contains("settings") ? json[part] : Json();
}

/// Settings that were chosen for the run in a directory; null: none were.
Json settings_of_run(const std::string& directory) {
  for (const char* part : {"trade", "budget"})
    if (const Json chosen = part_of_run(directory, part); chosen.is_object()) return chosen["settings"];
  return {};
}

/// A run whose settings were chosen goes on with them.
void take_settings(Scene& scene, const Json& settings, Log& log) {
  if (!settings.is_object()) return;
  const auto number = [&](const char* key) { return settings.value(key, 0.0); };
  if (!(number("spacing") > 0)) return;
  // As Tuning::with sets them, to the last digit: a snapshot is of one spacing.
  if (number("spacing") != scene.world.spacing) apply_chosen_spacing(scene, number("spacing"));
  scene.sound_factor = 1;
  if (number("sound_speed") > 0) {
    scene.world.sound_speed = number("sound_speed");
    scene.world.density_error = 0;
  }
  if (number("density_error") > 0) scene.world.density_error = number("density_error");
  if (number("courant") > 0) scene.world.courant = number("courant");
  scene.world.artificial_viscosity = settings.value("artificial_viscosity", scene.world.artificial_viscosity);
  scene.time.adaptive = true;
  scene.time.dt = number("dt") > 0 ? std::optional<double>(number("dt")) : std::nullopt;
  log.info("settings as they were chosen for this run");
}

/// A run that is resumed begins with the state of its checkpoint.
Built build(const Scene& scene, const RunOptions& options, Log& log) {
  if (!scene.settle.on) return build_world(scene, options.machine);
  if (options.resume) {
    Scene as_laid_out = scene;
    as_laid_out.settle = {};
    return build_world(as_laid_out, options.machine);
  }
  log.info("liquid comes to rest, with bodies held");
  Built built = build_world(scene, options.machine);
  tell_settled(built, log);
  return built;
}

int run_scene(const RunOptions& options, Log& log) {
  const std::optional<RunDirectory> existing = existing_directory(options);
  Scene scene = load_scene(options.scene);
  apply_run_options(scene, options);
  if (options.machine.threads_asked > static_cast<std::uint64_t>(options.machine.threads)) {
    log.warn(fmt::format("--threads {}: this machine has {} processors for it; using {}",
                         options.machine.threads_asked, options.machine.threads, options.machine.threads));
  }
  std::optional<Chosen> chosen;
  if (options.max_error || (scene.trade.max_error && !options.resume)) {
    if (options.resume)
      throw Failure(ExitCode::usage, "--max-error: a run that is resumed keeps its settings; leave it out");
    chosen = choose(scene, options, log);
    scene = chosen->tuning->with(chosen->choice.knobs);
  }
  std::optional<FrameBudget> budget;
  if (!options.repeat.empty()) {
    budget = FrameBudget::repeating(options.repeat);
    take_settings(scene, budget->settings(), log);
    budget->set_times(scene.time, options);
  } else if (options.budget_ms) {
    budget.emplace(*options.budget_ms);
    if (!options.resume) budget->choose(scene, options, log);
    else budget->set_settings(settings_of_run(options.out));
  }
  if (options.resume) take_settings(scene, settings_of_run(options.out), log);
  Built built = build(scene, options, log);
  if (!budget) refuse_long_dt(scene, built.world);
  if (!options.steps && !options.resume)
    for (std::string& warning : check_paths(scene, built, scene.time.end))
      scene.warnings.push_back(std::move(warning));
  for (const std::string& warning : scene.warnings) log.warn(warning);
  log.info("backend: " + backend_text(built.world));
  built.probes = add_probes(built.world, built.body_ids, scene);
  built.start_bytes = built.world.plan().bytes;
  log.info(particles_text(built, scene));
  const meltsim::StepResult start = built.world.synchronize();
  if (start.fluid + start.solid == 0 && scene.emitters.empty()) log.warn("the scene holds no particles");
  const RunDirectory directory = existing ? *existing : new_directory(scene, options);
  directory.make_frames();
  log.info("writing to " + directory.path);
  if (!scene.text.empty()) write_file(directory.file(stdin_scene), scene.text);
  std::optional<TradeWatch> watch;
  if (chosen) watch.emplace(chosen->tuning, chosen->study, chosen->choice, chosen->request, built);
  Run run(scene, options, built, directory, log, watch ? &*watch : nullptr, budget ? &*budget : nullptr);
  if (options.resume) run.keep_trade(part_of_run(directory.path, "trade"));
  return run.execute();
}

}  // namespace

int cmd_run(const RunOptions& options) {
  Log log(options.log, options.quiet);
  try {
    return run_scene(options, log);
  } catch (const Failure& failure) {
    log.error(failure.what());
    return static_cast<int>(failure.code());
  }
}

}  // namespace runner
