// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "commands.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "load_scene.hpp"
#include "numbers.hpp"
#include "resolution.hpp"
#include "run.hpp"

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
  return fmt::format("{}: {} liquid and {} solid particles, spacing {:.4g} m, {} of memory", scene.name,
                     count_text(now.fluid), count_text(now.solid), scene.world.spacing,
                     bytes_text(static_cast<double>(built.world.plan().bytes)));
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

/// The library refuses a step that needs too many sub-steps; said before anything is written.
void check_dt(const Scene& scene, const Built& built) {
  if (scene.time.adaptive || !scene.time.dt) return;
  const double dt = fixed_frame_dt(0, 1 / scene.time.fps, *scene.time.dt), stable = built.world.stable_dt();
  const double substeps = std::ceil(dt / stable - 1e-9);
  if (substeps <= scene.world.max_substeps) return;
  throw Failure(ExitCode::scene,
                fmt::format("{}: time.dt: {:g} s needs {:.0f} sub-steps of at most {:.3g} s, more than "
                            "solver.max_substeps {}; use dt {:.2g}, or stepping: adaptive",
                            scene.time.dt_where, *scene.time.dt, substeps, stable, scene.world.max_substeps,
                            std::min(1 / scene.time.fps, 0.99 * stable * scene.world.max_substeps)));
}

int run_scene(const RunOptions& options, Log& log) {
  const std::optional<RunDirectory> existing = existing_directory(options);
  Scene scene = load_scene(options.scene);
  apply_run_options(scene, options);
  if (options.machine.threads_asked > static_cast<std::uint64_t>(options.machine.threads)) {
    log.warn(fmt::format("--threads {}: this machine has {} processors for it; using {}",
                         options.machine.threads_asked, options.machine.threads, options.machine.threads));
  }
  Built built = build_world(scene, options.machine);
  check_dt(scene, built);
  for (const std::string& warning : scene.warnings) log.warn(warning);
  log.info("backend: " + backend_text(built.world));
  log.info(particles_text(built, scene));
  const meltsim::StepResult start = built.world.synchronize();
  if (start.fluid + start.solid == 0 && scene.emitters.empty()) log.warn("the scene holds no particles");
  built.probes = add_probes(built.world, scene);
  const RunDirectory directory = existing ? *existing : new_directory(scene, options);
  log.info("writing to " + directory.path);
  if (!scene.text.empty()) write_file(directory.file(stdin_scene), scene.text);
  return Run(scene, options, built, directory, log).execute();
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
