// SPDX-License-Identifier: Apache-2.0
// What a World can be asked for, and readings that are taken while it goes on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meltsim/handle.hpp"
#include "meltsim/particle_tag.hpp"
#include "meltsim/probe.hpp"
#include "meltsim/types.hpp"

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
  bool modulus_unreachable = false;  ///< a body is softer than its youngs_modulus
  bool body_stiffened = false;     ///< a body is stiffer than asked for: a softer one gains energy in liquid
  bool cooled_to_zero = false;     ///< what was to be cooled below 0 K was held there
  bool emitter_exhausted = false;  ///< an emitter reached max_particles
  std::uint64_t removed = 0;       ///< particles that left through open faces so far
  std::uint64_t strayed = 0;       ///< liquid particles that fell out of the scene so far (Stray::remove)
  std::uint64_t melted = 0;        ///< particles that melted so far; one that froze again may do so again
  std::uint64_t frozen = 0;        ///< particles that froze so far
  std::uint64_t fluid = 0;         ///< live liquid particles
  std::uint64_t solid = 0;         ///< live solid particles
  /// Why this report is not complete: synchronize() itself cannot fail, but memory may run out while it puts together
  /// what there is to say. Empty: it is complete.
  std::string error;
};

/// Conserved quantities and extremes, in double. Zero points: potential at the origin of coordinates,
/// thermal energy at each solid's melting point (liquids: 0 degrees Celsius).
struct Totals {
  std::uint64_t fluid = 0, solid = 0, bodies = 0, melted = 0, frozen = 0;
  double mass = 0;                                 ///< [kg]
  Vec3d momentum;                                  ///< [kg m/s]
  Vec3d angular_momentum;                          ///< about the origin [kg m^2/s]
  double kinetic = 0, potential = 0, thermal = 0;  ///< [J]; thermal includes latent heat
  /// [J]; the part of thermal that is latent heat: m L f of everything that can melt and of every liquid that something
  /// melts into, f the liquid fraction; whether the liquid can freeze makes no difference.
  double latent = 0;
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

/// Particles copied to the host, sorted by id. Arrays are parallel. An id names the same particle for good from the first
/// step on; before it, a body that displaces liquid closes the gaps in the ids.
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
  Vec3d center, velocity;  ///< of the centre of mass [m], [m/s]
  /// Rotation from the lattice as it was built, axes along those of the World. What the particles do not show, such as
  /// the twist of a row, is as their regions have it.
  Quat<double> orientation;
  Vec3d angular_velocity;  ///< of the rigid motion with the piece's angular momentum about its centre [1/s]
  Mat3<double> inertia;    ///< about the centre, along the axes of the World [kg m^2]
  Box bounds;              ///< of its particles, half a spacing around their centres, to single precision [m]
  double temperature_mean = 0;  ///< by mass [degrees Celsius]
  /// Share of its volume below the liquid's level: 0 where nothing but air surrounds it. The level at a particle is the
  /// mean height of the liquid's surface in the nearest columns, two spacings wide, that no solid stands in near the
  /// surface; columns without liquid count as dry, and where most are the particle is. Up is against gravity, +y without.
  double submerged_fraction = 0;
};

/// What World::request() reads. Any combination; StepResult is always read.
struct ReadRequest {
  bool totals = false;     ///< Reading::totals and Reading::ledger
  bool pieces = false;     ///< Reading::pieces
  bool particles = false;  ///< Reading::particles
  bool probes = false;     ///< Reading::probes
};

/// Particles in single precision, in order of id; removed ones are left out. Arrays are parallel.
struct ParticleFrame {
  Vec3d origin;  ///< positions are relative to it [m]
  std::vector<std::uint32_t> id;
  std::vector<Vec3f> position;         ///< [m]
  std::vector<Vec3f> velocity;         ///< [m/s]
  std::vector<float> temperature;      ///< [degrees Celsius]
  std::vector<float> liquid_fraction;  ///< 0 solid .. 1 liquid: latent heat taken up
  std::vector<float> density;          ///< [kg/m^3]; of the last step; 0 before the first
  std::vector<float> pressure;         ///< [Pa]; likewise, 0 for solids
  std::vector<ParticleTag> tag;
  std::vector<std::uint32_t> piece;  ///< label of the connected piece, 0 for liquid
};

/// What was asked for, as it was when it was asked for. What was not asked for is empty.
struct Reading {
  std::uint64_t step = 0;  ///< sub-steps completed
  double time = 0;         ///< [s]
  StepResult result;
  Totals totals;
  Ledger ledger;
  std::vector<PieceInfo> pieces;
  std::uint64_t pieces_left_out = 0;  ///< of more than 65,536
  ParticleFrame particles;
  std::vector<ProbeSeries> probes;  ///< samples not taken before, as World::take_samples() gives them
};

/// Names an open reading. The null ticket names none; no two readings of a process have the same.
struct ReadTicket {
  std::uint64_t value = 0;  ///< 0 = null
};

/// Readings of one World that may be open at a time.
inline constexpr int most_readings = 4;

}  // namespace v0
}  // namespace meltsim
