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

enum class ProbeKind {
  point,  ///< averages over the particles within H of a point
  /// The height of the liquid's surface [m] along the line through a point against gravity (y where there is none):
  /// the coordinate along that direction of the highest place below which liquid fills half of the space. NaN where the
  /// line meets no liquid, the upper end of the line where liquid reaches it. The line ends at the faces of a bounded
  /// domain, else 512 spacings above and below the point. Single particles and spray do not count.
  level,
  /// Force on a body or a wall. It is that of the liquid, pressure and friction, images in walls included, and apart from
  /// it that of the bodies and walls that touch it; neither gravity nor what a body's own parts do to each other counts.
  /// 0 where a body has melted.
  force,
  /// Heat [W] into a body, from whatever heats it (liquid, other bodies, its surface, sources, regions), or through a wall
  /// into what is beside it, per second of motion: HeatDesc::time_scale times what its temperatures say. What a body
  /// loses by melting is no heat.
  heat,
  /// Liquid through a disc or a rectangle, towards its normal: the sum over particles within H of its plane, each with the
  /// share of the kernel that the plane cuts. Where a nozzle, a wall or a body is nearer than H to the opening, upstream or
  /// downstream of it, the flux reads low by what is missing there.
  flux
};

/// What is sampled, where and when.
struct ProbeDesc {
  std::string name;  ///< empty = "probe<N>"; unique
  ProbeKind kind = ProbeKind::point;
  /// [m]; inside a bounded domain, but of kind `force`. Of kinds `point` and `level` at least one, of `flux` one: the centre of the opening. Of
  /// `force` at most one: where moments are about; by default a body's centre of mass (in a periodic domain: of its
  /// positions as they are, so that a body astride a periodic face needs a point), or the middle of the wall. Of `heat` none.
  std::vector<Vec3d> points;
  /// Of kinds `force` and `heat`: either a body or a wall.
  BodyId body;
  std::optional<int> wall;  ///< 0 to 5, in the order of DomainDesc::faces
  /// Of kind `flux`: the direction that counts as positive; of any length but 0.
  Vec3d normal{0, 0, 0};
  double radius = 0;  ///< of kind `flux`: of a disc [m]; 0: a rectangle
  /// Of a rectangle: the directions of its sides, at right angles to each other and to the normal, are `along` made
  /// perpendicular to the normal, and normal x along.
  Vec3d along{0, 0, 0};
  double size[2] = {0, 0};  ///< lengths of these sides [m]
  /// Of kind `point`, at least one of "temperature" [degrees Celsius], "pressure" [Pa], "density" [kg/m^3], "speed"
  /// [m/s], "velocity" [m/s, 3 values], "liquid_fraction" [0..1]. Of kind `force`, at least one of "force" [N, 3 values] and "moment" [N m, 3 values], the liquid's, and
  /// "contact_force" and "contact_moment", of what touches it. Of kind `flux`, at least one of "mass_flux" [kg/s] and
  /// "volume_flux" [m^3/s, at rest density]. Each once. Of kinds `level` and `heat`, none.
  /// Pressure, speed and velocity are averages over liquid, the others over all particles; weights are those of the
  /// smoothing kernel. NaN where nothing is within H.
  std::vector<std::string> fields;
  /// A sample is due at from + k every, k = 0, 1, ..., and taken in the sub-step that this time lies in; no more than one
  /// per sub-step. 0: one in every sub-step [s].
  double every = 0;
  double from = 0;          ///< [s]
  double until = infinity;  ///< [s]; the last moment that may be due
};

/// Samples of one probe. A sample is labelled with the middle of its sub-step, [t, t + dt]: there positions, density and
/// pressure belong; velocities and temperatures are those at t. Heat into a body is that of the whole sub-step; through a wall,
/// that at the temperatures of its end.
struct ProbeSeries {
  ProbeId probe;
  std::uint32_t points = 0;    ///< as in its description; 1 of kinds force, heat and flux
  std::uint32_t width = 0;     ///< values per point: sample_columns(fields).size(), or 1 of a level or heat
  std::vector<double> time;    ///< per sample, ascending [s]
  std::vector<double> values;  ///< [sample][point][value], in the order of the fields
};

/// Names of the values that fields take: "velocity" becomes velocity_x, velocity_y, velocity_z, forces and moments likewise,
/// others stay. Unknown names are left out.
MELTSIM_API std::vector<std::string> sample_columns(const std::vector<std::string>& fields);

}  // namespace v0
}  // namespace meltsim
