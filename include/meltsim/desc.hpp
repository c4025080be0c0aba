// SPDX-License-Identifier: Apache-2.0
// Descriptions: plain structs with defaults and units. A default one makes a valid, empty World.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "meltsim/material.hpp"
#include "meltsim/shape.hpp"
#include "meltsim/types.hpp"
#include "meltsim/version.hpp"

namespace meltsim {
inline namespace v0 {
/// What a face of the domain does.
enum class Face {
  wall,     ///< impermeable: holds liquid and carries bodies
  open,     ///< particles that leave are removed and counted
  periodic  ///< must be set on both faces of an axis; extent at least 3 support radii. A body that reaches around it goes on there
};

/// Heat through a surface: the sum of the terms that are set; a default one insulates. Needs HeatModel::enthalpy.
/// Like all heat, it runs HeatDesc::time_scale times faster than motion.
struct SurfaceHeatDesc {
  std::optional<double> temperature;  ///< holds the surface at this [degrees Celsius]; alone
  double flux = 0;                    ///< into the surface [W/m^2]
  double convection = 0;              ///< heat transfer coefficient h towards `ambient` [W/(m^2 K)], >= 0
  double emissivity = 0;              ///< of radiation towards surroundings at `ambient`, 0..1
  double ambient = 20;                ///< temperature of the surroundings [degrees Celsius]
  // Ovens, cycles, pulses: values at times [s] that ascend, straight between them, the first one before and the last one after them. At most
  // 65,536 each. Sub-steps begin and end at their times, too, and have the values of their middle.
  std::vector<TimedValue>
      temperature_points;  ///< in place of `temperature` where that is set, else of `ambient` [degrees Celsius]
  std::vector<TimedValue> flux_points;  ///< in place of `flux` [W/m^2]
};

/// What is beyond an open face. Neither is set: nothing, so liquid falls out freely.
struct OutletDesc {
  /// Liquid of the same kind up to this height [m], measured against gravity from the origin: it presses on what leaves as a
  /// column at rest does. Liquid leaves only; an emitter with a level lets it come back, too.
  std::optional<double> level;
  /// Liquid within H of the face moves out of it at this speed [m/s], > 0, whatever forces act on it.
  std::optional<double> speed;
};

/// Where particles may be. Unbounded by default.
struct DomainDesc {
  bool bounded = false;  ///< false: no faces; the fields below then have no effect
  Vec3d min{0, 0, 0};    ///< lower corner [m]
  Vec3d max{0, 0, 0};    ///< upper corner [m]; at least 2 support radii above min on every walled axis
  /// The faces, in the order -x, +x, -y, +y, -z, +z.
  std::array<Face, 6> faces{Face::wall, Face::wall, Face::wall, Face::wall, Face::wall, Face::wall};
  bool no_slip = true;    ///< liquid sticks to walls (viscous traction); false = free slip
  double friction = 0.3;  ///< Coulomb coefficient of walls, >= 0; the smaller of this and the body's holds
  double contact_angle = 90;  ///< of liquids with surface tension at walls [degrees], 0..180
  /// Velocity of each wall [m/s], for moving lids; along the wall. Walls only.
  std::array<Vec3d, 6> velocity{};
  /// Heat through each wall, exchanged with every particle within H of it, liquid or solid. Walls only.
  std::array<SurfaceHeatDesc, 6> heat{};
  /// What is beyond each face. Open faces only; see physics/outlet.hpp.
  std::array<OutletDesc, 6> outlets{};
};
/// How heat is computed.
enum class HeatModel {
  none,   ///< temperatures stay as given; nothing melts
  paper,  ///< eq. (4) of Shao & Yu 2017: two reversed pair sweeps; not conservative, see docs/design/paper.md
  iwasaki,  ///< explicit exchange of temperatures (Iwasaki et al. 2010), for comparison: unstable beyond
            ///< dt sum K V L = 1, which sets StepResult::heat_bound_exceeded
  enthalpy  ///< conservative enthalpy form with latent heat, Runge-Kutta-Legendre super-time-stepping
};

/// What happens to liquid that falls out of the scene.
enum class Stray {
  /// In an unbounded domain, a liquid particle on which only gravity acts is removed and counted
  /// (StepResult::strayed) once its speed exceeds the sound speed, ten times the speed for which the scene was
  /// derived. Liquid that any other force accelerates to that speed has diverged, and halts the World.
  remove,
  halt  ///< such a particle halts the World when it crosses its whole neighbourhood in one sub-step
};
/// Heat of a World.
struct HeatDesc {
  HeatModel model = HeatModel::enthalpy;  ///< how heat is computed
  /// Heat runs this many times faster than motion (time lapse), >= 0; 0 stops heat.
  double time_scale = 1;
  /// Most sub-steps of motion that share one step of heat (and of melting and freezing), 1..1000; within a step() only, at whose
  /// end no heat is owed. 0: up to physics::most_shared_substeps, as far as two stages are enough for them.
  /// Each sub-step has its own while a probe of heat is there.
  int interval = 1;
  /// Runge-Kutta-Legendre stages per super-step of heat, 2..1024. Where something melts or freezes no more than 8 (physics::phase_stages) are
  /// taken, unless max_supersteps asks for more.
  int max_stages = 64;
  /// Most super-steps of heat in a sub-step of motion, 1..1000000; a step that needs more is refused. Each super-step takes
  /// max_stages sweeps over all neighbours (Resolved::heat_sweeps), and a sub-step cannot be interrupted.
  int max_supersteps = 64;
  /// Temperatures that differ by no more than this [K] count as level, >= 0: heat then stops, and its stages and memory
  /// are dropped until something is added or a heat region begins. No temperature is wrong by more than this. For the
  /// enthalpy model; tested every 64 sub-steps while no surface, source or emitter is active. Differences below a few
  /// units in the last place of a temperature never become smaller: in single precision 1e-4 K at 1000 degrees.
  /// 0: temperatures count as level only if they are equal when the scene is built.
  double level_tolerance = 1e-4;
  /// Heat through the free surface of liquids: what no wall, solid or other liquid covers. A layer of liquid thinner than two
  /// spacings counts about one of its sides.
  SurfaceHeatDesc free_surface;
};

/// Species of a World: what is dissolved in liquids, and bodies that dissolve (MaterialDesc::dissolves_in).
struct SoluteDesc {
  double time_scale =
      1;  ///< species diffuse and dissolve this many times faster than motion, >= 0; 0 stops them
  /// Most sweeps over all neighbours per species in a sub-step of motion, 1..1000000; a step that needs more is refused.
  int max_supersteps = 64;
};

/// A World. 0 means that the value is derived where a field says automatic.
struct WorldDesc {
  std::uint32_t header_version = MELTSIM_VERSION_NUMBER;  ///< version of these headers: leave it as it is
  Backend backend = Backend::automatic;  ///< automatic: CUDA if built in and a device is usable, else the CPU
  Precision precision = Precision::single_precision;  ///< of the state
  int device = 0;                                     ///< CUDA device ordinal
  void* stream = nullptr;  ///< the host's cudaStream_t; null: the World makes a stream of its own
  /// CPU threads; 0 = one per processor that the process may use (affinity, control group, OMP_NUM_THREADS). At most
  /// that number, at most 16, and at most what the system grants are started; results do not depend on it.
  /// Worlds on a GPU use them while large scenes are added and uploaded, at no other time.
  int threads = 0;

  double spacing = 0.2;        ///< dx [m], 1e-6..1e4 in single precision, 1e-9..1e9 in double
  double support_radius = 0;   ///< H [m], 1.5..6 dx; costs grow as its cube; automatic = 2.5 dx
  DomainDesc domain;           ///< where particles may be
  Vec3d gravity{0, -9.81, 0};  ///< [m/s^2]
  /// c [m/s]; automatic = 10 sqrt(2 g depth) of what was added, or what density_error says; rises when more is. Below sqrt(2 g depth) what falls
  /// passes through liquid: step() and prepare() refuse that where a bounded domain has a floor, unless the liquid's
  /// viscosity keeps it slower (g depth^2 / (2 nu)).
  double sound_speed = 0;
  double artificial_viscosity = 0.05;  ///< Monaghan's alpha, >= 0: damps acoustic noise; 0.01..0.1
  /// Allows pressures below 0. For liquid that fills its domain; at a free surface liquid would form clumps.
  bool tension = false;
  /// Makes the stress of the pressure isotropic (physics/isotropic_pressure.hpp). Without it liquid resists shear with a stress in
  /// proportion to its pressure, as if it were more viscous: slow flow deep below a surface stands still. Costs a sweep more over the
  /// neighbours. Needs an artificial_viscosity of 0.01 or more. Automatic: on where there are bodies, or liquid meets liquid of another
  /// density, has a yield stress, surface tension or contents, or expands with heat, and is damped enough.
  std::optional<bool> isotropic_pressure;
  /// Moves liquid particles slightly down the gradient of their concentration, so that they stay evenly spread in
  /// flows that would squeeze them into strings (physics/shifting.hpp). Costs one more sweep over the neighbours. Needs
  /// tension, because below a free surface it stirs the liquid. Liquid then moves with its velocity plus the shift:
  /// displacements show the flow, while ParticleData::velocity has more noise and higher peaks.
  bool particle_shifting = false;
  HeatDesc heat;      ///< heat and melting
  SoluteDesc solute;  ///< dissolving and mixing

  NeighbourSearch neighbour_search = NeighbourSearch::automatic;  ///< how neighbours are found
  Viscosity viscosity = Viscosity::automatic;                     ///< how viscosity enters a sub-step
  double courant = 0.4;         ///< sub-steps keep c dt / H at or below this, (0, 0.6]
  Stray stray = Stray::remove;  ///< what happens to liquid that falls out of the scene
  int max_substeps = 64;        ///< a step that needs more is refused, >= 1
  /// What the derived sound speed allows liquid at rest to be compressed by at its lowest place [-], 1e-5..0.1; automatic =
  /// 0.005, c = 10 v_max. Cost goes as its root. Not together with sound_speed.
  double density_error = 0;
  /// The derived sound speed holds for the whole run; true: it follows what moves, down to a quarter of that and up to it, so
  /// that a scene that calms down takes fewer sub-steps (docs/design/steps.md). Compression stays within density_error;
  /// Ledger::sound_work is what the change gave the liquid. Deformable bodies become softer in proportion, so one with a
  /// youngs_modulus that is not molten yet keeps the speed where it is. step() then waits for results, once in 32 sub-steps.
  /// Not together with sound_speed.
  bool follow_sound_speed = false;
  /// Liquid that stands on walls or bodies before the first step starts with the pressure of rest: compressed along gravity by what
  /// is above it (physics/hydrostatic.hpp), so that it does not fall and ring. Particles are then a little lower than they were laid
  /// out. What falls freely has no pressure, nor has what is added while the World runs.
  bool hydrostatic_start = true;
  /// Room for particles, liquid or of bodies, that the host adds while the World runs, beyond those there and those that emitters will
  /// bring: while it lasts, add_fluid() and add_solid() cost what they add, and nothing is uploaded again. Takes memory like theirs.
  std::uint64_t reserved_particles = 0;
  int pieces_interval = 16;  ///< sub-steps between searches for pieces that came apart, >= 1
};

/// Liquid that fills a shape, sampled on the lattice of the World. Points inside bodies are carved away. Where the shape reaches from wall to
/// wall, or across a period, that is no whole number of spacings, cells are longer or shorter so that they fill it, by an eighth at most;
/// mass follows. Other points closer than half a spacing to a wall are dropped: liquid would be squeezed.
struct FluidDesc {
  Shape shape;              ///< the volume [m]
  MaterialId material;      ///< of the liquid
  double temperature = 20;  ///< [degrees Celsius]
  Vec3d velocity;           ///< [m/s]
  std::vector<MassFraction>
      fractions;  ///< what is dissolved in it: species whose solvent `material` is; empty = nothing
};

/// What moves a body.
enum class Motion {
  free,       ///< forces on it
  fixed,      ///< nothing
  kinematic,  ///< the host (World::set_motion), whatever forces act on it; liquid and other bodies give way to it
  /// Forces on it, as a rigid body: six degrees of freedom per connected piece. It costs less than a free body, and stiffness,
  /// damping and region_half_width of its material do not matter.
  rigid,
  /// A rigid body of the host's own physics engine: pose and twist come from there (World::set_proxy), forces on it go
  /// back (World::watch_forces, Reading::forces). In between it moves as a rigid body of SolidDesc::mass and inertia.
  proxy
};

/// Where a proxy is and how it moves, as the host has it: World::set_proxy.
struct ProxyState {
  Vec3d position;            ///< of its centre of mass [m]
  Quat<double> orientation;  ///< relative to the body as built: a unit quaternion
  Vec3d velocity;            ///< of its centre of mass [m/s]
  Vec3d angular_velocity;    ///< [rad/s]
  /// Acceleration by the host's own forces (joints, motors and contacts) beside gravity [m/s^2]: for a body that rests
  /// on a floor of the host's, minus gravity. It acts until the next state.
  Vec3d acceleration;
  /// Puts the body there at once. Otherwise it gets there within the next step, beside its motion, at a tenth of the sound speed
  /// at most: from farther away it takes as many steps, each with its state.
  bool teleport = false;
};

/// How a kinematic body moves: World::set_motion.
struct BodyMotion {
  /// Where its pivot is at the end of the next step [m]; the body moves there at constant velocity. Empty: it moves at
  /// `velocity`.
  std::optional<Vec3d> position;
  /// Its orientation at the end of the next step, relative to the body as built: a unit quaternion. The body turns there by
  /// the shorter way at constant angular velocity. Empty: it turns at `angular_velocity`.
  std::optional<Quat<double>> orientation;
  Vec3d
      velocity;  ///< of the pivot: of what is not given above in the next step, then until the next motion [m/s]
  Vec3d angular_velocity;  ///< about the pivot, likewise [rad/s]
  /// Places the body there at the beginning of the next step instead of moving it, 0.9 spacings or more from other bodies. Liquid
  /// there goes out of its way (World::set_motion).
  bool teleport = false;
};

/// A body. Points closer than one spacing to another body are refused; liquid in its place is carved away. For movable
/// bodies, as for liquid, lattice points closer than half a spacing to a wall are dropped.
struct SolidDesc {
  std::string name;         ///< empty = "body<N>"
  Shape shape;              ///< the volume [m]
  MaterialId material;      ///< of the body
  double temperature = 20;  ///< [degrees Celsius]
  Vec3d velocity;           ///< of the centre of mass [m/s]
  Vec3d angular_velocity;   ///< about the centre of mass [rad/s]
  /// The same as Motion::fixed: an obstacle that conducts heat and melts, but never moves. From wall to wall, or across a period, it fills
  /// what is between as liquid does (FluidDesc), unless something can freeze onto it.
  bool fixed = false;
  /// A free or rigid body stays where it is until the first step that begins at this time or later [s]; it is then let go at
  /// `velocity` and `angular_velocity`. infinity: until World::hold(body, false). 0: it is free from the start.
  double held_until = 0;
  Motion motion =
      Motion::free;  ///< a kinematic body begins with `velocity` and `angular_velocity`, about its pivot
  /// For a kinematic body: the point of the body as built that BodyMotion::position refers to [m]; empty = centre of its
  /// particles.
  /// For a proxy: its centre of mass as built [m], which ProxyState::position refers to; empty likewise.
  std::optional<Vec3d> pivot;
  /// For a kinematic body: where it is at what time, in place of velocities: a ladle that tilts, an animated collider. Times ascend; from one point to the
  /// next it moves in a straight line at constant speed and turns at a constant rate, before the first and after the last it is at rest
  /// (physics/path.hpp); sub-steps begin and end at the points, too. The first point is where it is built: displacement and angle 0. At most
  /// 1,048,576 points. World::set_motion() ends the path for good.
  std::vector<PosePoint> path;
  Vec3d path_axis{0, 0, 1};  ///< axis through the pivot that angles of `path` turn about, of any length but 0
  /// Mass of a proxy [kg], > 0. Its particles have this mass together, whatever the density of its material.
  double mass = 0;
  /// Inertia of a proxy about its centre of mass, in the axes of the World as built [kg m^2]; all 0 = that of the mass spread
  /// evenly over the shape. Symmetric and positive; no principal moment may exceed the sum of the other two.
  Mat3<double> inertia{};
  /// Largest speed that any point of a body will have [m/s]: of a kinematic body or proxy, or what the host will give a free or rigid one
  /// (World::set_velocity). The sound speed is at least ten times as large from the start; motions of kinematic bodies above half the sound
  /// speed are refused.
  double max_speed = 0;
  /// Heat through the dry surface of the body: the part that no liquid, wall or other body covers.
  SurfaceHeatDesc surface;
  double heat_source = 0;  ///< heat released in the body [W/m^3]; negative cools
  bool carve = true;       ///< true: remove liquid in the body's place; false: refuse the overlap
  /// How far liquid may freeze onto the body, in lattice steps around its shape (diagonal steps count as one), >= 0.
  /// 0: only where the body was solid before. Needs a material that freezes, or a species with solubility_points. Every site costs
  /// as much memory as a particle; sites outside a bounded domain are left out, and growth does not cross a periodic face.
  int growth = 0;
};

/// A part of space that heats, cools or holds the temperature of the particles inside. Its shape is resolved to the spacing where it is
/// built, and goes on behind periodic faces. Needs HeatModel::enthalpy.
struct HeatRegionDesc {
  std::string name;                   ///< empty = "heat<N>"
  Shape shape;                        ///< the volume [m]
  std::optional<double> temperature;  ///< holds particles inside at this [degrees Celsius]; excludes source
  double source = 0;                  ///< heat released [W/m^3]; negative cools
  double from = 0;                    ///< begins to act [s]; sub-steps begin and end then, too
  double until = infinity;            ///< ceases to act [s]
  /// Where it is, from where it was built; empty: it stays there. Times ascend; between them it moves in straight lines at constant speed,
  /// before the first and after the last it is at rest (physics/path.hpp). A sub-step, however long, shares `source` out along what is passed in it,
  /// and holds `temperature` in all of that. It passes walls, and comes in again behind periodic
  /// faces. At most 1,048,576 points. World::move_heat_region() puts something else in its place.
  std::vector<PathPoint> path;
};

/// What a force field does to the particles in it; formulas: physics/force_field.hpp.
enum class ForceFieldKind : std::uint8_t {
  uniform,  ///< accelerates by `acceleration`
  radial,   ///< away from `center` by `strength`, or towards it where that is negative
  vortex,   ///< around `axis` through `center` by `strength`, anticlockwise seen against the axis
  drag,     ///< towards the velocity of a wind, at `rate`
  /// Counts pressure below a level from that of a liquid at rest: lifts what is below `center` by the weight of its volume of a liquid of `density`, so that gravity
  /// acts on differences of density alone. For bodies that sink, rise or hover deep in liquid: they move as they should and sound may be slower. All below
  /// the level has to stay full of liquid and bodies (StepResult::level_bared). Pressures and forces are read with that of rest; a stage of the
  /// host sees pressure terms without it. It acts on every body as if liquid were all round it, also where it stands on a wall.
  hydrostatic
};

/// A part of space in which particles are accelerated: a fan, a magnet, a whirl, wind. Acts on liquid and on bodies that can move:
/// rigid bodies and proxies feel force and torque, kinematic, fixed and held bodies nothing, nor does liquid that a nozzle holds. Fields
/// are accelerations: the same for light and heavy particles, but for hydrostatic ones; several add up.
struct ForceFieldDesc {
  std::string name;                               ///< empty = "field<N>"
  ForceFieldKind kind = ForceFieldKind::uniform;  ///< what it does
  /// Where [m]: a box, a sphere or a cylinder, also moved, turned and scaled, with a sharp edge. Empty: everywhere. On periodic axes the
  /// nearest image of its centre counts.
  std::optional<Shape> shape;
  Vec3d acceleration;  ///< A of a uniform field [m/s^2]
  /// The point of a radial field, of a vortex's axis, of the wind's rotation, a point of a hydrostatic level [m]; empty = the centre of the shape,
  /// everywhere (0, 0, 0).
  std::optional<Vec3d> center;
  Vec3d axis{0, 1, 0};  ///< of a vortex, of any length but 0
  double strength = 0;  ///< s of a radial field or a vortex at the distance `radius` [m/s^2]
  /// R of a radial field or a vortex: within it the acceleration grows linearly with the distance [m]. 0, with power 0: it is `strength`
  /// at every distance. Of a hydrostatic field: how far below the level it is whole; 0: a support radius.
  double radius = 0;
  /// p of a radial field or a vortex: beyond `radius` the acceleration goes as the distance to this power: 1 (a spring, a rigid rotation
  /// that speeds up), 0, -1, -2 (gravity).
  int power = 0;
  Vec3d velocity;          ///< of the wind at `center` [m/s]
  Vec3d angular_velocity;  ///< of the wind about `center` [rad/s]
  double rate = 0;     ///< k of drag: what moves on its own takes up the wind's velocity as exp(-k t) [1/s]
  bool liquid = true;  ///< acts on liquid
  bool bodies = true;  ///< acts on bodies that can move
  double density = 0;  ///< of the liquid whose pressure at rest a hydrostatic field takes out [kg/m^3]
  double from = 0;     ///< begins to act [s]; sub-steps begin and end then, too
  double until = infinity;  ///< ceases to act [s]
};

/// A nozzle that emits liquid at a steady speed v, a mass of rho A v per second; its opening A is a disc or a rectangle, such
/// as the upstream end of a channel. The nozzle is a pipe about two
/// spacings long in which liquid moves at `speed` along the axis, whatever forces act on it, so that weight and viscosity
/// of the emitted liquid do not act upstream. The first layer leaves after it has passed the pipe. The volume of a particle
/// grows from nothing while it enters, so a submerged nozzle works like a free one. The emitted liquid starts with
/// the converging or spreading velocity of a stream under gravity.
struct EmitterDesc {
  std::string name;      ///< empty = "emitter<N>"
  Vec3d center;          ///< end of the pipe [m]; its beginning, if walls or bodies leave no room behind
  Vec3d axis{0, -1, 0};  ///< direction of the stream, of any length but 0
  double radius = 0;     ///< R of a round opening [m], at least one spacing
  /// Sides of a rectangular opening [m], at least two spacings each, instead of a radius: `height` along `up`, `width` across.
  double width = 0, height = 0;  ///< the other side
  Vec3d up{0, 1, 0};             ///< which way the height lies; its part along the axis does not count
  double speed = 1;              ///< v [m/s], > 0
  MaterialId material;           ///< of the liquid
  double temperature = 20;       ///< [degrees Celsius]
  double from = 0;               ///< begins to emit [s]
  double until = infinity;       ///< ceases to emit [s]
  /// Most particles that it emits in all; it then stops and sets StepResult::emitter_exhausted, as it does while a domain without
  /// open faces is full (its volume over dx^3 particles). 0: what from..until needs.
  std::uint64_t max_particles = 0;
  /// A nozzle that goes on for ever: particles of it that have left (through an open face, or by remove_liquid()) come again, with their
  /// ids. max_particles is then how many of it there may be at a time, 0: as many as fill the domain; while fewer are free, layers come
  /// with those, and StepResult::emitter_exhausted is set. What froze onto a body does not come again. At most 8 nozzles of a World.
  bool recycle = false;
  std::vector<MassFraction> fractions;  ///< what is dissolved in the liquid, as FluidDesc::fractions
  /// An open face of the domain instead of a nozzle: the one that `axis` points inwards from. Beyond it this liquid stands up to this height
  /// [m], measured against gravity from the origin. It comes in where the level inside is lower, liquid leaves where that is higher, and
  /// long waves leave (physics/inlet.hpp). Then `height` is how far above the floor the level may be set later [m], 0: not beyond this
  /// one; `max_particles` is how many of it may be in the World at a time, 0: as many as fit. Speed and place follow; it acts from
  /// the start, and until set_emitter() turns it off.
  std::optional<double> level;
};

/// Changes to an emitter: World::set_emitter. What is empty stays as it is.
struct EmitterSetting {
  std::optional<bool> on;       ///< false: no further layers come; those in the pipe leave it, or a face
  std::optional<double> speed;  ///< v [m/s], > 0; of the liquid in the pipe, too
  std::optional<double> temperature;  ///< of layers to come [degrees Celsius]
  /// Where the end of the pipe is from the next step on [m]; the liquid in the pipe moves with it at once. The pipe keeps its direction
  /// and has to fit within walls and off other nozzles; keep it clear of bodies, which is not checked.
  std::optional<Vec3d> center;
  std::optional<double> level;  ///< of an emitter that has one, likewise [m]
};

}  // namespace v0
}  // namespace meltsim
