// SPDX-License-Identifier: Apache-2.0
// The steps of a scene in one go: no frame, no reading, no file. What whole_run.py holds a run of the program against.
//
//   meltsim_bare_run SCENE SCALE BACKEND THREADS DT STEPS
//
// Prints one line of JSON: sub-steps, their time [ms] and the particles.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "build_world.hpp"
#include "commands.hpp"
#include "failure.hpp"

namespace {

using Clock = std::chrono::steady_clock;

// The first sub-steps allocate, and record graphs.
constexpr int warm_up = 10;

int bare_run(char** argv) {
  runner::SceneOptions options;
  options.scene = argv[1];
  options.scale = std::atof(argv[2]);
  runner::MachineOptions machine;
  machine.backend = std::string(argv[3]) == "cuda" ? meltsim::Backend::cuda : meltsim::Backend::cpu;
  machine.threads = std::atoi(argv[4]);
  const double dt = std::atof(argv[5]);
  const int steps = std::atoi(argv[6]);
  runner::Built built = runner::build_world(runner::load_scene(options), machine);
  meltsim::World& world = built.world;
  Clock::time_point start;
  std::uint64_t before = 0;
  for (int i = 0; i < warm_up + steps; ++i) {
    if (i == warm_up) {
      world.synchronize();
      before = world.steps();
      start = Clock::now();
    }
    if (const meltsim::Status status = world.step(dt); !status)
      throw runner::Failure(runner::ExitCode::diverged, status.error().message);
  }
  const meltsim::StepResult end = world.synchronize();
  const double ms = 1e3 * std::chrono::duration<double>(Clock::now() - start).count();
  if (end.halted) throw runner::Failure(runner::ExitCode::diverged, end.halt_reason);
  const auto substeps = static_cast<double>(world.steps() - before);
  std::printf("{\"substeps\": %.0f, \"substep_ms\": %.6g, \"particles\": %.0f}\n", substeps, ms / substeps,
              static_cast<double>(end.fluid + end.solid));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "usage: meltsim_bare_run SCENE SCALE BACKEND THREADS DT STEPS\n");
    return 2;
  }
  try {
    return bare_run(argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "meltsim_bare_run: %s\n", error.what());
    return 1;
  }
}
