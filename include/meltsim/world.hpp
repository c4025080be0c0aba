// SPDX-License-Identifier: Apache-2.0
// World owns all buffers of one simulation and runs its steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "meltsim/desc.hpp"
#include "meltsim/export.hpp"
#include "meltsim/probe.hpp"
#include "meltsim/query.hpp"
#include "meltsim/reading.hpp"
#include "meltsim/result.hpp"
#include "meltsim/scheduler.hpp"
#include "meltsim/span.hpp"
#include "meltsim/surface.hpp"

namespace meltsim {
inline namespace v0 {

/// The lattice of all bodies, for inspection and tests: the paper's index arrays, one entry per vertex. Vertices
/// are numbered from 1; 0 = empty.
struct LatticeData {
  /// The particle that the vertex holds or held last; 0xffffffff for a site onto which no liquid has frozen yet.
  std::vector<std::uint32_t> particle_id;
  std::vector<std::uint8_t> live;     ///< 1 if the vertex holds a particle of the body
  std::vector<Vec3i> coordinates;     ///< on the lattice of its body
  std::vector<std::uint32_t> body;    ///< BodyId::index + 1
  std::vector<std::uint32_t> arrayN;  ///< direct neighbours, 27 per vertex, (dx,dy,dz) with dx fastest
  int region_half_width = 0;          ///< w, the largest in the World
  std::vector<std::uint32_t> arrayR;  ///< members of the region, (2w+1)^3 per vertex, in the same order
};

/// Stiffness of the bodies of a material: of the one that has least of a modulus, the shortest so far.
struct Stiffness {
  int region_half_width = 0;  ///< w in use
  double stiffness = 0;       ///< alpha in use
  double youngs_modulus = 0;  ///< E that these deliver at that sub-step [Pa]; 0 while no sub-step is known
};

/// Values that the World derived, among them those for "automatic".
struct Resolved {
  Backend backend = Backend::cpu;                            ///< where the steps run
  std::string backend_reason;                                ///< why there
  std::string device_name;                                   ///< of the GPU or the processor
  NeighbourSearch neighbour_search = NeighbourSearch::grid;  ///< the search in use
  std::string neighbour_reason;                              ///< which form of it, and why
  double support_radius = 0;                                 ///< H [m]
  double sound_speed = 0;                                    ///< c [m/s]; 0 while the World is empty
  double stable_dt = 0;   ///< largest sub-step [s]; infinity when nothing limits it
  int heat_interval = 1;  ///< sub-steps of that length that share a step of heat, HeatDesc::interval
  int heat_stages = 0;  ///< Runge-Kutta-Legendre stages of a super-step of heat at that sub-step; 0: no heat
  int heat_supersteps = 0;  ///< super-steps in that sub-step, at most HeatDesc::max_supersteps
  std::int64_t heat_sweeps =
      0;  ///< heat_stages times heat_supersteps: sweeps over all neighbours for heat in that sub-step
  Viscosity viscosity = Viscosity::explicit_;  ///< how it enters a sub-step: explicit_ or implicit
  double viscous_dt =
      infinity;            ///< largest sub-step that explicit viscosity would allow [s]; infinity without any
  int viscous_stages = 0;  ///< stages of a super-step of implicit viscosity at stable_dt; 0: it is explicit
  int viscous_supersteps = 0;  ///< super-steps in that sub-step: 1 but for more than 64 stages
  int solute_supersteps =
      0;  ///< sweeps per species in that sub-step, at most SoluteDesc::max_supersteps; 0: no species
  /// Share of the specified diffusivity that the heat model delivers at that sub-step, for the best
  /// conductor: 1 for HeatModel::enthalpy; below 1 for HeatModel::paper, the less the longer the step (its
  /// energy drift shows in Totals::thermal).
  double heat_efficiency = 1;
  /// Per material, in the order added: at the last sub-step; before the first sub-step, at stable_dt if finite.
  std::vector<Stiffness> stiffness;
  Vec3d origin;       ///< stored positions are relative to it [m]
  std::string error;  ///< why the scene cannot be prepared (the error of World::prepare()); empty: it can
};

/// Result of a step that may end early.
struct TimedStep {
  double simulated = 0;  ///< by which time() went on [s]
  double owed = 0;       ///< rest of dt, which was not simulated [s]; 0: all of dt was
  std::uint64_t substeps =
      0;  ///< sub-steps taken; World::step_part() with as many repeats the call to the bit
  std::uint64_t planned = 0;  ///< sub-steps that all of dt takes
  double wall_ms = 0;         ///< the call took [ms], with the wait for the device
  double substep_ms = 0;  ///< running mean over the sub-steps of such calls [ms]; 0: none was measured yet
  bool over_budget =
      false;  ///< wall_ms is above what was asked for; with one sub-step: one alone takes longer
};

/// What World::settle() came to.
struct Settled {
  double seconds = 0;          ///< that the liquid was given [s]; 0: there was none that could move
  std::uint64_t substeps = 0;  ///< sub-steps that it took
  double farthest = 0;         ///< way of the particle that was moved farthest [m]
  double fastest = 0;          ///< speed of the fastest at the end, before it was stopped [m/s]
};

/// Particles by id, in single precision, in the memory of the backend: what a renderer draws from. Arrays are parallel, with
/// `count` entries. Ids of removed particles have tag_removed; of their other values nothing is said.
struct RenderView {
  Backend backend = Backend::cpu;          ///< whose memory the pointers are of
  void* stream = nullptr;                  ///< cudaStream_t; null on the CPU
  std::uint64_t count = 0;                 ///< ids so far
  Vec3d origin;                            ///< positions are relative to it [m]
  float radius = 0;                        ///< half a spacing [m]
  const Vec3f* position = nullptr;         ///< [m]
  const Vec3f* velocity = nullptr;         ///< [m/s]
  const float* temperature = nullptr;      ///< [degrees Celsius]
  const float* liquid_fraction = nullptr;  ///< 0 solid .. 1 liquid: share of the latent heat taken up
  const float* density = nullptr;          ///< [kg/m^3]; of the last sub-step; 0 before the first
  const float* pressure = nullptr;         ///< [Pa]; of the same sub-step; 0 for solids
  const ParticleTag* tag = nullptr;        ///< material, body and kind (particle_tag.hpp)
  const std::uint32_t* piece = nullptr;    ///< label of the connected piece, 0 for liquid
  /// Red in the lowest byte, then green, blue, opacity; 0 of removed particles. Null if no colours were asked for.
  const std::uint32_t* color = nullptr;
  std::uint64_t serial = 0;  ///< for World::check_view()
};

/// States of a World that may be saved at a time in the backend's memory.
inline constexpr int most_saved_states = 16;

/// Folds sizes of structs to one number.
constexpr std::uint32_t fold_sizes(std::initializer_list<std::size_t> sizes) {
  std::uint32_t all = 2166136261u;  // FNV-1a's
  for (const std::size_t size : sizes) all = (all ^ static_cast<std::uint32_t>(size)) * 16777619u;
  return all;
}

/// Hash of the sizes of the structs that pass between a host and the library. Compared at World::create, so that a host that was compiled before
/// one of them grew gets an error instead of numbers read from the wrong places; members of one size that swap go unnoticed.
inline constexpr std::uint32_t layout_of_headers = fold_sizes({sizeof(WorldDesc),
                                                               sizeof(MaterialDesc),
                                                               sizeof(FluidDesc),
                                                               sizeof(SolidDesc),
                                                               sizeof(EmitterDesc),
                                                               sizeof(EmitterSetting),
                                                               sizeof(BodyMotion),
                                                               sizeof(ProxyState),
                                                               sizeof(HeatRegionDesc),
                                                               sizeof(ForceFieldDesc),
                                                               sizeof(SurfaceHeatDesc),
                                                               sizeof(ProbeDesc),
                                                               sizeof(ProbeSeries),
                                                               sizeof(SurfaceDesc),
                                                               sizeof(SurfaceMesh),
                                                               sizeof(SurfaceView),
                                                               sizeof(ReadRequest),
                                                               sizeof(Reading),
                                                               sizeof(RenderDesc),
                                                               sizeof(RenderView),
                                                               sizeof(StepResult),
                                                               sizeof(Totals),
                                                               sizeof(Ledger),
                                                               sizeof(ParticleData),
                                                               sizeof(PieceInfo),
                                                               sizeof(BodyForces),
                                                               sizeof(EventWatch),
                                                               sizeof(Event),
                                                               sizeof(Ray),
                                                               sizeof(RayHit),
                                                               sizeof(Overlap),
                                                               sizeof(Plan),
                                                               sizeof(StageContext),
                                                               sizeof(CustomStage),
                                                               sizeof(BodyInfo),
                                                               sizeof(LatticeData),
                                                               sizeof(Resolved),
                                                               sizeof(TimedStep),
                                                               sizeof(Error)});

class WorldImpl;

/// One simulation. Movable, not copyable. Worlds are independent of each other and may live on different
/// threads; calls to one World must come from one thread at a time (interrupt() excepted).
class MELTSIM_API World {
 public:
  /// Makes an empty World. Errors: invalid_argument (names the field), version_mismatch, no_device.
  static Result<World> create(const WorldDesc& desc = {},
                              std::uint32_t header_version = MELTSIM_VERSION_NUMBER,
                              std::uint32_t layout = layout_of_headers);
  World(World&&) noexcept;             ///< the World that was moved from may only be destroyed or assigned to
  World& operator=(World&&) noexcept;  ///< likewise
  ~World();

  // Building, also between steps. All synchronise; on an error (invalid_argument, capacity, out_of_memory) nothing changes, but that a World
  // that runs and is left without memory in the middle of the change halts.
  // Between steps, add_fluid() and add_solid() cost what they add while there is room in reserve (WorldDesc::reserved_particles), and the
  // others take a new plan; without room, the next step uploads the whole scene.
  Result<MaterialId> add_material(const MaterialDesc& desc);  ///< before the liquids and bodies of it
  Result<std::uint64_t> add_fluid(const FluidDesc& desc);     ///< returns the number of particles added
  Result<BodyId> add_solid(const SolidDesc& desc);            ///< samples a body on the lattice
  Result<EmitterId> add_emitter(const EmitterDesc& desc);     ///< begins at EmitterDesc::from
  Result<HeatRegionId> add_heat_region(const HeatRegionDesc& desc);  ///< begins at HeatRegionDesc::from
  /// Adds a force field; at most physics::most_force_fields (16) at a time. The first one makes the next step plan anew, which
  /// synchronises; with one there it waits for nothing. A field that may make particles faster than anything before makes sound faster,
  /// as set_gravity: add it with the largest values that it will have. Errors: invalid_argument (names the field), capacity.
  Result<ForceFieldId> add_force_field(const ForceFieldDesc& desc);
  /// Adds a probe, which changes no particle and no bit of later states. Synchronises. At most 64 probes, 524,288 values per
  /// sample of all probes together, and 4,194,304 heights of level probes (one per half spacing of a line). Errors:
  /// invalid_argument (names the field), capacity, out_of_memory.
  Result<ProbeId> add_probe(const ProbeDesc& desc);

  // Removing, between steps. Bodies and liquid synchronise, and cost what they take out; with species, and ahead of the first step, the
  // next step uploads. Memory is kept. What is removed counts in StepResult::removed. A handle of what was removed is refused.
  /// Removes a body: all that is solid of it. What has melted off it stays, and its name stays taken until compact(). Its handle is then
  /// refused everywhere, also by a second remove(); probes on it read 0. Errors: invalid_argument, out_of_memory.
  Status remove(BodyId body);
  /// Removes a force field, whose handle is then refused. Does not synchronise; without any field left the next step plans anew.
  /// Errors: invalid_argument.
  Status remove(ForceFieldId field);
  /// Removes a heat region, whose name is free again. Costs what adding one does. Errors: invalid_argument.
  Status remove(HeatRegionId region);
  /// Removes a probe, whose name is free again; samples of it that were not taken go with it, those of others stay. Synchronises. Errors:
  /// invalid_argument (also: a reading with samples is open).
  Status remove(ProbeId probe);
  /// Removes the liquid whose particles have their centres in a shape, which does not go on behind periodic faces; returns how many. Errors:
  /// invalid_argument (the shape), out_of_memory.
  Result<std::uint64_t> remove_liquid(const Shape& shape);
  /// Forgets particles that were removed or have left, and bodies that were removed, so that a World in which things come and go for
  /// ever costs what is there. Ids of particles close up, in their order, and labels of pieces with them: returns, per id, the id that it
  /// had. Handles of what is there stay, and so does StepResult::removed. The rows (BodyId::index) and names of forgotten bodies are
  /// free for bodies to come, which get handles of their own, but for rows that a probe is on, or while a reading is open. Memory is kept, as room
  /// for what is to come; the next step uploads; states saved before are lost. A snapshot fits a World to which the same was added, from which the same bodies were
  /// removed, and which compacted in between as this one did. Events and readings of before have the ids and labels of then. What emitters have in reserve stays, and so do
  /// the particles that a body held last while something of it is solid. Synchronises. Errors: halted, out_of_memory.
  Result<std::vector<std::uint32_t>> compact();

  // Steering, between steps. What is set holds from the next step on, on both backends. Unless noted, nothing is uploaded
  // again, no stage is planned anew and nothing waits. On an error nothing changes.
  /// Sets the motion of a kinematic body (SolidDesc::motion). The last one set before a step counts. A motion to another
  /// pose lasts for the next step; afterwards, and without a pose, the body goes on at the velocities given. Liquid and
  /// other bodies see its velocity at every point and give way; its own motion does not change. step() refuses, with
  /// invalid_argument, a motion that would be faster than half the sound speed (only where there is liquid or a free body)
  /// or carry the body through a wall, and forgets it: the body goes on as before. Periodic and open faces may be crossed. A teleport synchronises. Liquid that the body
  /// would bury goes, in this call, to the nearest free places that are reached from there around other bodies
  /// (Ledger::displaced); a teleport is refused where these do not suffice, and onto another body or a nozzle. Errors:
  /// invalid_argument (names the field), out_of_memory.
  Status set_motion(BodyId body, const BodyMotion& motion);
  /// Returns pose and velocities of a kinematic body at time(), all fields set; not of a motion set since the last step.
  /// Does not wait unless the World halted. Errors: invalid_argument.
  Result<BodyMotion> motion(BodyId body);

  /// Moves the mesh of a kinematic body, such as an animated character: its vertices are at `vertices` at the end of the next step
  /// [m], in the order of TriangleMesh::vertices, and go on at `velocities` [m/s] from then on (none given: they stay). Both are
  /// relative to the body as built, where its shape placed the mesh in the World, so that set_motion() moves what update_mesh()
  /// deforms; a body that set_motion() never moved takes them in the World. Triangles stay what they are. Particles inside follow
  /// by fixed weights, by which every affine motion of the mesh is theirs, too (physics/mesh_motion.hpp), at constant velocity
  /// within the step; liquid and other bodies see that velocity. The last call before a step counts. The first call for a body
  /// binds its particles to the mesh, synchronises, and the next step uploads; later ones take time in proportion to its particles
  /// on the host and wait for nothing. step() refuses, with invalid_argument, vertices that make a particle faster than half the
  /// sound speed or carry it through a wall, and forgets them; move them over more steps. Particles that come apart or together stand for the
  /// room that they then have. Errors: invalid_argument (names the field: not kinematic,
  /// not built from one mesh, growth, another number of vertices, not finite), out_of_memory.
  Status update_mesh(BodyId body, const std::vector<Vec3d>& vertices,
                     const std::vector<Vec3d>& velocities = {});

  /// Sets pose and twist of a proxy (Motion::proxy) as the host has them at time(). The last ones set before a step count.
  /// Velocities hold at once; the gap between the host's pose and its own the proxy closes at constant rates within the next
  /// step, none of its points faster than at a tenth of the sound speed. Without a new state it moves on as a rigid body. step() refuses, with invalid_argument, a motion that would be
  /// faster than half the sound speed or a pose beyond a wall, and forgets it; a teleport is checked as by set_motion. Errors:
  /// invalid_argument (names the field).
  Status set_proxy(BodyId body, const ProxyState& state);
  /// Returns pose and twist of a proxy at time(); not of a state set since the last step. Synchronises; Reading::forces has
  /// them without waiting. Errors: invalid_argument.
  Result<ProxyState> proxy(BodyId body);
  /// Begins, or ends, to sum the forces on a body (Reading::forces, take_forces()). Proxies are always watched. Costs a search
  /// over the neighbours of the particles of watched bodies in every sub-step, and nothing where none is watched. A change
  /// synchronises, and the next step uploads. Errors: invalid_argument, out_of_memory.
  Status watch_forces(BodyId body, bool on = true);

  /// Begins to note events (meltsim/reading.hpp), in place of what was watched before. Contacts that there are then are reported
  /// as begun in the next sub-step, also after restore(). Costs a few passes over ids, vertices and pairs of bodies in every
  /// sub-step; no stage and no memory where nothing is watched. Synchronises, and the next step uploads; events that were not taken
  /// are dropped. Errors: invalid_argument (capacity, kinds), capacity (contacts among more than 1,024 bodies; then add_solid()
  /// returns it, too), out_of_memory.
  Status watch_events(const EventWatch& what = {});
  /// Ends that. Without a watch it does nothing. Errors: out_of_memory.
  Status stop_events();

  /// Holds a free or rigid body where it is, as if it were fixed, or lets it go: at rest, or at the velocities of
  /// SolidDesc::held_until, of which this is the other way to end. Part of the state. A change synchronises, the next step uploads, and states
  /// saved before are lost. Errors: invalid_argument, halted, out_of_memory.
  Status hold(BodyId body, bool on = true);
  /// Sets the motion of a free body, all its pieces together, to a velocity of its centre of mass [m/s] and an angular
  /// velocity about that [rad/s]; what it did beside that motion is gone. If it is faster than anything before and than SolidDesc::max_speed, sound is
  /// made faster as by set_gravity: sub-steps become shorter for good, and saved states are lost. Other errors: those of prepare(), halted.
  Status set_velocity(BodyId body, Vec3d velocity, Vec3d angular_velocity = {});
  /// Gives a free body, all its pieces together, an impulse at its centre of mass [N s] and an angular impulse about that
  /// [N m s], at once. The sound speed stays: impulses that make a body faster than a tenth of it compress liquid. A body
  /// that has melted takes none. Other errors: those of prepare(), halted.
  Status apply_impulse(BodyId body, Vec3d impulse, Vec3d angular_impulse = {});
  /// Changes an emitter; part of the state, so snapshots hold it. Layers keep their distance at another speed, and those
  /// that an emitter leaves out while it is off do not count towards max_particles. Waits if it then emits more until its
  /// end than there is room for, and, as set_gravity, if its liquid is faster than anything before. Errors:
  /// invalid_argument (names the field), capacity, out_of_memory, those of prepare(), halted.
  Status set_emitter(EmitterId emitter, const EmitterSetting& setting);

  // Settings, of the World and not of the state: snapshots do not hold them, and restore() leaves them as they are. desc()
  // returns them as they are now.
  /// Changes a material: viscosity, conductivity, flow curve, friction, stiffness, modulus, damping, tension, contact angle,
  /// diffusivity, transfer coefficient. What its particles' masses, volumes and heat mean must stay: density, heat capacity, melting
  /// point, latent heat, solubility, what it becomes or dissolves in, and the points of these; and its name and region_half_width.
  /// The next step plans anew, which synchronises; a sub-step that a GPU has recorded stays where only numbers of materials
  /// differ. Not part of snapshots. Errors: invalid_argument (names the field); nothing changes then.
  Status set_material(MaterialId material, const MaterialDesc& desc);
  /// Sets WorldDesc::gravity [m/s^2]. If it asks for a larger sound speed than any before (not with a WorldDesc::sound_speed), the
  /// next step plans anew, once, which synchronises; start with the largest gravity to avoid it. Level probes measure
  /// against the new direction. Errors: invalid_argument.
  Status set_gravity(Vec3d gravity);
  /// Sets HeatDesc::time_scale, >= 0; 0 stops heat. Where heat flows, a GPU records its sub-step anew. Errors:
  /// invalid_argument (also of a solid more than 4 times as dense as its melt).
  Status set_heat_time_scale(double scale);
  /// Sets the heat of a wall, 0 to 5 in the order of DomainDesc::faces. The next step plans anew, which synchronises, if
  /// heat from outside thereby begins or ends. Errors: invalid_argument (names the field).
  Status set_wall_heat(int face, const SurfaceHeatDesc& heat);
  /// Sets the heat through the free surface of liquids (HeatDesc::free_surface); likewise. Errors: invalid_argument (names
  /// the field).
  Status set_free_surface_heat(const SurfaceHeatDesc& heat);
  /// Sets the heat through the dry surface of a body (SolidDesc::surface) and what is released in it (SolidDesc::heat_source) [W/m^3]. One small
  /// kernel; the next step plans anew, which synchronises, where no body had heat from outside before, or none has any more. Errors: invalid_argument
  /// (names the field).
  Status set_body_heat(BodyId body, const SurfaceHeatDesc& surface, double source = 0);
  /// Sets what a heat region does while it acts: it holds `temperature` [degrees Celsius] or, where that is empty, releases
  /// `source` [W/m^3], which may be 0. Shape and times stay. Errors: invalid_argument (names the field).
  Status set_heat_region(HeatRegionId region, const std::optional<double>& temperature, double source = 0);
  /// Moves a heat region, such as the spot of a laser: from the next step on its shape, as resolved where it was built, lies `displacement`
  /// [m] from there, and goes on at `velocity` [m/s]. It passes walls, and comes in again behind periodic faces. Where it is follows from the time alone,
  /// so that after restore() to a time before it lies where that velocity would have had it then. Later calls for a region are one small kernel; the first one
  /// resolves its shape anew, also beyond the domain, and costs what adding one does. Errors: invalid_argument (names the field), out_of_memory.
  Status move_heat_region(HeatRegionId region, Vec3d displacement, Vec3d velocity = {});
  /// Replaces a force field: place, kind and strength, from the next step on; one small kernel. An empty name keeps the name. Plans
  /// anew as set_gravity where particles may become faster than ever before. Errors: invalid_argument (names the field).
  Status set_force_field(ForceFieldId field, const ForceFieldDesc& desc);
  /// Returns a force field as it is now, its name filled in. Does not wait. Errors: invalid_argument.
  Result<ForceFieldDesc> force_field(ForceFieldId field);

  /// Allocates, uploads and plans for the next step. step() calls it if something was added; call it yourself
  /// to keep the first step free of allocation. Synchronises if something was added. Errors: capacity, out_of_memory.
  Status prepare();

  /// Lets liquid come to rest before the first step, so that forces on what it touches are those of rest from then on. A start at rest
  /// (WorldDesc::hydrostatic_start) does that for liquid alone; beside bodies and below lids it is not in balance, and forces swing for a second.
  /// Meanwhile bodies stay where they are, open faces are walls, emitters, heat and winds rest, other force fields act as they do at the
  /// start, and a drag slows liquid down. What moves or stands on nothing stays where it is. time(), temperatures and velocities are then as before.
  /// `seconds`: how long it is given; automatic derives it from the depth and the speed of sound. Liquid that nothing
  /// holds, such as a column without a dam, flows meanwhile: Settled::farthest says how far. Call it when all that the World starts with is there; it
  /// waits, and takes memory on the host for another state. Views and saved states of before end. Errors: invalid_argument (`seconds`; a World that has
  /// stepped), interrupted (nothing has changed then), halted, those of prepare().
  Result<Settled> settle(double seconds = automatic);

  /// Enqueues dt seconds, divided into equal sub-steps of at most Resolved::stable_dt. dt = 0 does nothing. Steps may vary
  /// in length. It does not allocate, except if the plan changes: a heat region begins or ends, the last emitter has
  /// ended, or a reading showed that stages have nothing left to do. It then synchronises and allocates or frees the
  /// channels that differ; particles stay on the device. Otherwise it waits only if the device is more than about half
  /// a second of work behind (never while the host captures the stream).
  /// Sub-steps are shorter where a kinematic body moves faster than courant H in one of them.
  /// Errors: invalid_argument (dt negative, not finite, above 0 and below 1e-30 s, or too short to move the clock; a motion, see set_motion), step_too_large, halted,
  /// interrupted, and those of prepare().
  Status step(double dt);

  /// Takes the sub-steps of step(dt) one after another until `milliseconds` of wall time are used up, and waits for them. It
  /// stops ahead of a sub-step that would end too late by the measured cost of those before it: a running mean and two
  /// deviations. Sub-steps are as long as those of step(dt), however many are taken, so that a short budget makes the
  /// simulation slower and never less stable. At least one is taken, so that a World goes on whatever the budget;
  /// TimedStep::over_budget then says that one alone takes longer. What is owed is forgotten: a host that is to catch up
  /// adds it to the next dt, however many sub-steps that makes: max_substeps bounds what one call takes, which the budget does here. What is not of sub-steps (prepare(), a change of plan) counts towards the budget, but is
  /// not cut short. Errors: invalid_argument (`milliseconds` not above 0; infinity is allowed; a World whose stream the host
  /// captures), those of step(); an interrupted one counts up to time(), as there.
  Result<TimedStep> step_within(double dt, double milliseconds);

  /// Takes the first `substeps` of the sub-steps of step(dt): all of them if there are no more. It repeats a
  /// step_within(dt, ...) that took as many, on the same backend to the bit, whatever max_substeps. Waits for them. Errors: those of step().
  Result<TimedStep> step_part(double dt, std::uint64_t substeps);

  /// Makes the running step(), or else the next one that is not refused, return ErrorCode::interrupted before its next sub-step; on the CPU
  /// also within a sub-step, which then does not count. The sub-steps before it count, time() is the time reached, and a
  /// further step() continues from there. One call interrupts one step. It may be called from another thread or from a
  /// signal handler while the World exists and is not moved: it sets one atomic flag and does nothing else.
  void interrupt() noexcept;

  /// Waits for all enqueued steps and reports on them. If the host has no memory for the report, only its steps and time
  /// are valid (StepResult::error).
  StepResult synchronize();

  /// Largest dt that keeps sub-steps stable [s]: the least of Resolved::stable_dt, by which step() divides, and of the
  /// limit for the largest speed at the last synchronize(). step() ignores the latter, so that results do not depend
  /// on when a host looks. Infinity if nothing can move. Calls prepare() if something was added; otherwise it does
  /// not wait.
  double stable_dt() const;
  /// The same for a given largest speed [m/s], such as that of a reading, in place of the speed at synchronize().
  double stable_dt(double speed) const;

  // Reading without waiting (meltsim/reading.hpp). While the host captures the World's stream into a CUDA graph, these
  // calls return invalid_argument.
  /// Enqueues a reading behind the steps enqueued so far and does not wait for them. At most `most_readings` may be open.
  /// Like synchronize(), it resets the extremes of StepResult: a reading holds those since the last synchronize() or
  /// request(). The first requests allocate; what was added since the last step is uploaded, as by prepare().
  /// Errors: invalid_argument, capacity, out_of_memory.
  Result<ReadTicket> request(const ReadRequest& what);
  /// Whether take() would return at once. Never waits. Errors: invalid_argument (no open reading of this World has
  /// this ticket).
  Result<bool> ready(ReadTicket ticket);
  /// Waits for that reading, not for steps enqueued after it, and closes the ticket, also on an error. The values are
  /// those at the request, even if the World has since stepped, grown or been restored. If a step before the request
  /// halted, StepResult::halted is set and the values are those of the last good state. If a reading shows that the last
  /// solid is gone, the plan is made anew, once, which synchronises. Errors: invalid_argument as in ready(), internal (a
  /// fault of the device), out_of_memory.
  Result<Reading> take(ReadTicket ticket);

  // Reading back. All synchronise. Errors: out_of_memory, internal; of the first two and pieces() those of request().
  Result<Totals> totals();                  ///< conserved quantities and extremes
  Result<Ledger> ledger();                  ///< conserved quantities, summed on the device
  Result<ParticleData> particles();         ///< all particles, sorted by id; the start before any step
  Result<std::vector<PieceInfo>> pieces();  ///< connected pieces of all bodies
  Result<LatticeData> lattice();            ///< index arrays of all bodies
  /// What acted on every watched body since the last take_forces() or request() of forces.
  Result<std::vector<BodyForces>> take_forces();
  std::uint64_t watched_bodies() const;  ///< the most that take_forces() reports on; does not wait
  /// Events since the last take_events() or request() of events; they need watch_events(). Errors also: invalid_argument.
  Result<Events> take_events();
  /// Hash of the State channels in order of id: equal states give equal hashes on every backend.
  Result<std::uint64_t> state_hash();

  /// Returns the State channels, versioned and checksummed, for restore(). Errors also: halted, where a custom stage wrote what is not finite
  /// behind the check of the sub-step.
  Result<std::vector<std::uint8_t>> snapshot();
  /// Replaces the state by a snapshot of a World with the same materials and layout of bodies (load_saved() brings bodies along), on any backend. On
  /// error the World is unchanged. Settings are the World's, a WorldDesc::sound_speed too; a derived one is at least that of the
  /// snapshot. Synchronises. Errors: corrupt_data, invalid_argument, version_mismatch, out_of_memory.
  Status restore(const void* data, std::size_t bytes);

  /// Returns a snapshot and the bodies that it is of, versioned and checksummed, for load_saved(): a saved game. Synchronises. Errors: those of
  /// snapshot().
  Result<std::vector<std::uint8_t>> save();
  /// Makes the state and the bodies of this World those of a saved World, however bodies came and went in either: on any
  /// backend, with the same spacing, materials, species and emitters, added in the same order. Handles of bodies from before are
  /// refused from then on; bodies() has the new ones. The rest is as of restore(): domain, probes, force fields, heat regions and
  /// settings are the World's. A body that has a mesh takes it along for update_mesh(). On an error the World is unchanged. Synchronises.
  /// Errors: corrupt_data, invalid_argument (a probe is on a body, a reading is open, a World made in another way), capacity (events, as
  /// add_solid()), version_mismatch, out_of_memory.
  Status load_saved(const void* data, std::size_t bytes);
  /// The bodies that are there, those that have melted included and those that were removed not, in the order of BodyId::index. Does not
  /// wait. Errors: out_of_memory.
  Result<std::vector<BodyInfo>> bodies() const;

  // Rolling back: states in the backend's memory, for hosts that repeat steps. They hold what a snapshot holds.
  /// Saves the state behind the steps enqueued under a number from 0 to most_saved_states - 1, in place of what was saved there.
  /// Enqueues copies within the backend's memory and does not wait, but for memory where that is asked for the first time: about as
  /// much as the World's, kept for the next time. If one of those steps halts the World, nothing is saved: after the next
  /// synchronize() load_state() refuses the number; before it the World that the state is loaded into halts and says so. Errors:
  /// invalid_argument (the number), out_of_memory, halted (known to the host), those of prepare().
  Status save_state(int slot);
  /// Goes back to a saved state, to the bit, also of a World that halted since. Does not wait, but for samples of probes and
  /// readings that are open. Probes, settings and forces on bodies are as after restore(), but that forces, events and
  /// contacts go back to what they were. A saved state is lost when something is added or removed, restore() is called, sound is made faster
  /// (set_velocity() beyond SolidDesc::max_speed, a larger gravity, field or speed of an emitter), or the plan changes (heat begins
  /// or ends, the last solid has melted, emitters begin or end): keep a snapshot for that. Errors: invalid_argument (names what is
  /// wrong with the number), out_of_memory.
  Status load_state(int slot);

  /// Returns and forgets the samples of every probe since the last call, in the order of the probes. A sub-step that halted
  /// the World has none. Synchronises. step() synchronises to move samples to the host once 0.25 to 8 MB are pending.
  /// restore() drops samples at or after the restored time.
  Result<std::vector<ProbeSeries>> take_samples();

  /// Returns fields at points [m] of the present state: [point][value], in the order of the fields (ProbeDesc::fields of
  /// ProbeKind::point). Points may lie outside the domain. Synchronises; one pass over the particles for all points and
  /// fields. Density and pressure are those of the last sub-step, 0 before the first.
  /// Errors: invalid_argument (names the field), capacity (more than 4,194,304 points), out_of_memory.
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points,
                                     const std::vector<std::string>& fields);
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points,
                                     std::initializer_list<const char*> fields) {
    return sample(points, std::vector<std::string>(fields.begin(), fields.end()));
  }  ///< the same
  /// The same for one field, with one value per point: here "velocity" is the magnitude of the mean velocity.
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points, const std::string& field);

  /// Where rays first meet what is sought (a sum of ray_liquid, ray_bodies, ray_walls), in the present state; in their order. The surface of
  /// liquid is where half of the space is liquid, that of a body where half is solid, half a spacing outside its outermost
  /// particles: exact on flat faces to a few hundredths of a spacing, edges are rounded by about half a spacing. Rays do not wrap
  /// around periodic axes, and see at least 65,000 spacings far within what there is. Synchronises; on the backend: all particles are sorted by cell,
  /// then every ray is followed in steps of a quarter of a spacing where there are particles. Errors: invalid_argument (names the field;
  /// no ray), capacity (more than 1,048,576 rays), out_of_memory, those of prepare().
  Result<std::vector<RayHit>> cast_rays(const std::vector<Ray>& rays, std::uint32_t sought = ray_all);
  /// Which bodies and how much liquid have particles with centres in a shape, which does not go on behind periodic faces. Synchronises;
  /// copies what is in the shape's box, found by cells on the backend, and asks the shape on the host. Errors: invalid_argument (the shape),
  /// out_of_memory.
  Result<Overlap> overlap(const Shape& shape);

  /// Returns the surface of the liquid, of all solids or of one body as a closed mesh, without vertices if there
  /// are no such particles. Changes no state. Working space is kept for the next call. Synchronises.
  /// Errors: invalid_argument (names the field), capacity,
  /// out_of_memory.
  Result<SurfaceMesh> surface(const SurfaceDesc& desc = {});
  /// The same surface where the backend made it; only its size is brought to the host, or nothing (SurfaceDesc::wait). Its
  /// arrays stay what they are, also while steps are taken, until the next surface(), surface_view(), prepare() after something
  /// was added, or restore(). Errors: as surface().
  Result<SurfaceView> surface_view(const SurfaceDesc& desc = {});

  // Order between the World's stream and the host's other streams, on the device. Neither waits. Of CUDA only: on a CPU nothing is
  // enqueued. Errors: invalid_argument (no event, one of another device, a World on the CPU).
  /// What the World enqueues from now on waits for an event (a cudaEvent_t) that the host has recorded, for example behind its
  /// draw of a surface whose arrays the next surface_view() overwrites.
  Status wait_for(void* event);
  /// Records an event (a cudaEvent_t) behind all that the World has enqueued; a host's stream that waits for it
  /// (cudaStreamWaitEvent) finds the steps, packs and surfaces so far.
  Status signal(void* event);

  // Views of the backend's memory hold as long as what made them says; a pointer cannot tell. These do, in any build, without waiting:
  // call them where your debug build uses a view. Errors: invalid_argument (the view is of another World, or past its time).
  Status check_view(const StageContext& view) const;  ///< of device_state()
  Status check_view(const RenderView& view) const;    ///< of render_view()
  Status check_view(const SurfaceView& view) const;   ///< of surface_view()

  /// Pointers to the particles as the steps enqueued so far leave them, in the backend's memory, in an order of the
  /// backend's; removed ones among them have tag_removed. On CUDA nothing waits: kernels and copies that the host enqueues on
  /// its `stream` run behind those steps and ahead of later ones. A host reads and does not write. They hold until the
  /// next call that is not const. `dt` is 0, `acceleration` null. Of a World that halted it is the last good state once
  /// synchronize() has reported that. Does what prepare() does if something was added. Errors: as prepare().
  Result<StageContext> device_state();
  /// Packs the particles as the steps enqueued so far leave them by id, and returns where. On CUDA nothing waits: what the host
  /// enqueues on its `stream` runs behind that. The arrays stay what they are while steps are taken, until the next
  /// render_view(); a host reads them on that stream, or waits. The first call allocates 48 bytes per particle that there is room
  /// for, with colours 52. Other colours than those of the call before wait once. Of a World that halted as device_state(). Errors:
  /// invalid_argument (names the field), out_of_memory, those of prepare().
  Result<RenderView> render_view(const RenderDesc& desc = {});

  // None of these synchronises, but plan() and resolved() call prepare() if something was added.
  Plan plan();                    ///< stages, channels, memory; empty if the host is out of memory
  Scheduler& scheduler();         ///< custom stages, intervals, timings
  Resolved resolved();            ///< derived values; empty if the host is out of memory
  Backend backend() const;        ///< where the steps run
  Precision precision() const;    ///< of the state
  double time() const;            ///< time after all enqueued steps [s]
  std::uint64_t steps() const;    ///< number of enqueued sub-steps
  const WorldDesc& desc() const;  ///< as passed to create(), but for settings that were changed since
  MaterialDesc material(MaterialId id) const;  ///< as passed to add_material(); a default one for a null id

 private:
  friend class WorldAccess;  // cuda_interop.hpp and tests
  explicit World(std::unique_ptr<WorldImpl> impl);
  std::unique_ptr<WorldImpl> impl_;
};

/// What this build of the library contains and this machine offers.
struct BuildInfo {
  std::string version;               ///< "major.minor.patch"
  bool cuda = false;                 ///< whether the CUDA backend is built in
  std::string cuda_runtime;          ///< version; empty without CUDA
  std::string cuda_driver;           ///< version; empty if there is none
  std::vector<std::string> devices;  ///< names of usable CUDA devices
  std::string cuda_reason;           ///< why CUDA is not usable; empty if it is
  std::string architectures;         ///< CUDA architectures for which there is code
  int cpu_threads = 0;               ///< threads of a World with WorldDesc::threads = 0
};
MELTSIM_API BuildInfo build_info();  ///< looks for usable devices

}  // namespace v0
}  // namespace meltsim
