// SPDX-License-Identifier: Apache-2.0
// Stages, one benchmark each, from the timings of running Worlds. All stages of one World are measured by the
// same steps; asking for one of them runs them all.
#include <algorithm>
#include <map>
#include <set>

#include "bench.hpp"
#include "core/pipeline.hpp"

namespace bench {

namespace {

using meltsim::core::field_count;
using meltsim::core::field_table;
using meltsim::core::StageInfo;

/// Bytes of the channels a stage reads and writes, each counted once for each.
double bytes_of(const StageInfo& stage, const meltsim::Plan& plan) {
  double total = 0;
  for (int f = 0; f < field_count; ++f) {
    const auto channel =
        std::find_if(plan.channels.begin(), plan.channels.end(),
                     [f](const meltsim::ChannelReport& c) { return c.name == field_table[f].name; });
    if (channel == plan.channels.end()) continue;
    const bool doubled = field_table[f].owner == meltsim::core::Owner::particle &&
                         field_table[f].lifetime == meltsim::core::Lifetime::State;
    const double bytes = static_cast<double>(channel->bytes) / (doubled ? 2 : 1);
    total += (static_cast<double>((stage.reads >> f) & 1u) + static_cast<double>((stage.writes >> f) & 1u)) *
             bytes;
  }
  return total;
}

/// Medians of one scene on one backend, one set per repetition.
struct Medians {
  std::uint64_t particles = 0;
  std::map<std::string, double> ms;
  std::map<std::string, double> bytes;
};

Medians measure(Running& now, Backend backend) {
  // Long enough for the stages that run every 16 steps.
  const int steps = backend == Backend::cuda ? 64 : 16;
  now.world.scheduler().enable_timings(true);
  Medians m;
  for (int k = 0; k < steps; ++k) {
    if (!now.world.step(now.dt)) return m;
    if (k % 16 == 15) now.world.synchronize();  // events are kept in a ring: read before it turns
  }
  if (now.world.synchronize().halted) return m;
  const meltsim::Plan plan = now.world.plan();
  now.world.scheduler().enable_timings(false);  // whole steps are measured without
  m.particles = now.particles;
  for (const meltsim::StageReport& stage : plan.stages)
    if (stage.runs) m.ms[stage.name] = stage.median_ms;
  for (const StageInfo& info : meltsim::core::stage_table) m.bytes[info.name] = bytes_of(info, plan);
  return m;
}

/// The k-th set of medians; measured when first asked for.
const Medians& medians(const Scene& scene, Backend backend, std::size_t k) {
  static std::map<std::string, std::vector<Medians>> all;
  std::vector<Medians>& sets = all[scene.name + name_of(backend) + std::to_string(scene.nx)];
  while (sets.size() <= k) {
    Running* now = running(scene, backend);
    sets.push_back(now != nullptr ? measure(*now, backend) : Medians{});
  }
  return sets[k];
}

void register_stage(const StageInfo& info, const Scene& scene, Backend backend) {
  const std::string stage = info.name;
  const std::string name = "stage/" + stage + "/" + name_of(backend) + "/" +
                           std::to_string(std::int64_t{scene.nx} * scene.ny * scene.nz);
  benchmark::RegisterBenchmark(
      name.c_str(),
      [stage, scene, backend, repetition = std::size_t{0}](benchmark::State& state) mutable {
        const Medians& m = medians(scene, backend, repetition++);
        const auto ms = m.ms.find(stage);
        for (auto _ : state) state.SetIterationTime(ms != m.ms.end() ? ms->second * 1e-3 : 0.0);
        if (ms == m.ms.end() || !(ms->second > 0)) return state.SkipWithError("the stage did not run");
        state.counters["particles/s"] = static_cast<double>(m.particles) / (ms->second * 1e-3);
        state.counters["bytes/s"] = m.bytes.at(stage) / (ms->second * 1e-3);
      })
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMicrosecond);
}

}  // namespace

void register_stages() {
  for (const Backend backend : backends()) {
    std::set<std::string> sizes;
    for (Scene scene : scenes(backend)) {
      const std::string size = std::to_string(scene.nx) + "x" + std::to_string(scene.ny);
      if (!scene.solid || scene.support != 2.5 || !sizes.insert(size).second) continue;
      for (const StageInfo& info : meltsim::core::stage_table) {
        Scene own = scene;
        const std::string stage = info.name;
        if (stage == "thermal.paper" || stage == "thermal.iwasaki") {
          own.name = info.stage;
          own.heat = stage == "thermal.paper" ? meltsim::HeatModel::paper : meltsim::HeatModel::iwasaki;
        } else if ((info.need & (meltsim::core::fact_freeze | meltsim::core::fact_viscosity |
                                 meltsim::core::fact_heat_boundary | meltsim::core::fact_shifting)) != 0u) {
          own.name = "extras";
          own.extras = true;
        }
        register_stage(info, own, backend);
      }
    }
  }
}

}  // namespace bench
