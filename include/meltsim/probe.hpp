// SPDX-License-Identifier: Apache-2.0
// Probes: values at points and levels of the liquid, sampled inside the sub-steps on the backend.
#pragma once

#include <cstdint>
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
  level
};

/// What is sampled, where and when.
struct ProbeDesc {
  std::string name;  ///< empty = "probe<N>"; unique
  ProbeKind kind = ProbeKind::point;
  /// [m]; at least one, inside a bounded domain.
  std::vector<Vec3d> points;
  /// Of kind `point`, at least one of "temperature" [degrees Celsius], "pressure" [Pa], "density" [kg/m^3], "speed"
  /// [m/s], "velocity" [m/s, 3 values], "liquid_fraction" [0..1]; each once. Of kind `level`, none.
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
/// pressure belong; velocities and temperatures are those at t.
struct ProbeSeries {
  ProbeId probe;
  std::uint32_t points = 0;    ///< as in its description
  std::uint32_t width = 0;     ///< values per point: sample_columns(fields).size(), or 1 of a level
  std::vector<double> time;    ///< per sample, ascending [s]
  std::vector<double> values;  ///< [sample][point][value], in the order of the fields
};

/// Names of the values that fields take: "velocity" becomes velocity_x, velocity_y, velocity_z, others stay. Unknown
/// names are left out.
MELTSIM_API std::vector<std::string> sample_columns(const std::vector<std::string>& fields);

}  // namespace v0
}  // namespace meltsim
