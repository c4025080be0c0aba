// SPDX-License-Identifier: Apache-2.0
// Benchmarks, named so that records of different days compare:
//
//   verb/<sort|scan|reduce>/<backend>/<n>          one verb, on the executor itself
//   stage/<module.stage>/<backend>/<particles>     one stage inside a running World, as World::plan() reports
//   it scene/<name>/<backend>/<particles>             one whole step: K steps enqueued, then synchronize(),
//   over K
//
// All times are manual: events on CUDA (verbs, stages), the clock of the host elsewhere. A stage's time is
// the median over the last steps of a World with timings on, taken once per repetition; the World goes on
// between them. Counters: particles/s, and bytes/s for stages: every channel the stage table names counted
// once, so it is what a perfect cache would leave, not what the memory moved.
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

/// A step of what: see scenes.cpp.
struct Scene {
  std::string name;
  int nx, ny, nz;        ///< the filled block, in spacings
  double support = 2.5;  ///< in spacings
  bool solid = false;    ///< a third of it is ice, some of which melts in every step
  meltsim::HeatModel heat = meltsim::HeatModel::enthalpy;
  bool extras =
      false;  ///< also what few scenes need: warm walls, freezing, viscosity that depends on temperature
};

/// A World, prepared and past its first steps.
struct Running {
  std::string key;  ///< which scene on which backend
  meltsim::World world;
  double dt;  ///< one sub-step
  std::uint64_t particles;
};
/// The one that runs now if it is of this scene, or a new one. Null, with the reason on stderr, when it
/// halts.
Running* running(const Scene& scene, Backend backend);

/// "60500" and "1000000" on CUDA; the CPU gets what it can step in a reasonable time.
std::vector<Scene> scenes(Backend backend);

void register_verbs_cpu();
void register_verbs_cuda();
void register_stages();
void register_steps();

}  // namespace bench
