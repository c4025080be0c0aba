// SPDX-License-Identifier: Apache-2.0
// What a host reads from a World, also while its steps run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "meltsim/desc.hpp"
#include "meltsim/handle.hpp"
#include "meltsim/material.hpp"
#include "meltsim/particle_tag.hpp"
#include "meltsim/probe.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

/// Report on the steps since the last World::synchronize() or World::request().
struct StepResult {
  std::uint64_t steps = 0;        ///< sub-steps completed since the World was created
  double time = 0;                ///< simulated time [s]
  double max_speed = 0;           ///< [m/s], largest since the last call
  double max_density_ratio = 0;   ///< max rho/rho0 of the liquid since the last call
  bool halted = false;            ///< diverged: the World keeps its last good state, further steps do nothing
  std::string halt_reason;        ///< names step, particle, body and stage
  std::uint64_t halt_step = 0;    ///< the sub-step that diverged
  bool courant_exceeded = false;  ///< a particle moved further than 0.4 H in one sub-step
  bool heat_bound_exceeded = false;     ///< heat was exchanged faster than its stages allow; raise max_stages
  bool viscous_bound_exceeded = false;  ///< momentum diffused faster than its stages allow: liquid is crowded
  bool solute_bound_exceeded = false;  ///< a species diffused faster than its sweeps allow: liquid is crowded
  bool modulus_unreachable = false;    ///< a body is softer than its youngs_modulus
  bool body_stiffened = false;         ///< a body is stiffer than described: softer, it would gain energy
  bool cooled_to_zero = false;         ///< a particle that would have cooled below 0 K was held there
  bool level_bared = false;            ///< liquid below the level of a hydrostatic field has a free surface
  /// An emitter stopped, at its max_particles or as a closed domain is full; or of one that recycles or has a level no ids were free for
  /// some of what was to come.
  bool emitter_exhausted = false;
  std::uint64_t removed = 0;  ///< particles that left through open faces so far
  /// Particles that came in below the level of an emitter, or from one that recycles, so far.
  std::uint64_t entered = 0;
  std::uint64_t strayed = 0;  ///< liquid particles that fell out of the scene so far (Stray::remove)
  std::uint64_t melted = 0;   ///< particles that melted so far; a particle that freezes may melt again
  std::uint64_t frozen = 0;   ///< particles that froze so far
  std::uint64_t fluid = 0;    ///< live liquid particles
  std::uint64_t solid = 0;    ///< live solid particles
  /// Why this report is incomplete: synchronize() itself cannot fail, but the host may run out of memory while it makes
  /// the report. Empty: the report is complete.
  std::string error;
};

/// Conserved quantities and extremes, in double. Zero points: potential energy at the origin of coordinates, thermal energy
/// at 0 degrees Celsius, of what can melt as the liquid that it melts into (so at its melting point a solid has c T - L).
struct Totals {
  std::uint64_t fluid = 0, solid = 0, bodies = 0, melted = 0, frozen = 0;  ///< numbers
  double mass = 0;                                                         ///< [kg]
  Vec3d momentum;                                                          ///< [kg m/s]
  Vec3d angular_momentum;                                                  ///< about the origin [kg m^2/s]
  double kinetic = 0, potential = 0, thermal = 0;  ///< [J]; thermal includes latent heat
  /// The part of thermal that is latent heat [J]: m L f, f the liquid fraction, over all particles that can melt and all
  /// liquid that a solid melts into, whether or not that liquid can freeze.
  double latent = 0;
  /// m L of the same particles [J], what latent is where all of it is liquid: latent / latent_max is molten.
  double latent_max = 0;
  double heat_in = 0;  ///< through surfaces and from sources since the World was created [J]
  double field_work =
      0;                ///< of force fields since the World was created: what they gave to kinetic energy [J]
  Vec3d field_impulse;  ///< likewise [N s]
  double temperature_min = 0, temperature_mean = 0, temperature_max = 0;  ///< [degrees Celsius]
  Vec3d solid_center;                                    ///< centre of mass of all solid particles [m]
  double max_speed = 0;                                  ///< [m/s]
  double density_error_mean = 0, density_error_max = 0;  ///< |rho/rho0 - 1| over liquid with rho > rho0
};

/// Conserved quantities at the end of the last sub-step, summed on the device on request: one pass over the particles; a
/// few hundred bytes are copied. Zero points as in Totals. Sums are double; their order, and so their rounding, depends on
/// the backend.
struct Ledger {
  std::uint64_t step = 0;              ///< sub-steps completed
  double time = 0;                     ///< [s]
  std::uint64_t fluid = 0, solid = 0;  ///< numbers of particles
  double mass = 0;                     ///< [kg]
  Vec3d momentum, angular_momentum;    ///< [kg m/s], about the origin [kg m^2/s]
  double kinetic = 0, potential = 0;   ///< [J]
  double thermal = 0, latent = 0;      ///< [J]; thermal includes latent
  double latent_max = 0;               ///< as in Totals [J]
  double heat_in = 0;                  ///< heat that entered since the World was created [J]
  double field_work = 0;               ///< of force fields since the World was created [J]
  Vec3d field_impulse;                 ///< likewise [N s]
  /// Mass of every species, dissolved or not, in the order in which its materials were added [kg].
  std::array<double, most_species> solute{};
  /// The part of `solute` that is dissolved [kg]: all of it but crystals, of which bodies of the species consist, and what liquid
  /// holds beyond saturation of a species that precipitates.
  std::array<double, most_species> dissolved{};
  /// Heat that the dissolved species have taken up (MaterialDesc::heat_of_solution) [J]: thermal and solution together change by
  /// heat_in alone.
  double solution = 0;
  double max_speed = 0;                                  ///< [m/s]
  double density_error_mean = 0, density_error_max = 0;  ///< rho/rho0 - 1 over liquid with rho > rho0
  double courant = 0;                                    ///< (c + max_speed) dt / H of that sub-step
  double sound_speed = 0;                                ///< c of that sub-step [m/s]; 0 before the first
  /// Work on compressed liquid by a sound speed that changes [J] (WorldDesc::follow_sound_speed): kinetic, potential and elastic
  /// energy together change by it, where nothing else drives or damps. About density_error of the potential energy.
  double sound_work = 0;
  /// Liquid particles that teleports of bodies have put elsewhere, and their work against gravity [J]: potential energy changes by
  /// it, momentum by nothing. Of this World, whatever was restored.
  std::uint64_t displaced = 0;
  double displaced_work = 0;  ///< likewise [J]
};

/// Particles copied to the host, sorted by id. Arrays are parallel. From the first step on an id names the same particle
/// until World::compact(); before it, adding a body that displaces liquid renumbers the ids.
struct ParticleData {
  std::vector<std::uint32_t> id;        ///< ascending
  std::vector<Vec3d> position;          ///< [m], world coordinates
  std::vector<Vec3d> velocity;          ///< [m/s]
  std::vector<double> mass;             ///< [kg]
  std::vector<double> temperature;      ///< [degrees Celsius]
  std::vector<double> enthalpy;         ///< [J]
  std::vector<double> liquid_fraction;  ///< 0 solid .. 1 liquid: share of the latent heat taken up
  std::vector<double> density;   ///< [kg/m^3]; of the last sub-step, also if it halted; 0 before the first
  std::vector<double> pressure;  ///< [Pa]; of the same sub-step; 0 for solids
  std::vector<ParticleTag> tag;  ///< material, body and kind (particle_tag.hpp)
  std::vector<std::uint32_t> piece;  ///< label of the connected piece, 0 for liquid
  std::vector<MaterialId>
      species;  ///< materials that dissolve in another, in the order in which they were added
  /// Per species: mass fraction of every particle, 0..1; an array as long as the others. Particles of a dissolving body hold
  /// the liquid that has come in, too.
  std::vector<std::vector<double>> fractions;
};

/// One connected piece of a body. An intact body is one piece.
struct PieceInfo {
  BodyId body;                  ///< the body that it is or was part of
  std::string name;             ///< the body's name; further pieces get ".2", ".3", ...
  std::uint32_t piece = 0;      ///< label
  std::uint64_t particles = 0;  ///< number of its particles
  double mass = 0;              ///< [kg]
  Vec3d center, velocity;       ///< of the centre of mass [m, m/s]
  /// Rotation from the lattice as built to the present, in the axes of the World. Where the positions of the particles
  /// leave it open, such as the twist of a row, the rotations of their regions decide.
  Quat<double> orientation;
  Vec3d angular_velocity;  ///< of the rigid motion with the same angular momentum about the centre [rad/s]
  Mat3<double> inertia;    ///< about the centre, in the axes of the World [kg m^2]
  Box bounds;              ///< of its particles, half a spacing around their centres, to single precision [m]
  double temperature_mean = 0;  ///< weighted by mass [degrees Celsius]
  /// Share of its volume below the level of the liquid; 0 in air. The level at a particle is the mean height of the
  /// liquid's surface in the nearest columns, two spacings wide, in which no solid is near the surface. Columns without
  /// liquid count as dry; where most columns are dry, so is the particle. Up is against gravity, +y without gravity.
  double submerged_fraction = 0;
};

/// A body of a World, as it was described.
struct BodyInfo {
  BodyId body;                   ///< its handle
  std::string name;              ///< SolidDesc::name, or the one that it was given
  MaterialId material;           ///< what it was built of
  Motion motion = Motion::free;  ///< what moves it
  bool held = false;             ///< by World::hold() or SolidDesc::held_until, now
};

/// An impulse and its moment.
struct Impulse {
  Vec3d linear;   ///< [N s]
  Vec3d angular;  ///< [N m s]
};

/// Impulses on a watched body (World::watch_forces), summed over the sub-steps since its last reading. Angular
/// impulses are about its centre of mass, as that moves; of kinematic bodies about the pivot. The sums are of integers, so
/// they do not depend on the order of particles or threads. Gravity is left out.
struct BodyForces {
  BodyId body;         ///< the body
  double seconds = 0;  ///< that they cover [s]; divide by it for a mean force
  Impulse total;       ///< pressure, viscosity and contact; of movable bodies force fields, too
  Impulse pressure;    ///< of liquid, images in walls and surface tension included
  /// Viscous impulse of liquid. For movable bodies it is the rest of the total, so it has what force fields give them, for fixed and kinematic ones that of the velocities at
  /// the beginning of sub-steps, also where viscosity is implicit.
  Impulse viscosity;
  Impulse contact;  ///< of bodies and walls that it touches
  double heat = 0;  ///< that its particles received [J], by conduction, through surfaces and from sources
  /// For a proxy or kinematic body: centre of mass or pivot at the time of the reading [m]; for others the centre of mass in the
  /// middle of the last sub-step.
  Vec3d position;
  Quat<double>
      orientation;  ///< of a proxy or kinematic body, relative to the body as built; of others see PieceInfo
  Vec3d velocity;   ///< of a proxy or kinematic body, likewise [m/s]
  Vec3d angular_velocity;  ///< of a proxy or kinematic body, likewise [rad/s]
};

/// What an event is: World::watch_events.
enum class EventKind : std::uint32_t {
  melted,         ///< a particle of a body became liquid
  frozen,         ///< a liquid particle became part of a body
  split,          ///< a piece came off a body, or off a piece of one
  contact_begun,  ///< a body that can move touches another body or a wall
  contact_ended,  ///< they touch no more
  gone,           ///< nothing solid is left of a body; not of one that World::remove() took out
  left            ///< a particle left the scene: through an open face, or as Stray::remove has it
};
inline constexpr int event_kinds = 7;  ///< kinds there are
/// The bit of a kind in EventWatch::kinds.
constexpr std::uint32_t event_bit(EventKind kind) { return 1u << static_cast<std::uint32_t>(kind); }
inline constexpr std::uint32_t all_events = (1u << event_kinds) - 1u;  ///< every kind
inline constexpr std::uint32_t no_particle = 0xffffffffu;  ///< Event::particle that there is none of

/// Which events a World keeps until the host takes them.
struct EventWatch {
  std::uint32_t capacity =
      4096;  ///< size of the ring, 1 to 1,048,576; 72 bytes each. In a full ring a new event replaces the oldest
  std::uint32_t kinds = all_events;  ///< sum of event_bit() of the kinds to watch
};

/// Something that happened in a sub-step. A resting body touches what it lies on in every sub-step, one that bounces begins and
/// ends a contact with every bounce.
struct Event {
  EventKind kind = EventKind::melted;  ///< what happened
  std::uint64_t step = 0;              ///< the sub-step, from 1
  double time = 0;                     ///< at its end [s]
  Vec3d position;                      ///< of `particle` then [m]
  /// For melted, frozen and left that particle; for contacts the one with the smallest id among those that touch (or did, in the
  /// sub-step before); for split one of the new piece; for gone the last one.
  std::uint32_t particle = no_particle;
  BodyId body;    ///< null: of liquid that left, or of a body that World::compact() has forgotten since
  BodyId other;   ///< of a contact of two bodies the one with the larger index; else null
  int wall = -1;  ///< of a contact with a wall 0 to 5, in the order of DomainDesc::faces; else -1
  std::uint32_t piece = 0;  ///< of split: label of the new piece (PieceInfo::piece); else 0
  std::uint32_t from = 0;   ///< of split: label of what it came off; else 0
};

/// Events in order of their sub-steps; those of one in an order that depends neither on threads nor on the backend: particles by id,
/// pieces by label, contacts by body.
struct Events {
  std::vector<Event> events;                        ///< those that the ring held
  std::uint64_t lost = 0;                           ///< older ones that it had no room for
  std::array<std::uint64_t, event_kinds> counts{};  ///< of every kind, lost ones included
};

/// What World::request() reads, in any combination. StepResult is always read.
struct ReadRequest {
  bool totals = false;     ///< Reading::totals and Reading::ledger
  bool pieces = false;     ///< Reading::pieces
  bool particles = false;  ///< Reading::particles
  bool probes = false;     ///< Reading::probes
  bool forces = false;     ///< Reading::forces, which begin anew with it
  bool events = false;     ///< Reading::events, likewise; World::watch_events() comes first
};

/// Particles in single precision, sorted by id, without removed particles. Arrays are parallel.
struct ParticleFrame {
  Vec3d origin;                        ///< positions are relative to it [m]
  std::vector<std::uint32_t> id;       ///< ascending
  std::vector<Vec3f> position;         ///< [m]
  std::vector<Vec3f> velocity;         ///< [m/s]
  std::vector<float> temperature;      ///< [degrees Celsius]
  std::vector<float> liquid_fraction;  ///< 0 solid .. 1 liquid: share of the latent heat taken up
  std::vector<float> density;          ///< [kg/m^3]; of the last sub-step; 0 before the first
  std::vector<float> pressure;         ///< [Pa]; of the same sub-step; 0 for solids
  std::vector<ParticleTag> tag;        ///< material, body and kind (particle_tag.hpp)
  std::vector<std::uint32_t> piece;    ///< label of the connected piece, 0 for liquid
  std::vector<MaterialId>
      species;  ///< materials that dissolve in another, in the order in which they were added
  std::vector<std::vector<float>> fractions;  ///< per species: mass fraction of every particle, 0..1
};

/// The values that a request asked for, as they were at the request. The rest is empty.
struct Reading {
  std::uint64_t step = 0;             ///< sub-steps completed
  double time = 0;                    ///< [s]
  StepResult result;                  ///< always
  Totals totals;                      ///< ReadRequest::totals
  Ledger ledger;                      ///< ReadRequest::totals
  std::vector<PieceInfo> pieces;      ///< ReadRequest::pieces; at most 65,536
  std::uint64_t pieces_left_out = 0;  ///< number of pieces beyond these
  ParticleFrame particles;            ///< ReadRequest::particles
  std::vector<ProbeSeries> probes;    ///< ReadRequest::probes: samples not taken before
  std::vector<BodyForces>
      forces;     ///< ReadRequest::forces: of watched bodies, in the order in which they were added
  Events events;  ///< ReadRequest::events: since the last reading of them
};

/// Quantity that the colour of a particle follows from: World::render_view.
enum class ColorBy : std::uint32_t { nothing, material, temperature };

/// Colours that World::render_view packs beside the values of particles.
struct RenderDesc {
  ColorBy color = ColorBy::nothing;  ///< nothing: RenderView::color is null
  /// The table, at most 256 colours: red in the lowest byte, then green, blue and opacity. By material an entry per MaterialId::index,
  /// by temperature even steps from `coldest` to `hottest`. Empty: a palette; a ramp from blue over yellow to red.
  std::vector<std::uint32_t> colors;
  double coldest = 0;    ///< [degrees Celsius]
  double hottest = 100;  ///< [degrees Celsius]; above `coldest`
};

/// Identifies an open reading. Tickets are unique within a process; a default one is null.
struct ReadTicket {
  std::uint64_t value = 0;  ///< 0 = null
};

/// Most readings of one World that may be open at a time.
inline constexpr int most_readings = 4;
/// Most points of World::sample() in one call.
inline constexpr std::size_t most_sample_points = std::size_t{1} << 22;
/// Most rays of World::cast_rays() in one call.
inline constexpr std::size_t most_rays = std::size_t{1} << 20;

}  // namespace v0
}  // namespace meltsim
