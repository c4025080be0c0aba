// SPDX-License-Identifier: Apache-2.0
// The plan of a step: which stages run, why, what they cost; and the host's own stages.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meltsim/export.hpp"
#include "meltsim/result.hpp"
#include "meltsim/span.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

struct StageReport {
  std::string name;    ///< "module.stage"; also profiler range, timing row and benchmark name
  std::string module;  ///< spatial, sph, lsm, thermal, topology, step, surface, or "custom"
  bool runs = false;
  std::string reason;    ///< why it runs or why it is left out
  int interval = 1;      ///< runs every this many steps; 0 = when the host asks
  double median_ms = 0;  ///< of the last timed sub-steps, run by itself; 0 when there was none
};

struct ChannelReport {
  std::string name;
  std::string type;
  std::string owner;
  std::string lifetime;
  std::string unit;
  std::uint64_t bytes = 0;  ///< 0 = not allocated: nothing in the plan uses it
};

struct Plan {
  std::vector<StageReport> stages;
  std::vector<ChannelReport> channels;
  std::string error;        ///< why nothing can run (World::prepare() fails so); empty: it can
  std::uint64_t bytes = 0;  ///< all buffers together
  /// CUDA graphs made since the last change of the scene: one per kind of sub-step, then they are replayed.
  std::uint64_t graphs = 0;
  int timings_every = 0;  ///< stages are timed in one sub-step of so many; 0 = in none
  /// Median time of whole sub-steps as they usually run [ms], measured as often as stages; 0 when none was, as when every
  /// sub-step is timed stage by stage.
  double substep_ms = 0;
  /// The plan as a table for a terminal.
  MELTSIM_API std::string to_string() const;
};

/// What a custom stage sees: raw pointers into the backend's memory. Positions and velocities are packed
/// four to a particle (x, y, z, operand); `precision` says float or double.
struct StageContext {
  Backend backend = Backend::cpu;
  Precision precision = Precision::single_precision;
  void* stream = nullptr;  ///< cudaStream_t on CUDA
  double dt = 0;           ///< [s], of this sub-step
  double time = 0;         ///< [s], at its start
  std::uint64_t particles = 0;
  void* position = nullptr;      ///< Vec4<T>: x, y, z relative to World::origin() [m], volume [m^3]
  void* velocity = nullptr;      ///< Vec4<T>: vx, vy, vz [m/s], operand (do not write w)
  void* acceleration = nullptr;  ///< Vec3<T> [m/s^2]; add to it after "sph.forces" / before "step.integrate"
  /// [J] per particle; null where heat is at rest and no custom stage names "enthalpy".
  const double* enthalpy = nullptr;
  const std::uint32_t* id = nullptr;   ///< stable id per particle
  const std::uint32_t* tag = nullptr;  ///< see meltsim/particle_tag.hpp
};

using CustomStageFunction = void (*)(const StageContext&, void* user);

struct CustomStage {
  std::string name;  ///< unique; reported as "custom.<name>"
  CustomStageFunction run = nullptr;
  void* user = nullptr;
  /// Channels it reads and writes, by their names in fields.def. Unknown names are refused.
  std::vector<std::string> reads, writes;
};

/// Belongs to its World. Not thread-safe against World::step.
class MELTSIM_API Scheduler {
 public:
  virtual ~Scheduler() = default;
  /// Runs `stage` after the built-in stage named `after`, on the World's stream, every sub-step. What it writes is checked
  /// by "step.integrate": ahead of that a value that is no number halts the World with the state before; behind it, it is
  /// part of the state when the next sub-step finds it.
  /// Errors: unknown `after`, duplicate name, null function, unknown channel.
  virtual Status insert_after(const std::string& after, CustomStage stage) = 0;
  virtual Status remove(const std::string& name) = 0;
  /// Runs a module's stages only every n-th step. Only "thermal" and "topology" may be thinned out.
  virtual Status set_interval(const std::string& module, int n) = 0;
  /// Switches a module off or on again. "spatial" and "step" cannot be switched off.
  virtual Status enable(const std::string& module, bool on) = 0;
  /// Times stages in one sub-step of every `every`. That sub-step runs them one after another, which costs about as much
  /// as three others; its results are the same. The medians are in plan(), which does not wait for the device.
  /// Errors: `every` below 1.
  virtual Status enable_timings(bool on, int every = 400) = 0;
};

}  // namespace v0
}  // namespace meltsim
