// SPDX-License-Identifier: Apache-2.0
// Probes: values at points, levels of the liquid, forces, heat and fluxes, sampled inside the sub-steps on the backend.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "meltsim/export.hpp"
#include "meltsim/handle.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
/// What a probe samples.
enum class ProbeKind {
  point,  ///< averages over the particles within H of a point
  /// Height of the liquid's surface [m] along the line through a point against gravity (along y without gravity):
  /// the coordinate, in that direction, of the highest place below which liquid fills half of the space. NaN if the line
  /// meets no liquid; the upper end of the line if liquid reaches it. The line ends at the faces of a bounded domain,
  /// otherwise 512 spacings above and below the point. Single particles and spray do not count.
  level,
  /// Force on a body or a wall: separately that of the liquid (pressure, viscous friction, tension; images in walls included)
  /// and that of the bodies and walls in contact. Gravity and forces between parts of one body do not count. 0 once the
  /// body has melted.
  force,
  /// Heat [W] into a body from all its surroundings (liquid, other bodies, its surface, sources, heat regions), or through
  /// a wall into the particles beside it. Per second of motion: HeatDesc::time_scale times the heat flow of the
  /// temperatures. Enthalpy that leaves a body with melting particles does not count.
  heat,
  /// Flux of liquid through a disc or a rectangle, towards its normal: a sum over the particles within H of its plane,
  /// each weighted by the share of its kernel that the plane cuts. If a nozzle, a wall or a body is closer than H to the
  /// opening, upstream or downstream, the flux reads low by the share that is missing there.
  flux
};

/// A probe: what it samples, where and when.
struct ProbeDesc {
  std::string name;                   ///< empty = "probe<N>"; unique in a World
  ProbeKind kind = ProbeKind::point;  ///< what it samples
  /// [m]. `point`, `level`: one or more; `flux`: one, the centre of the opening; all inside a bounded domain. `force`: at
  /// most one, the reference of moments; default: the centre of mass of the body (of its stored positions, so a body
  /// astride a periodic face needs a point) or the middle of the wall. `heat`: none.
  std::vector<Vec3d> points;
  /// `force` and `heat`: the body, or null and a wall.
  BodyId body;
  std::optional<int> wall;  ///< 0 to 5, in the order of DomainDesc::faces
  /// `flux`: the direction that counts as positive, of any length but 0.
  Vec3d normal{0, 0, 0};
  double radius = 0;  ///< `flux`: radius of a disc [m]; 0: the opening is a rectangle
  /// `flux` through a rectangle: its sides run along the part of `along` perpendicular to the normal, and along
  /// normal x along.
  Vec3d along{0, 0, 0};
  double size[2] = {0, 0};  ///< lengths of these two sides [m]
  /// `point`, one or more of: "temperature" [degrees Celsius], "pressure" [Pa], "density" [kg/m^3], "speed" [m/s],
  /// "velocity" [m/s, 3 values], "liquid_fraction" [0..1], "solute1" to "solute3" (mass fraction of a species [kg/kg], in the order in which their
  /// materials were added). `force`, one or more of: "force" [N, 3 values] and "moment"
  /// [N m, 3 values] of the liquid, "contact_force" and "contact_moment" of bodies and walls in contact. `flux`, one or
  /// more of: "mass_flux" [kg/s], "volume_flux" [m^3/s, at rest density]. Each at most once. `level`, `heat`: none.
  /// Pressure, speed, velocity and mass fractions are averages over liquid, the other values over all particles, weighted by the
  /// smoothing kernel. NaN where no such particle is within H.
  std::vector<std::string> fields;
  /// Interval between samples [s]. A sample is due at from + k every, k = 0, 1, ..., and is taken in the sub-step that
  /// contains this time, at most one per sub-step. 0: one in every sub-step.
  double every = 0;
  double from = 0;          ///< first time that is due [s]
  double until = infinity;  ///< last time that may be due [s]
};

/// Samples of one probe. The time of a sample is the middle of its sub-step [t, t + dt], to which positions, density and
/// pressure belong; velocities and temperatures are those at t. Heat into a body is the mean over the sub-step; heat
/// through a wall follows from the temperatures at its end.
struct ProbeSeries {
  ProbeId probe;             ///< whose samples these are
  std::uint32_t points = 0;  ///< number of points; 1 for kinds force, heat and flux
  std::uint32_t width = 0;   ///< values per point: sample_columns(fields).size(); 1 for kinds level and heat
  std::vector<double> time;  ///< per sample, ascending [s]
  std::vector<double> values;  ///< [sample][point][value], in the order of the fields
};

/// Names of the values of fields, in order: "velocity" becomes velocity_x, velocity_y, velocity_z, forces and moments
/// likewise; other names stay. Unknown names are left out.
MELTSIM_API std::vector<std::string> sample_columns(const std::vector<std::string>& fields);

}  // namespace v0
}  // namespace meltsim
