// SPDX-License-Identifier: Apache-2.0
// World::surface(): the whole call, as a host waits for it, and what of it the backend works.
#include <chrono>

#include "bench.hpp"

namespace bench {

namespace {

using meltsim::SurfaceDesc;
using meltsim::SurfaceKernel;
using meltsim::SurfaceOf;

double device_ms(meltsim::World& world) {
  for (const meltsim::StageReport& stage : world.plan().stages)
    if (stage.name == "surface.build") return stage.median_ms;
  return 0;
}

void run(benchmark::State& state, const Scene& scene, Backend backend, const SurfaceDesc& desc) {
  Running* now = running(scene, backend);
  if (now == nullptr) return state.SkipWithError("the scene halted");
  std::size_t vertices = 0, triangles = 0;
  // Once for the working space, twice until the launches are recorded.
  for (int k = 0; k < 3; ++k)
    if (!now->world.surface(desc)) return state.SkipWithError("no surface");
  static_cast<void>(now->world.scheduler().enable_timings(true));
  for (auto _ : state) {
    now->world.synchronize();
    const auto start = std::chrono::steady_clock::now();
    const auto mesh = now->world.surface(desc);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (!mesh) return state.SkipWithError(mesh.error().message.c_str());
    vertices = mesh->position.size();
    triangles = mesh->triangles.size() / 3;
    state.SetIterationTime(elapsed.count());
  }
  now->world.synchronize();
  state.counters["device_ms"] = device_ms(now->world);
  static_cast<void>(now->world.scheduler().enable_timings(false));
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["triangles"] = static_cast<double>(triangles);
  state.counters["particles/s"] =
      benchmark::Counter(static_cast<double>(now->particles) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate);
}

}  // namespace

void register_surfaces() {
  for (const Backend backend : backends())
    for (const Scene& scene : scenes(backend)) {
      if (!scene.solid || !scene.plain() || scene.large() || scene.block.all() < 60000) continue;
      for (const auto of : {SurfaceOf::liquid, SurfaceOf::solids})
        for (const auto kernel : {SurfaceKernel::isotropic, SurfaceKernel::anisotropic}) {
          SurfaceDesc desc;
          desc.of = of;
          desc.kernel = kernel;
          const std::string name = std::string("surface/") + (of == SurfaceOf::liquid ? "liquid" : "solids") +
                                   (kernel == SurfaceKernel::isotropic ? "_isotropic/" : "_anisotropic/") +
                                   name_of(backend) + "/" + std::to_string(scene.block.all());
          benchmark::RegisterBenchmark(
              name.c_str(),
              [scene, backend, desc](benchmark::State& state) { run(state, scene, backend, desc); })
              // device_ms is the median of the last 256: in the second repetition most of them are its own.
              ->Iterations(backend == Backend::cpu ? 3 : 100)
              ->UseManualTime()
              ->Unit(benchmark::kMillisecond);
        }
    }
}

}  // namespace bench
