// SPDX-License-Identifier: Apache-2.0
// Engine: the one interface both backends implement. A World talks to this and to nothing below it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/pipeline.hpp"
#include "core/probe_setup.hpp"
#include "core/scene.hpp"
#include "core/surface_request.hpp"
#include "meltsim/result.hpp"
#include "meltsim/scheduler.hpp"
#include "meltsim/world.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// One layer of one nozzle, in double.
struct BurstArguments {
  std::uint32_t first_point = 0, points = 0;
  Vec3d center, velocity;
  double enthalpy = 0, mass = 0, volume = 0;
  std::uint32_t tag = 0;
};

struct SubstepArguments {
  double dt = 0, time = 0;
  std::uint64_t index = 0;
  std::uint64_t stages = 0;  ///< bit per stage of the table: run it in this sub-step
  double heat_dt = 0;        ///< of one super-step, time-scaled
  int heat_stages = 0, heat_supersteps = 0;
  double heat_bound = 0;
  const std::vector<BurstArguments>* bursts = nullptr;
  std::uint64_t sampled = 0;    ///< bit per probe: due; then stages hold sampling.probes
  std::uint64_t sample_at = 0;  ///< where their values go: first of the samples' values
};

/// Numbers for timings beyond the stage table.
inline constexpr int surface_stage = stage_count, whole_substep = stage_count + 1,
                     custom_stage = stage_count + 2;

/// A host's stage and where it goes.
struct PlacedStage {
  int after = 0;
  CustomStage stage;
};

/// Particle channels that only exist after a step.
struct DerivedState {
  std::vector<double> density;        ///< phi per id
  std::vector<double> pressure_term;  ///< P/phi^2 per id
};

struct LatticeMasks {
  std::vector<std::uint32_t> neighbour_mask, region_mask;
  std::uint32_t region_words = 0;
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual Backend backend() const = 0;
  virtual std::string device_name() const = 0;
  /// Allocates and uploads; on error what was there before is gone and must be uploaded again.
  virtual Status upload(const SceneConstants& constants, const SceneLattice& lattice, const SceneState& state,
                        const EngineSetup& setup) = 0;
  /// Waits; writes every State channel in order of id.
  virtual void download(SceneState& state) = 0;
  virtual void download(DerivedState& derived) = 0;
  virtual void download(LatticeMasks& masks) = 0;
  /// Enqueues one sub-step. No allocation, no copy from the host; waits only where much is enqueued already.
  virtual void substep(const SubstepArguments& arguments) = 0;
  /// The next sub-step builds what is kept between sub-steps anew, as one after an upload does.
  virtual void rebuild() = 0;
  /// Waits; reports and clears the extremes. If the World halted, goes back to the last good state first.
  virtual WorldStatus synchronize() = 0;
  /// Waits; the status with sums over the particles, nothing cleared. Goes back likewise.
  virtual WorldStatus ledger() = 0;
  /// Device fault since the last call, empty if none.
  virtual std::string fault() = 0;
  virtual std::uint64_t channel_bytes(int field) const = 0;
  virtual std::uint64_t scratch_bytes() const = 0;
  /// Sub-steps recorded since the last upload.
  virtual std::uint64_t graphs() const = 0;
  virtual std::uint64_t bytes_needed(const SceneConstants&, const SceneLattice&,
                                     const EngineSetup&) const = 0;
  virtual std::uint64_t free_bytes() const = 0;
  virtual void set_custom_stages(const std::vector<PlacedStage>* stages) = 0;
  /// Stages are timed in one sub-step of `every`; 0 = in none.
  virtual void enable_timings(int every) = 0;
  virtual double median_ms(int stage) = 0;  ///< custom_stage + k for custom stage k
  virtual StageContext context() const = 0;
  /// Waits. Fills the mesh from the state as it is; true: the World halted, and this is not yet
  /// the last good one. Timed as stage surface_stage.
  virtual Result<bool> surface(const SurfaceRequest& request, SurfaceMesh& mesh) = 0;
  /// Waits. Replaces all probes; samples taken so far are lost. The state and its buffers stay as they are.
  /// Error out_of_memory: there are no probes then.
  virtual Status set_probes(const ProbeSetup& setup) = 0;
  /// Waits; copies n values of samples. The sub-step that halted the World, 0 where none did.
  virtual std::uint64_t samples(std::uint64_t first, std::uint64_t n, double* to) = 0;
  /// Waits; values of one probe at once, from the last good state. Error: out_of_memory.
  virtual Status sample(const ProbeSetup& what, std::vector<double>& values) = 0;
};

/// Result of asking for an engine: the engine, or why there is none.
Result<std::shared_ptr<Engine>> make_cpu_engine(const WorldDesc& desc);
Result<std::shared_ptr<Engine>> make_cuda_engine(const WorldDesc& desc);

/// What `meltsim info` says of CUDA.
struct CudaInfo {
  bool built = false;
  std::string runtime, driver, reason, architectures;
  std::vector<std::string> devices;
};
CudaInfo cuda_info();

}  // namespace core
}  // namespace v0
}  // namespace meltsim
