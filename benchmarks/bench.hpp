// SPDX-License-Identifier: Apache-2.0
// Benchmarks, named so that records of different days compare:
//
//   verb/<sort|scan|reduce>/<backend>/<n>                 one verb, on the executor itself
//   stage/<module.stage>/<backend>/<particles>[/<what>]   one stage inside a running World, as World::plan()
//                                                         reports it; what: 2d, double
//   scene/<name>[_<what>]/<backend>/<particles>           one whole step: K steps enqueued, then
//                                                         synchronize(), over K
//   paper/<table2_...|fig7>/<backend>/<particles>         5 ms, the paper's step, in as many sub-steps as
//                                                         that takes (counter substeps)
//   threads/<name>[_<what>]/cpu/<particles>/<threads>     scene/... on so many threads of the CPU
//   surface/<whose>_<kernel>/<backend>/<particles>   World::surface() of the melting scene between
//                                                         steps; counter device_ms: what of it the backend
//                                                         works, without the host's copies
//   profile/<name>[_<what>]/cuda/<particles>              one step between cudaProfilerStart and -Stop, for
//                                                         ncu; only where MELTSIM_BENCHMARK_PROFILE is set
//
// own and own_recorded: with a stage of the host's that does nothing, enqueued in every sub-step or recorded with it.
// gauges, points and forces: with so many probes, samples read after every few steps. 2d is a support of 2 spacings, otherwise 2.5; double is the precision, otherwise single. All times are
// manual: events on CUDA (verbs, stages), the clock of the host elsewhere. A stage's time is the median over
// the last steps of a World with timings on, taken once per repetition; the World goes on between them.
//
// Counters: particles/s, and bytes (of one run) and bytes/s for stages. Bytes are a model, not a measurement:
// every channel that the stage table names, whole, once if it is read and once if it is written. A stage that
// touches part of a channel moves less, one whose gathers fall out of the caches moves more; what the memory
// did move is what stage_table.py takes from ncu.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>
#include <vector>

#include "meltsim/world.hpp"

namespace bench {

using meltsim::Backend;

const char* name_of(Backend backend);

/// Backends that can run here.
const std::vector<Backend>& backends();

/// Sites of a lattice along x, y, z.
struct Sites {
  int x = 0, y = 0, z = 0;
  std::int64_t all() const { return std::int64_t{x} * y * z; }
};

/// A step of what: see scenes.cpp.
struct Scene {
  std::string name;
  Sites block;           ///< the filled block, in spacings
  double support = 2.5;  ///< in spacings
  bool solid = false;    ///< a part of it is ice, some of which melts in every step
  int half_width = 2;    ///< of its regions
  Sites ice{};           ///< that part; zero = a third
  bool in_double = false;
  bool paper = false;  ///< the paper's spacing, and its step of 5 ms
  int threads = 0;     ///< of the CPU; 0 = all
  meltsim::HeatModel heat = meltsim::HeatModel::enthalpy;
  bool extras =
      false;  ///< also what few scenes need: warm walls, freezing, viscosity that depends on temperature
  /// Stages that liquids bring along: implicit viscosity in six stages, a yield stress, surface tension, isotropic pressure, two contents. No solids.
  bool liquids = false;

  meltsim::NeighbourSearch search = meltsim::NeighbourSearch::automatic;
  std::string layout;  ///< of the comparison of searches: "pool", "slosh" or "droplets"

  std::string
      probes;  ///< what is sampled: "gauges" (8 levels at 1 kHz), "points" (1000 at every step), "forces" (on six walls at 1 kHz), or nothing

  std::string own;  ///< a stage of the host's that does nothing: "own", or "own_recorded", or nothing

  bool plain() const {
    return support == 2.5 && half_width == 2 && !in_double && layout.empty() && probes.empty() && own.empty();
  }
  /// Of 5 million particles or more: measured in few steps.
  bool large() const { return block.all() >= 5000000; }
  /// "2d", "double", "w3", "gauges", "points", "<layout>_<search>", or nothing where plain().
  std::string what() const {
    if (!layout.empty()) return layout + "_" + search_name();
    if (!probes.empty()) return probes;
    if (!own.empty()) return own;
    if (half_width != 2) return "w" + std::to_string(half_width);
    return in_double ? "double" : plain() ? "" : "2d";
  }
  std::string search_name() const {
    if (search == meltsim::NeighbourSearch::automatic) return "automatic";
    return search == meltsim::NeighbourSearch::tree ? "tree" : "grid";
  }
  /// "<name>/<backend>/<particles>"
  std::string title(Backend backend) const {
    return name + (plain() ? "" : "_" + what()) + "/" + name_of(backend) + "/" + std::to_string(block.all());
  }
};

/// A World, prepared and past its first steps.
struct Running {
  std::string key;  ///< which scene on which backend
  meltsim::World world;
  double dt;  ///< one sub-step; the paper's step where the scene is the paper's
  std::uint64_t particles;
};
/// The one that runs now if it is of this scene, or a new one. Null, with the reason on stderr, when it
/// halts.
Running* running(const Scene& scene, Backend backend);

/// "60500" and "1000000" on CUDA, ten million where MELTSIM_BENCHMARK_LARGE is set; the CPU gets what it can
/// step in a reasonable time.
std::vector<Scene> scenes(Backend backend);
/// A pool at rest, one that sloshes, and two droplets in an unbounded domain, by every structure.
std::vector<Scene> search_scenes(Backend backend);
/// Regions of other half-widths.
std::vector<Scene> width_scenes(Backend backend);
/// Water with probes.
std::vector<Scene> probe_scenes(Backend backend);
/// Water and melting with a stage of the host's.
std::vector<Scene> own_stage_scenes(Backend backend);
/// The rows of the paper's Table 2 and the sizes of its Fig. 7.
std::vector<Scene> paper_scenes(Backend backend);

void register_verbs_cpu();
void register_verbs_cuda();
/// Stages and whole steps of one scene after the other: building ten million particles takes longer than
/// measuring them.
void register_scenes();
void register_stages(const Scene& scene, Backend backend);
void register_step(const Scene& scene, Backend backend);
/// Every structure that finds neighbours, in scenes that differ in what it costs.
void register_searches();
/// What regions of half-widths from 1 to 8 cost.
void register_widths();
/// What probes add to a step: beside scene/water.
void register_probes();
/// What a stage of the host's adds to a step, beside its own work: beside scene/water and scene/melting.
void register_own_stages();
void register_paper();
void register_threads();
/// Surfaces of the scene of 60,500 particles, and on CUDA of the one of a million.
void register_surfaces();
void register_profile();

/// cudaProfilerStart, cudaProfilerStop.
void profile(bool on);

}  // namespace bench
