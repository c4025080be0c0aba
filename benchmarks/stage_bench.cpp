// SPDX-License-Identifier: Apache-2.0
// Stages, one benchmark each, from the timings of running Worlds. All stages of one World are measured by the
// same steps; asking for one of them runs them all.
#include <algorithm>
#include <map>

#include "bench.hpp"
#include "pipeline/pipeline.hpp"

namespace bench {

namespace {

using meltsim::core::field_count;
using meltsim::core::field_table;
using meltsim::core::StageInfo;

/// Bytes of the channels a stage reads and writes, each counted once for each: the model of bench.hpp.
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
    total += ((stage.reads.has(f) ? 1.0 : 0.0) + (stage.writes.has(f) ? 1.0 : 0.0)) * bytes;
  }
  return total;
}

/// Medians of one scene on one backend, one set per repetition.
struct Medians {
  std::uint64_t particles = 0;
  std::map<std::string, double> ms;
  std::map<std::string, double> bytes;
};

Medians measure(Running& now, const Scene& scene, Backend backend) {
  // Long enough for the stages that run every 16 steps.
  const int steps = backend == Backend::cuda && !scene.large() ? 64 : 16;
  static_cast<void>(now.world.scheduler().enable_timings(true, 1));  // every sub-step
  Medians m;
  for (int k = 0; k < steps; ++k) {
    if (!now.world.step(now.dt)) return m;
    if (k % 16 == 15) now.world.synchronize();  // events are kept in a ring: read before it turns
  }
  if (now.world.synchronize().halted) return m;
  const meltsim::Plan plan = now.world.plan();
  static_cast<void>(now.world.scheduler().enable_timings(false));  // whole steps are measured without
  m.particles = now.particles;
  for (const meltsim::StageReport& stage : plan.stages)
    if (stage.runs) m.ms[stage.name] = stage.median_ms;
  for (const StageInfo& info : meltsim::core::stage_table) m.bytes[info.name] = bytes_of(info, plan);
  return m;
}

/// The k-th set of medians; measured when first asked for.
const Medians& medians(const Scene& scene, Backend backend, std::size_t k) {
  static std::map<std::string, std::vector<Medians>> all;
  std::vector<Medians>& sets = all[scene.title(backend)];
  while (sets.size() <= k) {
    Running* now = running(scene, backend);
    sets.push_back(now != nullptr ? measure(*now, scene, backend) : Medians{});
  }
  return sets[k];
}

void register_stage(const StageInfo& info, const Scene& scene, Backend backend) {
  const std::string stage = info.name;
  const std::string name = "stage/" + stage + "/" + name_of(backend) + "/" +
                           std::to_string(scene.block.all()) + (scene.plain() ? "" : "/" + scene.what());
  benchmark::RegisterBenchmark(
      name.c_str(),
      [stage, scene, backend, repetition = std::size_t{0}](benchmark::State& state) mutable {
        const Medians& m = medians(scene, backend, repetition++);
        const auto ms = m.ms.find(stage);
        for (auto _ : state) state.SetIterationTime(ms != m.ms.end() ? ms->second * 1e-3 : 0.0);
        if (ms == m.ms.end() || !(ms->second > 0)) return state.SkipWithError("the stage did not run");
        state.counters["particles/s"] = static_cast<double>(m.particles) / (ms->second * 1e-3);
        state.counters["bytes"] = m.bytes.at(stage);
        state.counters["bytes/s"] = m.bytes.at(stage) / (ms->second * 1e-3);
      })
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMicrosecond);
}

}  // namespace

void register_stages(const Scene& scene, Backend backend) {
  using namespace meltsim::core;
  std::vector<std::pair<const StageInfo*, Scene>> last;
  for (const StageInfo& info : stage_table) {
    const std::string stage = info.name;
    const bool model = stage == "thermal.paper" || stage == "thermal.iwasaki";
    const bool few = (info.need & (fact_freeze | fact_viscosity | fact_heat_boundary | fact_shifting)) != 0u;
    if ((info.need & (any_search & ~fact_packed)) != 0u) continue;  // register_searches
    if ((info.need & fact_dry) != 0u) continue;                     // there is liquid in every scene
    if ((info.need & (fact_probes | fact_loads)) != 0u) continue;   // scene/water_gauges, _points, _forces
    if ((info.need & fact_levels) != 0u) continue;                  // in one sub-step of 64
    // No scene of the benchmarks asks for these: rigid and kinematic bodies, forces on bodies, events, outlets, inlets, nozzles that recycle,
    // force fields.
    if ((info.need & (fact_rigid | fact_kinematic | fact_forces | fact_events | fact_outlets | fact_inlets |
                      fact_reserves | fact_fields)) != 0u)
      continue;
    const bool liquids =
        (info.need & (fact_implicit | fact_strain | fact_species | fact_tension | fact_isotropic)) != 0u;
    if (!model && !few && !liquids) {
      register_stage(info, scene, backend);
      continue;
    }
    // Scenes of their own, after the rest: Worlds are built once.
    if (!scene.plain() || scene.large()) continue;
    Scene own = scene;
    own.name = model ? info.stage : liquids ? "liquids" : "extras";
    own.liquids = liquids;
    own.extras = few && !liquids;
    if (liquids) own.solid = false;
    if (model) own.heat = stage == "thermal.paper" ? meltsim::HeatModel::paper : meltsim::HeatModel::iwasaki;
    last.emplace_back(&info, own);
  }
  register_step(scene, backend);
  for (const auto& [info, own] : last) register_stage(*info, own, backend);
}

void register_searches() {
  using namespace meltsim::core;
  for (const Backend backend : backends())
    for (const Scene& scene : search_scenes(backend)) {
      FactSet facts = fact_packed;
      if (scene.layout == "droplets") facts = fact_sorted | fact_sparse;
      if (scene.search == meltsim::NeighbourSearch::tree) facts = fact_sorted | fact_tree;
      for (const StageInfo& info : stage_table) {
        const bool search = (info.need & any_search) != 0u && runs(info, facts);
        if (search || std::string(info.name) == "sph.density") register_stage(info, scene, backend);
      }
      register_step(scene, backend);
    }
}

void register_widths() {
  for (const Backend backend : backends())
    for (const Scene& scene : width_scenes(backend)) {
      for (const StageInfo& info : meltsim::core::stage_table) {
        const std::string stage = info.name;
        if (stage == "lsm.regions" || stage == "lsm.goals" || stage == "topology.regions")
          register_stage(info, scene, backend);
      }
      register_step(scene, backend);
    }
}

void register_scenes() {
  for (const Backend backend : backends())
    for (const Scene& scene : scenes(backend)) {
      if (scene.solid) register_stages(scene, backend);
      else register_step(scene, backend);
    }
}

}  // namespace bench
