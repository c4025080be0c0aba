// SPDX-License-Identifier: Apache-2.0
// Force fields: accelerations that a host gives to particles in a region of space.
//
// Sources: uniform, radial and vortex fields as in the particle systems of Reeves (1983), ACM Trans. Graph. 2:91, and Sims (1990),
// Comput. Graph. 24(4):405. Falling off with distance as gravity of a homogeneous ball does (Newton 1687, Principia, book I,
// prop. 71-73) and as the swirl of a Rankine vortex (Rankine 1858, Manual of Applied Mechanics, art. 633), that is linearly within
// a core. Drag: linear, the law of Stokes (1851), over a sub-step by its exact solution (exponential integrator: Hochbruck &
// Ostermann 2010, Acta Numerica 19:209, sec. 2):
//
//   uniform  a = A                                                          m/s^2
//   radial   a = s f(r) e_r                  e_r away from the point        m/s^2
//   vortex   a = s f(r) n x e_r              r, e_r from the axis           m/s^2
//   drag     a = k (u + w x x - v) m - b (1 - m), m = (1 - exp(-k dt))/(k dt)   m/s^2
//   hydrostatic  a = -g s(d) rho V/M         pi(d) = rho |g| int s dd       m/s^2, Pa
//   f(r)     = r/R for r < R or p = 1, else (r/R)^p                         -
//   s(d)     = d/R within 0 to 1                                            -
//
//   symbol  meaning                                                       unit
//   s       acceleration at the distance R                                m/s^2
//   R       radius of the core; 0 with p = 0: f = 1 at every distance     m
//   p       1, 0, -1 or -2                                                -
//   n       unit vector along the axis through the point                  -
//   u, w    velocity and angular velocity of the wind, about the point    m/s, rad/s
//   x, v    place of the particle from the point, its velocity            m, m/s
//   k       rate at which the difference in velocity decays, 1/tau        1/s
//   b       acceleration by all else; the solution of v' = b + k (u - v)  m/s^2
//   g       gravity                                                       m/s^2
//   d       depth below the level, along gravity                          m
//   rho     density of the liquid whose pressure at rest is pi            kg/m^3
//   V, M    volume and mass of the particle                               m^3, kg
//
// Hydrostatic: pressure counted from that of a liquid at rest, as solvers of stratified and free-surface flow do with p - rho g h (Rusche 2002,
// thesis, Imperial College London). Where liquid fills all that is below the level, the forces of pi are those of Archimedes on every
// particle, liquid and body alike, so nothing but the level of the pressure changes. What it is for: liquid and bodies resist slow motion with a
// friction in proportion to that level (isotropic_pressure.hpp), and sound has to be fast for it.
//
// Deviations: fields are accelerations, the same for light and heavy particles, but for hydrostatic ones. On a particle of liquid, and on a body all of which is in
// the wind, drag is exact for any dt beside an acceleration that stays as it is in a sub-step; what a body's shape does within one comes after it.
#pragma once

#include "meltsim/physics/elementary.hpp"
#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Most force fields of a World at a time.
inline constexpr std::uint32_t most_force_fields = 16;

/// What a force field does.
enum class ForceKind : std::uint32_t { uniform, radial, vortex, drag, hydrostatic };
/// Where it does so.
enum class ForceRegion : std::uint32_t { everywhere, box, sphere, cylinder };

/// One force field, in stored coordinates.
template <class T>
struct ForceField {
  std::uint32_t on{};      ///< 0: an empty row
  ForceKind kind{};        ///< what it does
  ForceRegion region{};    ///< where
  std::uint32_t liquid{};  ///< 1: acts on liquid
  std::uint32_t bodies{};  ///< 1: acts on bodies that can move
  std::int32_t power{};    ///< p
  Vec3<T> center{};        ///< of the region [m]
  Vec3<T> axes[3]{};       ///< unit vectors along its sides; the last one along a cylinder
  Vec3<T> half{};  ///< half its sides; of a sphere x: radius; of a cylinder x: radius, z: half its height [m]
  Vec3<T> about{};   ///< the point [m]
  Vec3<T> axis{};    ///< n
  Vec3<T> vector{};  ///< A [m/s^2] or u [m/s]
  Vec3<T> spin{};    ///< w [rad/s]
  T strength{};      ///< s [m/s^2]
  T radius{};        ///< R [m]
  T rate{};          ///< k [1/s]
  T density{};       ///< rho [kg/m^3]
  double from = 0;   ///< acts in sub-steps that begin at this time or later [s]
  double until = 0;  ///< and before this one [s]
};

/// The fields of a World: the first `count` rows, some of them empty.
template <class T>
struct ForceFields {
  std::uint32_t count{};                 ///< rows that may be in use
  ForceField<T> row[most_force_fields];  ///< the fields
};

/// Whether a place d [m] from the centre of the region is in it. Faces count.
template <class T>
MELTSIM_HD bool in_force_region(const ForceField<T>& f, Vec3<T> d) {
  if (f.region == ForceRegion::everywhere) return true;
  if (f.region == ForceRegion::sphere) return dot(d, d) <= f.half.x * f.half.x;
  const T x = dot(d, f.axes[0]), y = dot(d, f.axes[1]), z = dot(d, f.axes[2]);
  if (!(std::fabs(z) <= f.half.z)) return false;
  if (f.region == ForceRegion::cylinder) return x * x + y * y <= f.half.x * f.half.x;
  return std::fabs(x) <= f.half.x && std::fabs(y) <= f.half.y;
}

/// s f(r)/r, by which a vector of length r is to be multiplied [1/s^2].
template <class T>
MELTSIM_HD T force_falloff(const ForceField<T>& f, T r) {
  if (f.radius > T(0) && (f.power == 1 || r < f.radius)) return f.strength / f.radius;
  if (!(r > T(0))) return T(0);
  T share = T(1) / r;
  for (std::int32_t k = f.power; k < 0; ++k) share *= f.radius / r;
  return f.strength * share;
}

/// (1 - exp(-x))/x, the mean of exp(-x s) for s in 0..1; near 0 as a series, since the difference would cancel.
template <class T>
MELTSIM_HD T mean_decay(T x) {
  const double y = static_cast<double>(x);
  return static_cast<T>(y < 1e-5 ? 1 - y * (0.5 - y / 6) : (1 - exponential(-y)) / y);
}

/// Depth below the level of a hydrostatic field of a place x [m] from its point; negative above, 0 without gravity [m].
template <class T>
MELTSIM_HD T depth_below(Vec3<T> x, Vec3<T> gravity) {
  const T g = length(gravity);
  return g > T(0) ? dot(x, gravity) * (T(1) / g) : T(0);
}

/// phi of liquid below which it has a free surface beside it, and so is not what a hydrostatic field takes it for [-].
inline constexpr double least_filled = 0.85;

/// s(d).
template <class T>
MELTSIM_HD T hydrostatic_share(const ForceField<T>& f, T depth) {
  return clamp(depth / f.radius, T(0), T(1));
}

/// pi(d) [Pa].
template <class T>
MELTSIM_HD T rest_pressure(const ForceField<T>& f, T depth, Vec3<T> gravity) {
  const T share = hydrostatic_share(f, depth);
  return f.density * length(gravity) * share * (depth - T(0.5) * f.radius * share);
}

/// What the acceleration of a particle by a field depends on beside its place.
template <class T>
struct Weighed {
  Vec3<T> gravity{};    ///< g [m/s^2]
  T volume_per_mass{};  ///< V/M [m^3/kg]
};

/// Acceleration by a field, drag excepted, that acts on a particle at x [m] from its point [m/s^2].
template <class T>
MELTSIM_HD Vec3<T> force_field_acceleration(const ForceField<T>& f, Vec3<T> x, const Weighed<T>& particle) {
  switch (f.kind) {
    case ForceKind::hydrostatic:
      return particle.gravity *
             (-hydrostatic_share(f, depth_below(x, particle.gravity)) * f.density * particle.volume_per_mass);
    case ForceKind::radial:
      return x * force_falloff(f, length(x));
    case ForceKind::vortex: {
      const Vec3<T> across = x - f.axis * dot(x, f.axis);
      return cross(f.axis, across) * force_falloff(f, length(across));
    }
    case ForceKind::drag:
      return {};
    default:
      return f.vector;
  }
}

/// The winds that drag a particle: those of several fields act as one, of the sum of their rates.
template <class T>
struct Winds {
  T rate{};        ///< sum of k [1/s]
  Vec3<T> pull{};  ///< sum of k (u + w x x) [m/s^2]
  /// Adds a field that acts on a particle at x [m] from its point; all but drag are none.
  MELTSIM_HD void add(const ForceField<T>& f, Vec3<T> x) {
    if (f.kind != ForceKind::drag) return;
    rate += f.rate;
    pull += (f.vector + cross(f.spin, x)) * f.rate;
  }
};

/// Acceleration by winds in a sub-step of dt on a particle with velocity v that all else accelerates by `other` [m/s^2].
template <class T>
MELTSIM_HD Vec3<T> wind_acceleration(const Winds<T>& w, Vec3<T> v, Vec3<T> other, T dt) {
  if (!(w.rate > T(0))) return {};
  const T mean = mean_decay(w.rate * dt);
  return (w.pull - v * w.rate) * mean - other * (T(1) - mean);
}

/// Impulse and work of the fields: sums over particles.
struct FieldWork {
  double work = 0;                                                        ///< [J]
  Vec3<double> impulse{};                                                 ///< [N s]
  MELTSIM_HD static FieldWork combine(FieldWork a, const FieldWork& b) {  ///< sum of both
    a.work += b.work;
    a.impulse += b.impulse;
    return a;
  }
};

/// Sums of a sub-step: those of its beginning, and the present reduction.
struct FieldAccount {
  FieldWork sum;    ///< of the reduction under way
  FieldWork begun;  ///< of the beginning of the sub-step
};

/// Half of what a field acceleration a does to a particle of mass m in a sub-step: work at the velocity v of its beginning, or of
/// its end. Both halves are the field's part of the change in kinetic energy, (v + v')/2 . m a dt, exactly.
template <class T>
MELTSIM_HD FieldWork half_field_work(T mass, Vec3<T> a, Vec3<T> v, T dt) {
  const double m = 0.5 * static_cast<double>(mass) * static_cast<double>(dt);
  const Vec3<double> force = cast<double>(a) * m;
  return {dot(force, cast<double>(v)), force};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
