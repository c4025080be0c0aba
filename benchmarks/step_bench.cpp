// SPDX-License-Identifier: Apache-2.0
// Whole steps: what a host waits for.
#include <chrono>
#include <cstdlib>

#include "bench.hpp"

namespace bench {

namespace {

void run(benchmark::State& state, const Scene& scene, Backend backend, int steps) {
  Running* now = running(scene, backend);
  if (now == nullptr) return state.SkipWithError("the scene halted");
  const std::uint64_t melted_before = now->world.synchronize().melted;
  const std::uint64_t substeps_before = now->world.steps();
  std::uint64_t total = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < steps; ++k)
      if (!now->world.step(now->dt)) return state.SkipWithError("a step was refused");
    if (!scene.probes.empty() && !now->world.take_samples())
      return state.SkipWithError("samples were refused");
    const meltsim::StepResult r = now->world.synchronize();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (r.halted) return state.SkipWithError(r.halt_reason.c_str());
    state.SetIterationTime(elapsed.count() / steps);
    total += static_cast<std::uint64_t>(steps);
  }
  const meltsim::StepResult r = now->world.synchronize();
  const meltsim::Resolved resolved = now->world.resolved();
  const auto per_step = [total](std::uint64_t n) {
    return total == 0 ? 0.0 : static_cast<double>(n) / static_cast<double>(total);
  };
  state.counters["particles/s"] =
      benchmark::Counter(static_cast<double>(now->particles) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate);
  state.counters["melted_per_step"] = per_step(r.melted - melted_before);
  state.counters["substeps"] = per_step(now->world.steps() - substeps_before);
  state.counters["solid"] = static_cast<double>(r.solid);
  state.counters["heat_stages"] = resolved.heat_stages;
  state.counters["bytes_per_particle"] =
      static_cast<double>(now->world.plan().bytes) / static_cast<double>(now->particles);
}

/// iterations: fixed, because the ice must last for all repetitions. The search for pieces runs every 16
/// sub-steps; on the CPU it is a small part.
void add(const std::string& name, const Scene& scene, Backend backend, int iterations, int steps) {
  benchmark::RegisterBenchmark(
      name.c_str(), [scene, backend, steps](benchmark::State& state) { run(state, scene, backend, steps); })
      ->Iterations(iterations)
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_step(const Scene& scene, Backend backend) {
  const std::string name = "scene/" + scene.title(backend);
  if (backend == Backend::cpu) add(name, scene, backend, 2, 4);
  else add(name, scene, backend, scene.large() ? 1 : 8, 16);
}

void register_own_stages() {
  for (const Backend backend : backends())
    for (const Scene& scene : own_stage_scenes(backend)) register_step(scene, backend);
}

void register_paper() {
  for (const Backend backend : backends())
    for (const Scene& scene : paper_scenes(backend)) {
      const std::string name = "paper/" + scene.title(backend);
      if (backend == Backend::cpu) add(name, scene, backend, 1, 2);
      else add(name, scene, backend, 2, 8);
    }
}

void register_probes() {
  for (const Backend backend : backends())
    for (const Scene& scene : probe_scenes(backend)) register_step(scene, backend);
}

void register_threads() {
  const int most = meltsim::build_info().cpu_threads;
  for (const Scene& scene : scenes(Backend::cpu)) {
    if (scene.block.all() != 60500) continue;
    for (int threads = 1; threads <= 16 && threads <= most; threads *= 2) {
      Scene own = scene;
      own.threads = threads;
      add("threads/" + scene.title(Backend::cpu) + "/" + std::to_string(threads), own, Backend::cpu, 1, 4);
    }
  }
}

void register_profile() {
  if (std::getenv("MELTSIM_BENCHMARK_PROFILE") == nullptr || backends().back() != Backend::cuda) return;
  for (const Scene& scene : scenes(Backend::cuda)) {
    const std::string name = "profile/" + scene.title(Backend::cuda);
    benchmark::RegisterBenchmark(name.c_str(), [scene](benchmark::State& state) {
      Running* now = running(scene, Backend::cuda);
      if (now == nullptr) return state.SkipWithError("the scene halted");
      // Up to the step before the next search for pieces, so that no stage is missing.
      while (now->world.steps() % 16 != 15)
        if (!now->world.step(now->dt)) return state.SkipWithError("a step was refused");
      now->world.synchronize();
      for (auto _ : state) {
        profile(true);
        const bool stepped = static_cast<bool>(now->world.step(now->dt));
        now->world.synchronize();
        profile(false);
        if (!stepped) return state.SkipWithError("a step was refused");
      }
    })->Iterations(1);
  }
}

}  // namespace bench
