// SPDX-License-Identifier: Apache-2.0
// World: owns every buffer of one simulation and runs its steps.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "meltsim/desc.hpp"
#include "meltsim/export.hpp"
#include "meltsim/probe.hpp"
#include "meltsim/reading.hpp"
#include "meltsim/result.hpp"
#include "meltsim/scheduler.hpp"
#include "meltsim/span.hpp"
#include "meltsim/surface.hpp"

namespace meltsim {
inline namespace v0 {

/// The lattice of all bodies, for inspection and tests: the paper's index arrays. Vertices are numbered from
/// 1; 0 = empty.
struct LatticeData {
  /// Per vertex: the particle it holds or held last; 0xffffffff where liquid may freeze and nothing did yet.
  std::vector<std::uint32_t> particle_id;
  std::vector<std::uint8_t> live;     ///< per vertex
  std::vector<Vec3i> coordinates;     ///< per vertex, on its body's lattice
  std::vector<std::uint32_t> body;    ///< per vertex, index + 1
  std::vector<std::uint32_t> arrayN;  ///< 27 per vertex, offsets (dx,dy,dz) with dx fastest
  int region_half_width = 0;          ///< largest w in the World
  std::vector<std::uint32_t> arrayR;  ///< (2w+1)^3 per vertex, same order
};

/// How stiff bodies of a material are.
struct Stiffness {
  int region_half_width = 0;  ///< w in use
  double stiffness = 0;       ///< alpha in use
  double youngs_modulus = 0;  ///< what they deliver at that sub-step [Pa]; 0 while no sub-step is known
};

/// Values the World derived from "automatic".
struct Resolved {
  Backend backend = Backend::cpu;
  std::string backend_reason;
  std::string device_name;
  NeighbourSearch neighbour_search = NeighbourSearch::grid;  ///< what automatic chose, or what was asked for
  std::string neighbour_reason;                              ///< which form of it, and why
  double support_radius = 0;                                 ///< [m]
  double sound_speed = 0;                                    ///< [m/s]; 0 while empty
  double stable_dt = 0;  ///< largest sub-step [s]; infinity when nothing limits it
  int heat_stages = 0;  ///< Runge-Kutta-Legendre stages of a super-step of heat at that sub-step; 0 = no heat
  int heat_supersteps = 0;  ///< super-steps in that sub-step, at most HeatDesc::max_supersteps
  std::int64_t heat_sweeps =
      0;  ///< their product: sweeps over all neighbours that heat takes in that sub-step
  /// Share of the diffusivity asked for that the heat model delivers at that sub-step, for the best
  /// conductor: 1 for enthalpy; below 1 for paper, falling with the step (its energy drift shows in
  /// Totals::thermal).
  double heat_efficiency = 1;
  /// Per material, in the order added: for the last sub-step taken, before the first for stable_dt if finite.
  std::vector<Stiffness> stiffness;
  Vec3d origin;       ///< stored positions are relative to it [m]
  std::string error;  ///< why the scene cannot be prepared, as World::prepare() says; empty: it can
};

class WorldImpl;

/// One simulation. Movable, not copyable. Worlds are independent: two may live in one process on any
/// threads, but one World must not be called from two threads at a time.
class MELTSIM_API World {
 public:
  /// Errors: invalid_argument (names the field), version_mismatch, no_device.
  static Result<World> create(const WorldDesc& desc = {},
                              std::uint32_t header_version = MELTSIM_VERSION_NUMBER);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  // Building. Each call validates everything first; on error the World is unchanged. They synchronise.
  Result<MaterialId> add_material(const MaterialDesc& desc);
  Result<std::uint64_t> add_fluid(const FluidDesc& desc);  ///< particles added
  Result<BodyId> add_solid(const SolidDesc& desc);
  Result<EmitterId> add_emitter(const EmitterDesc& desc);
  Result<HeatRegionId> add_heat_region(const HeatRegionDesc& desc);
  /// At any time, also between steps: particles stay where they are, and no bit of what follows changes. Waits for what is
  /// enqueued. At most 64 probes, 524,288 values per sample of all of them, and 4,194,304 heights of gauges (one per half spacing
  /// of a line). Errors: invalid_argument (names the field), capacity, out_of_memory.
  Result<ProbeId> add_probe(const ProbeDesc& desc);

  /// Allocates, uploads and plans what the next step needs. step() calls it when something was added; call
  /// it yourself to keep the first step free of allocation. Errors: out_of_memory.
  Status prepare();

  /// Enqueues dt seconds, split into equal sub-steps of at most Resolved::stable_dt. dt = 0 does nothing. Steps of changing
  /// length are safe. Does not allocate, except where the plan changes: a heat region begins or ends, the last emitter
  /// has ended, or a reading said that stages have nothing left to do. Then it waits for what was enqueued and allocates
  /// or frees the channels that differ; particles stay on the device. Else it waits only where the device is more than
  /// about half a second of work behind (never while the host captures the stream). Errors: dt negative, not finite or
  /// below 1e-30 s; step_too_large; halted; interrupted;
  /// out_of_memory as in prepare().
  Status step(double dt);

  /// Asks the step() that is running, or else the next one, to return ErrorCode::interrupted before its next
  /// sub-step; on the CPU also within one, which then does not count. The sub-steps before it count and the World is as usable as ever: time() says how far it came, and
  /// a further step() goes on from there. One call interrupts one step. May be called from another thread or from
  /// a signal handler while the World exists and is not moved: it sets one atomic flag and does nothing else.
  void interrupt() noexcept;

  /// Waits for everything enqueued and reports it. Where the host is out of memory for the report, it has steps and time
  /// only.
  StepResult synchronize();

  /// Largest dt that step() takes without sub-steps [s]: from the sound speed, which bodies' springs follow as well,
  /// viscosity, gravity, the speeds of what was added or is emitted (Resolved::stable_dt, which step() divides by), and those
  /// seen at the last synchronize(), which step() leaves out: results may not hang on when a host looks. Infinity
  /// where nothing can move. Does what prepare() does if something was added.
  double stable_dt() const;
  /// The same for a largest speed [m/s] of one's own, such as a reading's: takes nothing from synchronize().
  double stable_dt(double speed) const;

  // Reading without waiting (meltsim/reading.hpp). While the host captures the World's stream into a CUDA graph they
  // return invalid_argument.
  /// Enqueues a reading behind the steps enqueued so far; does not wait for them. At most `most_readings` may be open. Like
  /// synchronize(), it starts the extremes of StepResult anew: a reading has those since the synchronize() or request()
  /// before it. The first requests allocate; what was added since the last step is uploaded, as by prepare().
  /// Errors: capacity; out_of_memory.
  Result<ReadTicket> request(const ReadRequest& what);
  /// Whether take() would return at once. Never waits. Errors: invalid_argument (no open reading of this World has
  /// this ticket).
  Result<bool> ready(ReadTicket ticket);
  /// Waits for that reading, not for steps enqueued after it, and closes the ticket, also on an error. A reading stays
  /// what it was when the World goes on, grows or is restored. If a step ahead of the request halted,
  /// StepResult::halted is set and the rest is of the last good state. Where a reading shows that the last solid is
  /// gone, the plan is made anew, once, which waits for all steps. Errors: invalid_argument as in ready(); internal (a
  /// fault of the device); out_of_memory.
  Result<Reading> take(ReadTicket ticket);

  // Reading back. All synchronise.
  Result<Totals> totals();
  Result<Ledger> ledger();
  Result<ParticleData> particles();
  Result<std::vector<PieceInfo>> pieces();
  Result<LatticeData> lattice();
  /// Hash of the State channels in order of id: equal states give equal hashes on every backend.
  Result<std::uint64_t> state_hash();

  /// State channels only, versioned and checksummed.
  Result<std::vector<std::uint8_t>> snapshot();
  /// Replaces the state by one taken from a World with the same materials and bodies' layout, on any
  /// backend. On error the World is unchanged. Errors: corrupt_data, invalid_argument.
  Status restore(const void* data, std::size_t bytes);

  /// Waits; the samples of every probe, in the order added, since the last call, which are then forgotten. A sub-step that
  /// halted the World has none. step() waits and puts samples aside on the host when 0.25 to 8 MB of them were not asked for.
  /// restore() drops those at or after the time that it goes back to.
  Result<std::vector<ProbeSeries>> take_samples();

  /// Waits; fields at points, as they are now: [point][value], in the order of the fields, which are those of
  /// ProbeDesc::fields. Outside the domain, too. One pass over the particles for all points and fields, on the backend; working
  /// space is kept for the next call. Density and pressure are those of the last sub-step, 0 before the first.
  /// Errors: invalid_argument (names the field), capacity (more than 4,194,304 points), out_of_memory.
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points,
                                     const std::vector<std::string>& fields);
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points,
                                     std::initializer_list<const char*> fields) {
    return sample(points, std::vector<std::string>(fields.begin(), fields.end()));
  }
  /// One field, one value per point: here "velocity" is its magnitude, as "speed" is.
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points, const std::string& field);

  /// Surface of the liquid, of the solids or of one body, as a closed mesh; no vertices where there are no
  /// such particles. Synchronises; changes nothing. Working space is kept for the next call.
  /// Errors: invalid_argument (names the field),
  /// out_of_memory.
  Result<SurfaceMesh> surface(const SurfaceDesc& desc = {});

  // Empty where the host is out of memory.
  Plan plan();
  Scheduler& scheduler();
  Resolved resolved();
  Backend backend() const;
  Precision precision() const;
  double time() const;          ///< of the last enqueued step [s]
  std::uint64_t steps() const;  ///< sub-steps enqueued
  const WorldDesc& desc() const;
  MaterialDesc material(MaterialId id) const;  ///< as given; a null id gives a default

 private:
  friend class WorldAccess;  // cuda_interop.hpp and tests
  explicit World(std::unique_ptr<WorldImpl> impl);
  std::unique_ptr<WorldImpl> impl_;
};

/// What this build can do; for `meltsim info`.
struct BuildInfo {
  std::string version;
  bool cuda = false;                 ///< built in
  std::string cuda_runtime;          ///< version, empty without CUDA
  std::string cuda_driver;           ///< version, empty when there is none
  std::vector<std::string> devices;  ///< usable CUDA devices
  std::string cuda_reason;           ///< why CUDA is not usable, empty when it is
  std::string architectures;         ///< compiled for
  int cpu_threads = 0;
};
MELTSIM_API BuildInfo build_info();

}  // namespace v0
}  // namespace meltsim
