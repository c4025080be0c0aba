// SPDX-License-Identifier: Apache-2.0
// World: owns every buffer of one simulation and runs its steps.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "meltsim/desc.hpp"
#include "meltsim/export.hpp"
#include "meltsim/particle_tag.hpp"
#include "meltsim/result.hpp"
#include "meltsim/scheduler.hpp"
#include "meltsim/span.hpp"
#include "meltsim/surface.hpp"

namespace meltsim {
inline namespace v0 {

/// What happened in the steps since the last synchronize().
struct StepResult {
  std::uint64_t steps = 0;       ///< sub-steps completed since the World was created
  double time = 0;               ///< simulated time [s]
  double max_speed = 0;          ///< [m/s], largest since the last call
  double max_density_ratio = 0;  ///< max rho/rho0 of the liquid since the last call
  bool halted = false;           ///< diverged: the last good state is kept, further steps do nothing
  std::string halt_reason;       ///< names step, particle, body and stage
  std::uint64_t halt_step = 0;
  bool courant_exceeded = false;     ///< something moved further than 0.4 H in one sub-step
  bool heat_bound_exceeded = false;  ///< heat exchange was faster than its stage bound; raise max_stages
  bool modulus_unreachable = false;  ///< a body is softer than its youngs_modulus: dt is too long for it
  bool emitter_exhausted = false;    ///< an emitter reached max_particles
  std::uint64_t removed = 0;         ///< particles that left through open faces so far
  std::uint64_t melted = 0;          ///< particles that melted so far; one that froze again may do so again
  std::uint64_t frozen = 0;          ///< particles that froze so far
  std::uint64_t fluid = 0;           ///< live liquid particles
  std::uint64_t solid = 0;           ///< live solid particles
};

/// Conserved quantities and extremes, in double. Zero points: potential at the origin of coordinates,
/// thermal energy at each solid's melting point (liquids: 0 degrees Celsius).
struct Totals {
  std::uint64_t fluid = 0, solid = 0, bodies = 0, melted = 0, frozen = 0;
  double mass = 0;                                 ///< [kg]
  Vec3d momentum;                                  ///< [kg m/s]
  Vec3d angular_momentum;                          ///< about the origin [kg m^2/s]
  double kinetic = 0, potential = 0, thermal = 0;  ///< [J]; thermal includes latent heat
  double latent = 0;   ///< [J]; the part of thermal that is melting enthalpy taken up
  double heat_in = 0;  ///< [J]; through surfaces and from sources since the World was created
  double temperature_min = 0, temperature_mean = 0, temperature_max = 0;  ///< [degrees Celsius]
  Vec3d solid_center;                                    ///< centre of mass of everything solid [m]
  double max_speed = 0;                                  ///< [m/s]
  double density_error_mean = 0, density_error_max = 0;  ///< |rho/rho0 - 1| over liquid with rho > rho0
};

/// The World's accounts at the end of the last sub-step, added up on the device when asked for: one pass over the
/// particles there, a few hundred bytes copied, no particle. Zero points as in Totals; sums are double, their order is
/// the backend's own.
struct Ledger {
  std::uint64_t step = 0;  ///< sub-steps completed
  double time = 0;         ///< [s]
  std::uint64_t fluid = 0, solid = 0;
  double mass = 0;                    ///< [kg]
  Vec3d momentum, angular_momentum;   ///< [kg m/s], about the origin [kg m^2/s]
  double kinetic = 0, potential = 0;  ///< [J]
  double thermal = 0, latent = 0;     ///< [J]; thermal includes latent
  double heat_in = 0;                 ///< [J] through surfaces and from sources since the World was created
  double max_speed = 0;               ///< [m/s]
  double density_error_mean = 0, density_error_max = 0;  ///< rho/rho0 - 1 over liquid with rho > rho0
  double courant = 0;                                    ///< (c + max_speed) dt / H of that sub-step
};

/// Particles copied to the host, sorted by id. Arrays are parallel.
struct ParticleData {
  std::vector<std::uint32_t> id;
  std::vector<Vec3d> position;          ///< [m], world coordinates
  std::vector<Vec3d> velocity;          ///< [m/s]
  std::vector<double> mass;             ///< [kg]
  std::vector<double> temperature;      ///< [degrees Celsius]
  std::vector<double> enthalpy;         ///< [J]
  std::vector<double> liquid_fraction;  ///< 0 solid .. 1 liquid: latent heat taken up
  std::vector<double> density;   ///< [kg/m^3]; of the last step, also of one that halted; 0 before the first
  std::vector<double> pressure;  ///< [Pa]; likewise, 0 for solids
  std::vector<ParticleTag> tag;
  std::vector<std::uint32_t> piece;  ///< label of the connected piece, 0 for liquid
};

/// One connected piece of a body. An intact body is one piece.
struct PieceInfo {
  BodyId body;
  std::string name;         ///< the body's name; further pieces get ".2", ".3", ...
  std::uint32_t piece = 0;  ///< label
  std::uint64_t particles = 0;
  double mass = 0;
  Vec3d center, velocity;  ///< of the centre of mass
  double temperature_mean = 0;
  double submerged_fraction =
      0;  ///< share of particles whose surroundings are more than half liquid or solid
};

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
  int heat_stages = 0;   ///< Runge-Kutta-Legendre stages at that sub-step; 0 = no heat
  /// Share of the diffusivity asked for that the heat model delivers at that sub-step, for the best
  /// conductor: 1 for enthalpy; below 1 for paper, falling with the step (its energy drift shows in
  /// Totals::thermal).
  double heat_efficiency = 1;
  /// Per material, in the order added: for the last sub-step taken, before the first for stable_dt if finite.
  std::vector<Stiffness> stiffness;
  Vec3d origin;  ///< stored positions are relative to it [m]
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

  /// Allocates, uploads and plans what the next step needs. step() calls it when something was added; call
  /// it yourself to keep the first step free of allocation. Errors: out_of_memory.
  Status prepare();

  /// Enqueues dt seconds, split into equal sub-steps that keep the Courant number. dt = 0 does nothing.
  /// Does not wait and does not allocate, except where a youngs_modulus needs other regions at this length of
  /// sub-step than at the last one. Errors: negative or non-finite dt; step_too_large; halted;
  /// out_of_memory as in prepare().
  Status step(double dt);

  /// Waits for everything enqueued and reports it.
  StepResult synchronize();

  /// Largest dt that step() takes without sub-steps [s], from sound speed, viscosity and the speeds seen at
  /// the last synchronize(); infinity when nothing limits it.
  double stable_dt() const;

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

  /// Uniform samples at points: field is "temperature", "pressure", "density" or "velocity" (magnitude);
  /// SPH average over the particles within H, NaN where there are none.
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points, const std::string& field);

  /// Surface of the liquid, of the solids or of one body, as a closed mesh; no vertices where there are no
  /// such particles. Synchronises; changes nothing. Working space is kept for the next call.
  /// Errors: invalid_argument (names the field),
  /// out_of_memory.
  Result<SurfaceMesh> surface(const SurfaceDesc& desc = {});

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
