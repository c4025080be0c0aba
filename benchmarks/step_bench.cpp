// SPDX-License-Identifier: Apache-2.0
// Whole steps: what a host waits for.
#include <chrono>

#include "bench.hpp"

namespace bench {

namespace {

void run(benchmark::State& state, const Scene& scene, Backend backend) {
  Running* now = running(scene, backend);
  if (now == nullptr) return state.SkipWithError("the scene halted");
  // The search for pieces runs every 16 steps; on the CPU it is a small part.
  const int steps = backend == Backend::cuda ? 16 : 4;
  const std::uint64_t melted_before = now->world.synchronize().melted;
  std::uint64_t total = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < steps; ++k)
      if (!now->world.step(now->dt)) return state.SkipWithError("a step was refused");
    const meltsim::StepResult r = now->world.synchronize();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (r.halted) return state.SkipWithError(r.halt_reason.c_str());
    state.SetIterationTime(elapsed.count() / steps);
    total += static_cast<std::uint64_t>(steps);
  }
  const meltsim::StepResult r = now->world.synchronize();
  const meltsim::Resolved resolved = now->world.resolved();
  state.counters["particles/s"] =
      benchmark::Counter(static_cast<double>(now->particles) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate);
  state.counters["melted_per_step"] =
      total == 0 ? 0.0 : static_cast<double>(r.melted - melted_before) / static_cast<double>(total);
  state.counters["solid"] = static_cast<double>(r.solid);
  state.counters["heat_stages"] = resolved.heat_stages;
  state.counters["bytes_per_particle"] =
      static_cast<double>(now->world.plan().bytes) / static_cast<double>(now->particles);
}

}  // namespace

void register_steps() {
  for (const Backend backend : backends())
    for (const Scene& scene : scenes(backend)) {
      const std::string name = "scene/" + scene.name + "/" + name_of(backend) + "/" +
                               std::to_string(std::int64_t{scene.nx} * scene.ny * scene.nz);
      benchmark::RegisterBenchmark(name.c_str(),
                                   [scene, backend](benchmark::State& state) { run(state, scene, backend); })
          ->Iterations(backend == Backend::cuda ? 8 : 2)  // fixed: the ice must last for all repetitions
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
}

}  // namespace bench
