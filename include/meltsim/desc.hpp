// SPDX-License-Identifier: Apache-2.0
// Descriptions: plain structs with defaults and units. A default one makes a valid, empty World.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "meltsim/material.hpp"
#include "meltsim/shape.hpp"
#include "meltsim/types.hpp"
#include "meltsim/version.hpp"

namespace meltsim {
inline namespace v0 {

enum class Face {
  wall,     ///< impermeable; holds liquid, bodies rest on it
  open,     ///< particles that leave are removed and counted
  periodic  ///< must be set on both faces of an axis; extent at least 3 support radii
};

/// Heat through a surface. What is set adds up; nothing set insulates. Needs HeatModel::enthalpy.
/// Heat runs HeatDesc::time_scale times faster than motion, and so do these.
struct SurfaceHeatDesc {
  std::optional<double> temperature;  ///< the surface is held at this [degrees Celsius]; excludes the others
  double flux = 0;                    ///< into the material [W/m^2]
  double convection = 0;              ///< Newton's h towards `ambient` [W/(m^2 K)], >= 0
  double emissivity = 0;              ///< radiates towards surroundings at `ambient`, 0..1
  double ambient = 20;                ///< [degrees Celsius]
};

/// Where particles may be. Unbounded by default.
struct DomainDesc {
  bool bounded = false;
  Vec3d min{0, 0, 0};  ///< [m]
  Vec3d max{0, 0, 0};  ///< [m]; at least 2 support radii above min on every walled axis
  /// Faces in the order -x, +x, -y, +y, -z, +z.
  std::array<Face, 6> faces{Face::wall, Face::wall, Face::wall, Face::wall, Face::wall, Face::wall};
  bool no_slip = true;    ///< liquid sticks to walls (viscous traction); false = free slip
  double friction = 0.3;  ///< Coulomb coefficient of bodies against walls, >= 0
  /// Wall velocity per face [m/s], for moving lids; only the tangential part is used.
  std::array<Vec3d, 6> velocity{};
  /// Heat through each wall; every particle within H of it takes part, liquid or solid. Walls only.
  std::array<SurfaceHeatDesc, 6> heat{};
};

enum class HeatModel {
  none,     ///< temperatures stay as given; nothing melts
  paper,    ///< eq. (4) of Shao & Yu 2017: two reversed pair sweeps; not conservative, see docs/design/paper.md
  iwasaki,  ///< explicit exchange of temperatures (Iwasaki et al. 2010), for comparison: unstable beyond
            ///< dt sum K V L = 1, which raises StepResult::heat_bound_exceeded
  enthalpy  ///< conservative enthalpy form with latent heat, Runge-Kutta-Legendre super-time-stepping
};

/// What becomes of liquid that falls out of the scene.
enum class Stray {
  /// In a domain that is not bounded, a liquid particle on which nothing but gravity acts is removed and counted
  /// (StepResult::strayed) when it has fallen until it is faster than the sound speed, ten times as fast as what the
  /// scene was made for. Liquid that any other force makes that fast has diverged, and halts the World.
  remove,
  halt  ///< such a particle halts the World when it crosses its whole neighbourhood in one sub-step
};

struct HeatDesc {
  HeatModel model = HeatModel::enthalpy;
  /// Heat runs this many times faster than motion (time lapse), >= 0; 0 freezes heat.
  double time_scale = 1;
  int max_stages = 64;  ///< Runge-Kutta-Legendre stages per super-step of heat, 2..1024
  /// Super-steps of heat in a sub-step of motion, 1..1000000: a step that needs more is refused. Each takes max_stages
  /// sweeps over all neighbours (Resolved::heat_sweeps), and nothing interrupts a sub-step.
  int max_supersteps = 64;
  /// Temperatures that differ by no more than this [K] count as level, >= 0: then heat stands still, and its stages and
  /// memory go until something is added or a heat region begins. No temperature is off by more, and no more melts than
  /// that heat could have melted. Enthalpy model; asked every 64 sub-steps while no surface, source or emitter is at
  /// work. Differences below a few units in the last place of a temperature never become smaller: in single precision
  /// 1e-4 K at 1000 degrees. 0: only temperatures that are equal when the scene is built count.
  double level_tolerance = 1e-4;
};

/// A World. Zero means "derive it" where a field says automatic.
struct WorldDesc {
  std::uint32_t header_version = MELTSIM_VERSION_NUMBER;  ///< leave as it is
  Backend backend = Backend::automatic;  ///< automatic: CUDA if built in and a device is usable, else CPU
  Precision precision = Precision::single_precision;
  int device = 0;          ///< CUDA device ordinal
  void* stream = nullptr;  ///< a cudaStream_t of the host's; null = a stream of the World's own
  /// CPU threads; 0 = one per processor that the process may use (affinity, control group, OMP_NUM_THREADS). More than
  /// that, and more than 16, are not made, nor more than the system grants; results do not depend on them.
  int threads = 0;

  double spacing = 0.2;       ///< dx [m], > 0
  double support_radius = 0;  ///< H [m], 1.5..6 dx, above 4 is wasteful; automatic = 2.5 dx
  DomainDesc domain;
  Vec3d gravity{0, -9.81, 0};  ///< [m/s^2]
  double sound_speed = 0;  ///< c [m/s]; automatic = 10 sqrt(2 g depth) of what was added; rises when more is
  double artificial_viscosity = 0.05;  ///< Monaghan's alpha, >= 0; noise control, 0.01..0.1
  /// Liquid may pull: pressure below 0. For liquid that fills its domain; at a free surface it makes clumps.
  bool tension = false;
  /// Liquid's particles are moved slightly towards where there are fewer, so that they stay evenly spread in
  /// flows that squeeze them into strings (physics/shifting.hpp). One more sweep over the neighbours. Needs
  /// tension: below a free surface it stirs the liquid. Liquid then moves with its velocity plus the shift:
  /// displacements tell how it flows, ParticleData::velocity has more noise and higher peaks.
  bool particle_shifting = false;
  HeatDesc heat;

  NeighbourSearch neighbour_search = NeighbourSearch::automatic;
  double courant = 0.4;  ///< sub-steps keep c dt / H below this, (0, 0.6]
  Stray stray = Stray::remove;
  int max_substeps = 64;     ///< a step that needs more is refused, >= 1
  int pieces_interval = 16;  ///< steps between searches for pieces that came apart, >= 1
};

/// Liquid filling a shape, on the same lattice as the solids. Points inside bodies are carved away; points nearer to a wall
/// than half a spacing, where the domain is no whole number of spacings wide, are left out: there liquid would be squeezed.
struct FluidDesc {
  Shape shape;
  MaterialId material;
  double temperature = 20;  ///< [degrees Celsius]
  Vec3d velocity;           ///< [m/s]
};

/// A body. Points closer than one spacing to another body are refused; liquid in its place is carved away. Of one that can
/// move, points nearer to a wall than half a spacing are left out, as of liquid.
struct SolidDesc {
  std::string name;  ///< empty = "body<N>"
  Shape shape;
  MaterialId material;
  double temperature = 20;  ///< [degrees Celsius]
  Vec3d velocity;           ///< [m/s]
  Vec3d angular_velocity;   ///< about the centre of mass [rad/s]
  bool fixed = false;       ///< an obstacle: conducts heat and melts, but never moves
  /// Heat through the body's dry surface: where no liquid, wall or other body covers it.
  SurfaceHeatDesc surface;
  double heat_source = 0;  ///< heat released in the body [W/m^3]; negative cools
  bool carve = true;       ///< remove liquid in the body's place; false = refuse the overlap
  /// How far liquid may freeze onto the body: lattice steps around its shape (diagonal ones count as one), 0
  /// or more. 0 = only where it once was solid. Needs a material that freezes. Every site costs memory like a
  /// particle does; sites outside a bounded domain are left out, and growth does not cross a periodic face.
  int growth = 0;
};

/// A part of space, fixed in it, that heats, cools or holds what is inside. Resolved to the spacing. Needs
/// HeatModel::enthalpy.
struct HeatRegionDesc {
  std::string name;  ///< empty = "heat<N>"
  Shape shape;
  std::optional<double>
      temperature;          ///< particles inside are held at this [degrees Celsius]; excludes source
  double source = 0;        ///< heat released [W/m^3]; negative cools
  double from = 0;          ///< [s]
  double until = infinity;  ///< [s]
};

/// A round nozzle that emits liquid at a steady speed: mass rho pi R^2 v per second. It is a pipe about two spacings long
/// in which liquid moves at `speed` along the axis, whatever acts on it, so that weight and viscosity of what has left do
/// not reach back. The first layer takes so long to its end. While a particle enters, its volume grows from nothing, so
/// that a nozzle under water, or under liquid that falls back on it, works as a free one does. What leaves
/// converges, or spreads, as the stream that gravity makes of it does.
struct EmitterDesc {
  std::string name;  ///< empty = "emitter<N>"
  Vec3d center;      ///< where the pipe ends [m]; where walls or bodies leave no room behind, where it begins
  Vec3d axis{0, -1, 0};
  double radius = 0;  ///< [m], at least one spacing
  double speed = 1;   ///< [m/s], > 0
  MaterialId material;
  double temperature = 20;  ///< [degrees Celsius]
  double from = 0;          ///< [s]
  double until = infinity;  ///< [s]
  /// Most particles it may ever emit; it stops there and StepResult says so. 0 = what from..until needs.
  std::uint64_t max_particles = 0;
};

}  // namespace v0
}  // namespace meltsim
