// SPDX-License-Identifier: Apache-2.0
// The plan of a step: which stages run, why, and at what cost; stages of the host.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meltsim/export.hpp"
#include "meltsim/result.hpp"
#include "meltsim/span.hpp"
#include "meltsim/stage_clock.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
/// A stage in the plan.
struct StageReport {
  std::string name;      ///< "module.stage"; also profiler range, timing row and benchmark name
  std::string module;    ///< spatial, sph, lsm, thermal, topology, step, surface, or "custom"
  bool runs = false;     ///< whether the present scene needs it
  std::string reason;    ///< why it runs or why it is left out
  int interval = 1;      ///< runs every so many sub-steps; 0: when the host calls for it
  double median_ms = 0;  ///< median over the last timed sub-steps, run alone; 0 if none was timed
  /// Stages on different tracks may run concurrently; -1: stages run one by one, as on a CPU and beside stages of the
  /// host that are not recorded.
  int track = -1;
};
/// Work of one stage that another does in passing, with the same results.
struct FusionReport {
  std::string name;    ///< sph.advance, step.count_ahead
  bool holds = false;  ///< in sub-steps that are not timed stage by stage
  std::string reason;  ///< what is fused, or where it would be
};
/// A channel (a buffer) in the plan.
struct ChannelReport {
  std::string name;         ///< as in fields.def
  std::string type;         ///< of an entry
  std::string owner;        ///< what there is one entry of: particle, vertex, cell, ...
  std::string lifetime;     ///< State, Static, Derived or Scratch
  std::string unit;         ///< of its values
  std::uint64_t bytes = 0;  ///< 0: not allocated, because no stage of the plan uses it
};
/// The plan of a World: its stages in order, its channels, its memory.
struct Plan {
  std::vector<StageReport> stages;      ///< in the order of a sub-step
  std::vector<ChannelReport> channels;  ///< in the order of fields.def
  std::vector<FusionReport> fusions;    ///< as sub-steps run
  std::string error;        ///< why nothing can run (the error of World::prepare()); empty: everything can
  std::uint64_t bytes = 0;  ///< of all buffers together
  /// CUDA graphs made since the last change of the scene: one per kind of sub-step; later sub-steps replay them.
  std::uint64_t graphs = 0;
  std::uint64_t uploads =
      0;  ///< how often the whole scene was uploaded: once it was built, and after changes that ask for it
  int timings_every = 0;  ///< stages are timed in one of so many sub-steps; 0: never
  /// Median time of whole sub-steps as they usually run [ms], measured as often as stages; 0 if none was measured, for
  /// example when every sub-step is timed stage by stage.
  double substep_ms = 0;
  /// The plan as a table for a terminal.
  MELTSIM_API std::string to_string() const;
};

/// Arguments of a custom stage, or what World::device_state() returns: raw pointers into the backend's memory, one entry per
/// particle in the order of slots. T is float or double (`precision`). A stage's pointers hold until it returns.
struct StageContext {
  Backend backend = Backend::cpu;                     ///< whose memory the pointers are in
  Precision precision = Precision::single_precision;  ///< of T
  void* stream = nullptr;  ///< the World's cudaStream_t on CUDA: launch there and do not wait
  double dt = 0;           ///< length of this sub-step [s]; recorded: of the one in which `run` was called
  double time = 0;         ///< at its start [s]; recorded: likewise
  std::uint64_t particles = 0;   ///< number of entries
  void* position = nullptr;      ///< Vec4<T>: x, y, z relative to Resolved::origin [m], rest volume [m^3]
  void* velocity = nullptr;      ///< Vec4<T>: vx, vy, vz [m/s]; do not write w, an operand of the library
  void* acceleration = nullptr;  ///< Vec3<T> [m/s^2]; add to it after "sph.forces" / before "step.integrate"
  /// [J] per particle; null if no stage of heat runs and no custom stage names "enthalpy".
  const double* enthalpy = nullptr;
  /// [J] by id where `enthalpy` is null; else null.
  const double* enthalpy_of_id = nullptr;
  const std::uint32_t* id = nullptr;   ///< stable id per particle
  const std::uint32_t* tag = nullptr;  ///< see meltsim/particle_tag.hpp
  const StageClock* clock = nullptr;   ///< of the sub-step that runs, recorded or not; null outside of stages
  std::uint64_t serial = 0;  ///< of World::device_state(), for World::check_view(); 0 in a custom stage
};

/// Called once per sub-step; of a recorded stage, when the sub-step is recorded. What it throws ends the step as World::interrupt() does: step()
/// returns an Error (internal) that names the stage, and the World can go on. The sub-step does not count where the stage comes ahead of
/// "step.integrate" (but for one that CUDA records); else it does, without what was left of the stage.
using CustomStageFunction = void (*)(const StageContext&, void* user);
/// A stage of the host.
struct CustomStage {
  std::string name;                   ///< unique; reported as "custom.<name>"
  CustomStageFunction run = nullptr;  ///< enqueues the work of the stage
  void* user = nullptr;               ///< passed to run
  // Names in fields.def; unknown names are refused.
  std::vector<std::string> reads, writes;  ///< channels that it reads; channels that it writes
  /// What `run` enqueues is the same in every sub-step: the same kernels with the same arguments. Then CUDA records it with the
  /// sub-step (a graph) and repeats it without the host; `run` is called again whenever a sub-step is recorded or timed. It
  /// must not wait, allocate or copy from pageable memory, and must work on `stream`, which it may leave and join by events.
  /// `reads` and `writes` must name all that it touches: stages that touch nothing of it run beside it. What changes with
  /// time goes through StageContext::clock or memory of the host's own. A CPU calls `run` in every sub-step.
  bool recorded = false;
};

/// Stages of a World: custom stages, intervals, timings. It belongs to its World and to the same thread.
class MELTSIM_API Scheduler {
 public:
  virtual ~Scheduler() = default;
  /// Runs `stage` after the built-in stage named `after` in every sub-step, on the World's stream. "step.integrate"
  /// checks the values that a stage before it writes: a NaN or infinity halts the World at the state before the sub-step. Values that a
  /// stage after it writes are part of the state and checked in the next sub-step. A sub-step with stages that are not
  /// recorded runs its stages one after another, each enqueued by the host. One that cannot be recorded halts the World.
  /// Errors: invalid_argument (unknown `after`, duplicate name, null function, unknown channel).
  virtual Status insert_after(const std::string& after, CustomStage stage) = 0;
  virtual Status remove(const std::string& name) = 0;  ///< removes a custom stage of this name
  /// Runs the stages of a module only in every n-th sub-step, n >= 1: "thermal" (HeatDesc::interval, at most 1000: within a
  /// step) and "topology" only.
  virtual Status set_interval(const std::string& module, int n) = 0;
  /// Switches a module off, or on again. "spatial" and "step" cannot be switched off.
  virtual Status enable(const std::string& module, bool on) = 0;
  /// Times the stages in one of `every` sub-steps. That sub-step runs them one after another, which takes about as long
  /// as three others and gives the same results. World::plan() has the medians and does not wait for the device.
  /// Errors: invalid_argument (`every` below 1).
  virtual Status enable_timings(bool on, int every = 400) = 0;
};

}  // namespace v0
}  // namespace meltsim
