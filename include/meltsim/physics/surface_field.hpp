// SPDX-License-Identifier: Apache-2.0
// The scalar field whose level set is the surface of a set of particles, and what is done to the mesh of it.
//
// Source: the smoothed volume fraction, with volumes of particles that stand alone corrected by their own
// sum, Solenthaler & Pajarola (2008), Proc. SCA, p. 211; evaluated around surface particles only, Akinci et
// al. (2012), "Parallel surface reconstruction for particle-based fluids", Comput. Graph. Forum 31:1797;
// ellipsoids instead of balls, Yu & Turk (2013), ACM Trans. Graph. 32:5; bumps taken out of the mesh without
// shrinking it, Taubin (1995), Proc. SIGGRAPH, p. 351.
//
//   symbol  meaning                                                                      unit
//   H_s     surface_support dx, support of the kernel W (sph_kernels.hpp)                 m
//   o(x)    share of the surroundings of x that walls leave open (walls.hpp)              -
//   s_j     sum_k V_k W(x_j - x_k) / o(x_j): 1 inside, 0.80 in a plane surface            -
//   g_j     max(1, s_lone / s_j)                                                          -
//   phi(x)  sum_j V_j g_j W(x - x_j) / o(x); inside is phi > level                        -
//
// The lattice's surface is a plane half a spacing beyond its last layer: level is phi there (0.5 without the
// lattice, 0.492 at 2.5 dx; bumps between the particles are 0.004 dx). s_lone makes the level set of a
// particle that stands alone a ball of a spacing's volume; in plane surfaces g is 1 already. A sphere of
// radius R comes out 0.042 dx^2/(R dx)... smaller than it is, because the kernel's spread shifts a curved
// level by H_s^2/(15 R).
#pragma once

#include "meltsim/physics/polar.hpp"
#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// H_s [dx].
inline constexpr double surface_support = 2.5;
/// Particles whose sum is below this are surface particles: 0.80 in a plane surface, 0.998 one layer below.
inline constexpr double surface_particle_sum = 0.93;
/// Below this sum particles count for more: 0.80 in a plane surface of the lattice, 0.64 along a straight edge.
inline constexpr double surface_few = 0.75;
/// Share of an edge that a vertex keeps away from its ends, so that no triangle degenerates.
inline constexpr double edge_margin = 1.0 / 64;
/// The two steps of Taubin's filter: inward, outward.
inline constexpr double smooth_in = 0.5, smooth_out = -0.53;

template <class T>
struct SurfaceField {
  SphKernel<T> kernel;
  T level{};  ///< phi at the surface [-]
  T self{};   ///< s of a particle that stands alone [-]
  T gain{};   ///< g of it, less 1 [-]
};

/// phi of the half lattice at a height above its last layer, mean over a cell (host, double).
inline double half_lattice_field(double support, double spacing, double height) {
  const auto k = make_kernel<double>(support, spacing);
  const int n = static_cast<int>(support / spacing) + 1;
  double sum = 0;
  constexpr int samples = 4;
  for (int s = 0; s < samples * samples; ++s) {
    const double ox = (s % samples + 0.5) / samples, oy = (s / samples + 0.5) / samples;
    for (int z = -n; z <= 0; ++z)
      for (int y = -n; y <= n + 1; ++y)
        for (int x = -n; x <= n + 1; ++x) {
          const double h = height / spacing - z;
          sum += kernel_value(k, spacing * std::sqrt((x - ox) * (x - ox) + (y - oy) * (y - oy) + h * h));
        }
  }
  return sum * spacing * spacing * spacing / (samples * samples);
}

/// For the spacing dx (host).
template <class T>
inline SurfaceField<T> make_surface_field(double spacing) {
  const double support = surface_support * spacing;
  const auto k = make_kernel<double>(support, spacing);
  SurfaceField<T> f;
  f.kernel = make_kernel<T>(support, spacing);
  const double level = half_lattice_field(support, spacing, 0.5 * spacing);
  const double ball = spacing * std::cbrt(3 / (4 * 3.14159265358979323846));
  f.level = static_cast<T>(level);
  const double volume = spacing * spacing * spacing;
  f.self = static_cast<T>(volume * kernel_value(k, 0.0));
  f.gain = static_cast<T>(level / (volume * kernel_value(k, ball)) - 1);
  return f;
}

/// g [-].
template <class T>
MELTSIM_HD T surface_gain(const SurfaceField<T>& f, T sum) {
  const T few = static_cast<T>(surface_few);
  const T a = clamp((few - sum) / (few - f.self), T(0), T(1));
  return T(1) + f.gain * (a * a);
}

/// o(x) [-]; x is taken into the box first, so that the field goes on beyond a wall as it meets it.
template <class T>
MELTSIM_HD T open_share(const WallBox<T>& walls, const SphKernel<T>& k, Vec3<T> x) {
  return T(1) - wall_cover(walls, k, x);
}

/// Where a field that is `inside` > 0 at one end and `outside` <= 0 at the other crosses 0, in edge lengths
/// from the first.
template <class T>
MELTSIM_HD T edge_crossing(T inside, T outside) {
  return inside / (inside - outside);
}

/// A step of Taubin's filter.
template <class T>
MELTSIM_HD Vec3<T> smoothed(Vec3<T> x, Vec3<T> mean, T share) {
  return x + (mean - x) * share;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
