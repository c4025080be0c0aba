// SPDX-License-Identifier: Apache-2.0
// The scalar field whose level set is the surface of a set of particles, and the filter of its mesh.
//
// Source: the smoothed volume fraction, with the volumes of isolated particles corrected by their own
// sum, Solenthaler & Pajarola (2008), Proc. SCA, p. 211; evaluated around surface particles only, Akinci et
// al. (2012), "Parallel surface reconstruction for particle-based fluids", Comput. Graph. Forum 31:1797;
// ellipsoids instead of balls, Yu & Turk (2013), ACM Trans. Graph. 32:5; smoothing of the mesh without
// shrinking it, Taubin (1995), Proc. SIGGRAPH, p. 351.
//
//   symbol  meaning                                                                      unit
//   H_s     surface_support, support of the kernel W (sph_kernels.hpp)                    m
//   o(x)    share of the surroundings of x not covered by walls (walls.hpp)               -
//   s_j     sum_k V_k W(x_j - x_k) / o(x_j): 1 inside, 0.80 in a plane surface            -
//   g_j     1, more where s_j is less than anywhere in a plane surface                    -
//   G_j     ellipsoid of j: symmetric; 1 for a ball                                       -
//   phi(x)  sum_j V_j g_j det G_j W(|G_j (x - x_j)|) / o(x); inside is phi > level        -
//   phi_s   the same of solids alone                                                      -
//
// The surface of the lattice is a plane half a spacing beyond its last layer: level is phi there (0.492 for balls;
// bumps between the particles are 0.004 dx). g makes the level set of an isolated particle a ball of volume
// dx^3. A curved level set lies H_s^2/(15 R) too far inside because of the spread of the kernel (0.04 dx at
// R = 10 dx); along convex steps of the lattice g compensates this.
// Deviations from Yu & Turk: ellipsoids are never longer than the ball, only flatter, so neighbours within H_s
// suffice. They allow half-axes down to 1/4, here 0.6, and move centres nine tenths of the way to the mean of
// their neighbours, here not at all: flatter ellipsoids and moved centres make the level that fits a plane so
// small that convex bodies come out too large.
#pragma once

#include "meltsim/physics/polar.hpp"
#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// H_s [dx]. Ellipsoids are flat at a surface, so they may be wide along it.
inline constexpr double surface_support(bool anisotropic) { return anisotropic ? 3.0 : 2.5; }
/// Shortest half-axis of an ellipsoid over the longest.
inline constexpr double ellipsoid_least = 0.6;
/// Smallest distance of a vertex from the ends of its edge, as a share of the edge, so that no triangle degenerates.
inline constexpr double edge_margin = 1.0 / 64;
/// phi - level assigned far from the surface, where nodes are a spacing apart.
inline constexpr double far_from_level = 0.3;
// The two steps of Taubin's filter.
inline constexpr double smooth_in = 0.5, smooth_out = -0.53;  ///< share of the inward; of the outward step

/// Sums over the neighbours of a particle from which its ellipsoid follows; weights 1 - (r/H_s)^3 (Yu & Turk,
/// eq. 11).
template <class T>
struct ShapeSums {
  T weight{};                                ///< sum of weights
  Vec3<T> first{};                           ///< weighted sum of offsets [m]
  T xx{}, yy{}, zz{}, xy{}, yz{}, zx{};      ///< weighted sum of their products [m^2]
  MELTSIM_HD void add(const ShapeSums& o) {  ///< adds other sums
    weight += o.weight;
    first += o.first;
    xx += o.xx;
    yy += o.yy;
    zz += o.zz;
    xy += o.xy;
    yz += o.yz;
    zx += o.zx;
  }
};
/// Adds a neighbour; r2: square of its offset [m^2].
template <class T>
MELTSIM_HD void add_neighbour(ShapeSums<T>& s, const SphKernel<T>& k, Vec3<T> offset, T r2) {
  const T q = std::sqrt(r2) * k.inv_support;
  if (!(q < T(1))) return;
  const T w = T(1) - q * q * q;
  s.weight += w;
  s.first += offset * w;
  s.xx += w * offset.x * offset.x;
  s.yy += w * offset.y * offset.y;
  s.zz += w * offset.z * offset.z;
  s.xy += w * offset.x * offset.y;
  s.yz += w * offset.y * offset.z;
  s.zx += w * offset.z * offset.x;
}

/// The anisotropic kernel of a particle: W(|G d|) det G. G is symmetric with eigenvalues >= 1, so the support
/// remains H_s.
template <class T>
struct Ellipsoid {
  T trust{};                                            ///< 0: too few neighbours, a ball; 1: enough
  T xx = T(1), yy = T(1), zz = T(1), xy{}, yz{}, zx{};  ///< entries of G
  T det = T(1);                                         ///< det G
};

/// The sums on the full lattice.
template <class T>
struct FullShape {
  T weight = T(1), spread = T(1);  ///< sum of weights; eigenvalue of C [m^2]
};
/// Constants of the field.
template <class T>
struct SurfaceField {
  SphKernel<T> kernel;  ///< W, of support H_s
  T level{};            ///< phi at the surface [-]
  T self{};             ///< s of an isolated particle [-]
  T few{};              ///< below this s is g > 1: 0.05 less than in a plane surface of the lattice
  T full_sum{};       ///< from this s on a particle is inside: half-way between a plane surface and the layer
                      ///< below
  T gain{};           ///< g - 1 of an isolated particle [-]
  FullShape<T> full;  ///< sums on the full lattice
};

/// C = sum w d d / sum w - m m, m = sum w d / sum w. Half-axes: eigenvalues of C divided by those of a full
/// neighbourhood, limited to ellipsoid_least..1 (Yu & Turk also use eigenvalues, not their roots). With few
/// neighbours it is a ball.
template <class T>
MELTSIM_HD Ellipsoid<T> make_ellipsoid(const ShapeSums<T>& s, const FullShape<T>& full) {
  const T trust = clamp((s.weight / full.weight - T(0.15)) * T(4), T(0), T(1));
  Ellipsoid<T> e;
  if (!(trust > T(0))) return e;
  const T scale = T(1) / s.weight, unit = T(1) / full.spread;
  const Vec3<T> m = s.first * scale;
  T c[3][3], v[3][3];
  c[0][0] = (s.xx * scale - m.x * m.x) * unit;
  c[1][1] = (s.yy * scale - m.y * m.y) * unit;
  c[2][2] = (s.zz * scale - m.z * m.z) * unit;
  c[0][1] = c[1][0] = (s.xy * scale - m.x * m.y) * unit;
  c[1][2] = c[2][1] = (s.yz * scale - m.y * m.z) * unit;
  c[0][2] = c[2][0] = (s.zx * scale - m.z * m.x) * unit;
  jacobi_eigen<3>(c, v);
  T g[3];
  for (int k = 0; k < 3; ++k) {
    const T axis = clamp(c[k][k], static_cast<T>(ellipsoid_least), T(1));
    g[k] = T(1) / (T(1) + trust * (axis - T(1)));
  }
  const auto entry = [&](int i, int j) {
    return g[0] * v[i][0] * v[j][0] + g[1] * v[i][1] * v[j][1] + g[2] * v[i][2] * v[j][2];
  };
  e.xx = entry(0, 0);
  e.yy = entry(1, 1);
  e.zz = entry(2, 2);
  e.xy = entry(0, 1);
  e.yz = entry(1, 2);
  e.zx = entry(2, 0);
  e.det = g[0] * g[1] * g[2];
  e.trust = trust;
  return e;
}

/// |G d|^2 [m^2].
template <class T>
MELTSIM_HD T ellipsoid_distance2(T xx, T yy, T zz, T xy, T yz, T zx, Vec3<T> d) {
  const Vec3<T> q{xx * d.x + xy * d.y + zx * d.z, xy * d.x + yy * d.y + yz * d.z,
                  zx * d.x + yz * d.y + zz * d.z};
  return dot(q, q);
}

/// Sums of a particle `depth` layers below the surface of a half lattice (host, double).
inline ShapeSums<double> half_lattice_shape(double support, double spacing, int depth) {
  const auto k = make_kernel<double>(support, spacing);
  const int n = static_cast<int>(support / spacing) + 1;
  ShapeSums<double> s;
  for (int z = -n; z <= (depth < n ? depth : n); ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const Vec3<double> d{x * spacing, y * spacing, z * spacing};
        add_neighbour(s, k, d, dot(d, d));
      }
  return s;
}
/// Sums on the full lattice (host, double).
inline FullShape<double> lattice_shape(double support, double spacing) {
  const auto s = half_lattice_shape(support, spacing, 99);
  return {s.weight, s.xx / s.weight};
}

/// phi of a half lattice at a height [m] above its last layer, mean over a cell (host, double).
inline double half_lattice_field(double support, double spacing, double height, bool anisotropic) {
  const auto k = make_kernel<double>(support, spacing);
  const auto full = lattice_shape(support, spacing);
  const int n = static_cast<int>(support / spacing) + 1;
  constexpr int samples = 4;
  double sum = 0;
  for (int z = -n; z <= 0; ++z) {
    Ellipsoid<double> e;
    if (anisotropic) e = make_ellipsoid(half_lattice_shape(support, spacing, -z), full);
    const double h = height - z * spacing;
    for (int s = 0; s < samples * samples; ++s) {
      const double ox = (s % samples + 0.5) / samples, oy = (s / samples + 0.5) / samples;
      for (int y = -n; y <= n + 1; ++y)
        for (int x = -n; x <= n + 1; ++x) {
          const Vec3<double> d{(x - ox) * spacing, (y - oy) * spacing, h};
          const double r2 = ellipsoid_distance2(e.xx, e.yy, e.zz, e.xy, e.yz, e.zx, d);
          if (r2 < k.support2) sum += e.det * kernel_value(k, std::sqrt(r2));
        }
    }
  }
  return sum * spacing * spacing * spacing / (samples * samples);
}

/// Makes the constants for a spacing dx [m] (host).
template <class T>
inline SurfaceField<T> make_surface_field(double spacing, bool anisotropic) {
  const double support = surface_support(anisotropic) * spacing;
  const auto k = make_kernel<double>(support, spacing);
  SurfaceField<T> f;
  f.kernel = make_kernel<T>(support, spacing);
  const double level = half_lattice_field(support, spacing, 0.5 * spacing, anisotropic);
  const double ball = spacing * std::cbrt(3 / (4 * 3.14159265358979323846));
  f.level = static_cast<T>(level);
  const auto full = lattice_shape(support, spacing);
  f.full = {static_cast<T>(full.weight), static_cast<T>(full.spread)};
  const double volume = spacing * spacing * spacing;
  const double half = lattice_half_space(support, spacing), face = 1 - half;
  f.few = static_cast<T>(face - 0.05);
  f.full_sum = static_cast<T>(1 - 0.5 * half);
  f.self = static_cast<T>(volume * kernel_value(k, 0.0));
  f.gain = static_cast<T>(level / (volume * kernel_value(k, ball)) - 1);
  return f;
}

/// g [-] of a particle with the sum s.
template <class T>
MELTSIM_HD T surface_gain(const SurfaceField<T>& f, T sum) {
  const T a = clamp((f.few - sum) / (f.few - f.self), T(0), T(1));
  return T(1) + f.gain * (a * a);
}

/// o(x) [-]; outside the box that of the nearest point inside, so that the field continues beyond a wall.
template <class T>
MELTSIM_HD T open_share(const WallBox<T>& walls, const SphKernel<T>& k, Vec3<T> x) {
  return T(1) - wall_cover(walls, k, x);
}

/// Above 0 in liquid beside solids [-]: its own field, phi - phi_s, against the level in what they leave open, as in what walls
/// do. So a level surface meets them level. Inside solids, phi_s > level, it says nothing.
/// Deviation: a film a spacing thick on a solid comes out thinner by some hundredths of a spacing.
template <class T>
MELTSIM_HD T liquid_value(const SurfaceField<T>& f, T phi, T phi_s) {
  return phi - phi_s - f.level * (T(1) - phi_s);
}

/// Place where a field that is `inside` > 0 at one end of an edge and `outside` <= 0 at the other crosses 0, in edge
/// lengths from the first end.
template <class T>
MELTSIM_HD T edge_crossing(T inside, T outside) {
  return inside / (inside - outside);
}

/// x after a step of Taubin's filter towards the mean of its ring [m].
template <class T>
MELTSIM_HD Vec3<T> smoothed(Vec3<T> x, Vec3<T> mean, T share) {
  return x + (mean - x) * share;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
