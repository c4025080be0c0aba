// SPDX-License-Identifier: Apache-2.0
// Engine: the one interface both backends implement. A World talks to this and to nothing below it.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "engine/scene.hpp"
#include "engine/surface_request.hpp"
#include "frame/edit_rows.hpp"
#include "frame/probe_setup.hpp"
#include "frame/ray_rows.hpp"
#include "frame/reading_frame.hpp"
#include "frame/steered.hpp"
#include "meltsim/result.hpp"
#include "meltsim/scheduler.hpp"
#include "meltsim/world.hpp"
#include "pipeline/fusions.hpp"
#include "pipeline/pipeline.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// One layer of one nozzle, in double. Without points: the nozzle has ended and releases a layer that it holds.
struct BurstArguments {
  std::uint32_t first_point = 0, points = 0;
  Vec3d center, velocity;
  double radius = 0;             ///< of the nozzle [m]
  Vec3d across, upright;         ///< of a rectangle: unit vectors along its sides; of a disc 0
  double width = 0, height = 0;  ///< its sides [m]
  double held = 0;               ///< particles farther from the centre than this are released [m]
  double enthalpy = 0, mass = 0, volume = 0;
  std::array<double, most_species> solute{};  ///< of every particle [kg]
  std::uint32_t tag = 0;
};

/// A layer of a nozzle that recycles: its row of Inlets.
struct InletLayer {
  std::uint32_t row = 0;
  Inlet<double> now;
};

struct SubstepArguments {
  double dt = 0, time = 0;
  double end = 0;  ///< [s]
  std::uint64_t index = 0;
  std::uint64_t stages = 0;  ///< bit per stage of the table: run it in this sub-step
  double heat_dt = 0;        ///< of one super-step, time-scaled
  int heat_stages = 0, heat_supersteps = 0;
  double heat_bound = 0;
  double viscous_dt = 0;  ///< of one super-step of viscosity
  int viscous_stages = 0, viscous_supersteps = 0;
  double viscous_bound = 0;
  double solute_dt = 0;  ///< of one sweep, time-scaled
  int solute_supersteps = 0;
  double solute_bound = 0, solute_share = 1;
  const std::vector<BurstArguments>* bursts = nullptr;
  const std::vector<InletLayer>* layers = nullptr;  ///< of nozzles that recycle, at the end of the sub-step
  const std::vector<Steered>* steered = nullptr;
  const std::vector<Reshaped>* reshaped = nullptr;
  std::uint64_t sampled = 0;    ///< bit per probe: due; then stages hold sampling.probes
  std::uint64_t sample_at = 0;  ///< where their values go: first of the samples' values
  double spring_stretch = 1;    ///< how much longer the step that springs go by is than the scene's
};

/// How the engine carries out a sub-step of certain stages.
struct Arrangement {
  std::array<std::int8_t, stage_count>
      track{};  ///< of stages that run concurrently; -1: none, in the order of the table
  std::array<bool, fusion_count> fused{};
  std::vector<std::int8_t> custom_track;  ///< of the host's stages, likewise
};

/// Numbers for timings beyond the stage table.
inline constexpr int surface_stage = stage_count, whole_substep = stage_count + 1,
                     custom_stage = stage_count + 2;

/// A host's stage and where it goes.
struct PlacedStage {
  int after = 0;
  CustomStage stage;
  FieldSet reads = 0, writes = 0;
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

/// Parts of a reading.
struct ReadParts {
  bool sums = false, pieces = false, particles = false;
  bool forces = false;                          ///< what acted on bodies; begins anew with it
  bool events = false;                          ///< begin anew with it
  bool clears = false;                          ///< extremes begin anew, as synchronize() has it
  std::uint64_t first_sample = 0, samples = 0;  ///< values of probes
};

/// A piece, in stored coordinates; SI.
struct PieceReading {
  std::uint32_t label = 0, body = 0;
  std::uint64_t particles = 0;
  double mass = 0;
  Vec3d center, velocity, angular_velocity, low, high;
  Mat3<double> inertia;
  Quat<double> orientation;
  double temperature_mean = 0, submerged_fraction = 0;
};

/// The state at the moment of the request. Parts that were not requested are empty.
struct StateReading {
  WorldStatus status;
  LedgerSums sums;  ///< about the stored origin
  ContentSums contents;
  ExtentSums extents;
  std::uint32_t piece_count = 0;
  std::vector<PieceReading> pieces;  ///< by label
  ParticleFrame particles;
  std::vector<ForcesRow> forces;  ///< per body
  EventHead event_head;
  std::vector<EventRow> events;  ///< in the order in which they came
  std::vector<double> samples;
};

/// Slots for readings: a World's, and one for reads that wait.
inline constexpr int reading_slots = most_readings + 1, waiting_slot = most_readings;

class Engine {
 public:
  virtual ~Engine() = default;
  virtual Backend backend() const = 0;
  virtual std::string device_name() const = 0;
  /// Allocates and uploads; on error what was there before is gone and must be uploaded again.
  virtual Status upload(const SceneConstants& constants, const SceneLattice& lattice, const SceneState& state,
                        const EngineSetup& setup) = 0;
  /// Takes another plan for the uploaded scene, with the same search and capacity: missing channels are
  /// allocated and filled from the state or, those of the lattice, from the host; channels that the plan does not
  /// need are freed. Waits. Particles are not copied to or from the host. On error nothing has changed; a World that
  /// halted is left as it is.
  virtual Status adapt(const SceneConstants& constants, const SceneLattice& lattice, const SceneState& state,
                       const EngineSetup& setup) = 0;
  // Edits between sub-steps, of the scene as it was uploaded. They wait, and cost what they touch; kernels over cells find it.
  // None of a World that halted. Densities are those of a sub-step again once one was taken, as after upload().
  /// Particles whose centres lie in a box, in stored coordinates, by id. Returns the status, nothing cleared. Error: out_of_memory.
  virtual Result<WorldStatus> find(const Vec3d& low, const Vec3d& high,
                                   std::vector<FoundParticle>& found) = 0;
  /// Memory for taking out and appending so many, so that append(), take_out() and add_body() do not fail for want of it. Error:
  /// out_of_memory.
  virtual Status make_edit_room(std::uint64_t taken, std::uint64_t appended) = 0;
  /// Particles get the next ids; there is room for them. heat_level: temperatures are level with them. vertex: of the first, where
  /// they are a body, whose part of the lattice add_body() is given; else none. Error: out_of_memory.
  virtual Status append(const SceneState& more, bool heat_level, std::uint32_t vertex) = 0;
  /// The part of the lattice that belongs to the body added last, for which there is room. Where there is no lattice yet, adapt() makes
  /// it.
  virtual Status add_body(const SceneLattice& lattice, const SceneState& state, const AddedBody& added) = 0;
  /// Removes what find() has found since the last sub-step. Error: out_of_memory.
  virtual Status take_out(const std::vector<FoundParticle>& what) = 0;
  /// Puts what find() has found since the last sub-step at the positions in the list. Error: out_of_memory.
  virtual Status move(const std::vector<FoundParticle>& what) = 0;
  /// Removes all that is solid of a body, whose `count` vertices begin at `first`. How much that was. Error: out_of_memory.
  virtual Result<std::uint64_t> take_body(std::uint32_t body, std::uint32_t first, std::uint32_t count) = 0;
  /// What is solid of a body, whose `count` vertices begin at `first`, by id. Returns the status, nothing cleared. Error: out_of_memory.
  virtual Result<WorldStatus> find_body(std::uint32_t body, std::uint32_t first, std::uint32_t count,
                                        std::vector<FoundParticle>& found) = 0;
  /// Holds what find_body() has found, or lets it go with the velocities that stand in place of positions.
  virtual Status hold(const std::vector<FoundParticle>& what, bool on, std::uint32_t first,
                      std::uint32_t count) = 0;
  /// The row of a body, and what is summed of the forces on it. place: where particle of the vertex is, which that is relative to.
  virtual Status set_body(std::uint32_t body, const BodyRow& row) = 0;
  virtual Status set_forces(std::uint32_t body, std::uint32_t vertex, BodyForceTotals& forces) = 0;
  /// Waits; writes the State channels of the lattice that are allocated.
  virtual void download_lattice(SceneState& state) = 0;
  /// Waits; writes every State channel in order of id: of the last good state. The status, nothing cleared.
  virtual WorldStatus download(SceneState& state) = 0;
  virtual void download(DerivedState& derived) = 0;
  virtual void download(LatticeMasks& masks) = 0;
  /// Surroundings from the next sub-step on. Does not wait.
  virtual void surround(const Surroundings& surroundings) = 0;
  /// Pushes a free body, at once. Does not wait.
  virtual void push(const PushArguments& push) = 0;
  /// Liquid that a nozzle holds and that moves at `from` moves at `to`. Does not wait.
  virtual void respeed(Vec3d from, Vec3d to) = 0;
  /// Liquid that a nozzle holds moves by `shift`: particles of its velocity that lie in its pipe, from `begin` along the velocity for
  /// `length`, within `reach` of its axis. Does not wait.
  virtual void shift(Vec3d velocity, Vec3d begin, double length, double reach, Vec3d shift) = 0;
  /// What region `row` of the constants does from the next sub-step on; held: temperature. Does not wait.
  virtual void set_heat_region(std::uint32_t row, bool held, double temperature, double source) = 0;
  /// What a body gives and takes from the next sub-step on. Does not wait.
  virtual void set_body_heat(std::uint32_t body, const BodyHeat<double>& heat) = 0;
  /// Where region `row` of the constants is from the next sub-step on (core::region_goes_on). Does not wait.
  virtual void move_heat_region(std::uint32_t row, double since, Vec3d displacement, Vec3d velocity) = 0;
  /// What row `row` of the force fields does from the next sub-step on, and how many rows there may be. Does not wait.
  virtual void set_force_field(std::uint32_t row, const physics::ForceField<double>& field,
                               std::uint32_t count) = 0;
  /// The level beyond a face and what comes in there from the next sub-step on; or the layer of a nozzle. Does not wait.
  virtual void set_inlet(std::uint32_t row, const Inlet<double>& now) = 0;
  /// Waits. Reads the quantities that the sound speed follows from, of the last good state.
  virtual SoundLook look() = 0;
  /// Sound speed of the next sub-steps [m/s], for pressures only, until the next upload() or adapt(). change: of its square, whose
  /// work on compressed liquid is counted; 0 if that was counted before. Does not wait.
  virtual void set_sound_speed(double speed, double change) = 0;
  /// Waits. That work since the last call [J].
  virtual double take_sound_work() = 0;
  /// Enqueues one sub-step. No allocation, no copy from the host; waits only where much is enqueued already.
  virtual void substep(const SubstepArguments& arguments) = 0;
  /// Whether substep() returns before its work is done.
  virtual bool runs_ahead() const = 0;
  /// Marks the work enqueued so far, under one of two numbers, for wait_for(). Does not wait.
  virtual void mark(int number) = 0;
  /// Waits for the work enqueued before that mark; later work goes on.
  virtual void wait_for(int number) = 0;
  /// Work enqueued from now on waits for an event of the host; records an event behind the work enqueued so far. Errors: invalid_argument.
  virtual Status wait_for_event(void* event) = 0;
  virtual Status signal_event(void* event) = 0;
  /// Whether the host captures the stream, so that what is enqueued does not run now.
  virtual bool host_captures() const = 0;
  /// A flag that ends sub-steps early, if the backend supports it: an abandoned sub-step does not count, nor does
  /// anything until the next upload; the state is the one it began with.
  virtual void watch(const std::atomic<bool>* asked) = 0;
  virtual bool abandoned() const = 0;
  /// What a stage of the host threw since the last call, with its name; empty if nothing. Its sub-step is abandoned where the stage comes
  /// ahead of step.integrate and is not recorded; else it was taken, without what was left of the stage.
  virtual std::string take_thrown() = 0;
  /// Waits; reports and clears the extremes. If the World halted, goes back to the last good state first.
  virtual WorldStatus synchronize() = 0;
  /// Enqueues a reading of the state as it will be then, and does not wait, except for memory where that is asked for the
  /// first time. Nothing is enqueued on an error: out_of_memory; invalid_argument where the host captures the stream.
  virtual Status request(int slot, const ReadParts& parts) = 0;
  virtual Result<bool> ready(int slot) = 0;
  /// Waits for that reading. If the World had halted, goes back to the last good state and reads that.
  virtual Status take(int slot, StateReading& reading) = 0;
  /// Enqueues particles by id, with colours unless the table is empty; they stay until the next call. Waits only for memory where
  /// more than before is needed, and for another table. Error:
  /// out_of_memory.
  virtual Status pack(const PackColors& colors, const std::vector<std::uint32_t>& table,
                      PackedParticles& to) = 0;
  /// Frees a slot whose reading is not taken.
  virtual void drop(int slot) = 0;
  /// Enqueues a copy of the whole state into memory of the backend, under a number below most_saved_states; waits only for memory.
  /// If the World has halted by then, nothing is copied. Error: out_of_memory.
  virtual Status save(int slot) = 0;
  /// Enqueues the copy back; allowed between a save() and the next upload() or adapt(). If nothing was copied, the World halts.
  virtual void load(int slot) = 0;
  virtual void forget_saved() = 0;
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
  /// How a sub-step of these stages (a bit each) is arranged if it is not timed stage by stage.
  virtual Arrangement arrangement(std::uint64_t stages) const = 0;
  /// Waits. Fills the mesh from the state as it is; true: the World halted, and this is not yet
  /// the last good one. Timed as stage surface_stage.
  /// mesh: null if only the view is requested.
  virtual Result<bool> surface(const SurfaceRequest& request, SurfaceView& view, SurfaceMesh* mesh) = 0;
  /// Waits. Replaces all probes; samples taken so far are lost, but for those of open readings. The state and its buffers stay as they are.
  /// Error out_of_memory: there are no probes then.
  virtual Status set_probes(const ProbeSetup& setup) = 0;
  /// Waits; copies n values of samples. The sub-step that halted the World, 0 where none did.
  virtual std::uint64_t samples(std::uint64_t first, std::uint64_t n, double* to) = 0;
  /// Waits; values of one probe at once, from the last good state. Error: out_of_memory.
  virtual Status sample(const ProbeSetup& what, std::vector<double>& values) = 0;
  /// Waits; where rays end in the last good state. Error: out_of_memory.
  virtual Status follow_rays(const std::vector<RayQuery>& rays, std::uint32_t sought,
                             std::vector<RayRow>& hits) = 0;
};

/// The engine of a backend, or the reason why there is none.
Result<std::shared_ptr<Engine>> make_cpu_engine(const WorldDesc& desc);
Result<std::shared_ptr<Engine>> make_cuda_engine(const WorldDesc& desc);

/// Description of CUDA devices for `meltsim info`.
struct CudaInfo {
  bool built = false;
  std::string runtime, driver, reason, architectures;
  std::vector<std::string> devices;
};
CudaInfo cuda_info();

}  // namespace core
}  // namespace v0
}  // namespace meltsim
