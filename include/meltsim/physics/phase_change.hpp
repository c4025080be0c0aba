// SPDX-License-Identifier: Apache-2.0
// When a lattice particle becomes liquid, and liquid a lattice particle.
//
// Source: Shao & Yu (2017), sec. 2: a surface boundary particle (SBP, fewer than 27 direct neighbours) that
// reaches its melting point turns liquid; an internal one (IBP) never does, so solids melt from the outside
// in. Deviation: with latent heat the criterion is liquid fraction 1; an IBP may hold more than that and
// leaves as soon as it is exposed. L = 0 reproduces the paper's T >= T_melt. Mass, momentum and enthalpy are
// untouched; the rest volume goes over to m/rho0 of the liquid, smoothly, so that a solid much denser than
// its liquid does not explode.
//
// Freezing is not in the paper. It is melting read backwards: liquid that has given off all of its latent
// heat takes a free site of the lattice it lies next to. Mass, velocity and enthalpy are untouched again; the
// particle's place becomes that of the site, its rest volume dx^3.
//
//   symbol  meaning                                                        unit
//   v, n    a free site, a live direct neighbour of it on the lattice      -
//   q       rest position of v relative to n (lattice)                     m
//   R_n     rotation of the region of n (unity on a fixed body)            -
//   p_n     x_n + R_n q: where n wants v                                   m
//   p       mean of p_n over n                                             m
//
// Deviations from a real solid: it grows by one site a step at each place at most; a particle may be moved by
// up to the capture radius (its momentum is exact, the centre of mass of the whole shifts by m/M of that); a
// lattice holds one particle per site, so what freezes keeps the density of its liquid and does not expand.
#pragma once

#include "meltsim/physics/heat.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

template <class T>
MELTSIM_HD bool melts(const MaterialRow<T>& m, bool surface, double h) {
  return m.melts != 0u && surface && liquid_fraction(m, h) >= 1.0;
}

/// Freezing is the inverse: liquid beside a free site of the lattice that holds no melting enthalpy any more.
/// With L = 0: below the melting point; at exactly that point liquid stays liquid, and a solid melts.
template <class T>
MELTSIM_HD bool freezes(const MaterialRow<T>& m, double h) {
  return m.freezes != 0u && liquid_fraction(m, h) <= 0.0;
}

/// p_n - x_n [m]: where a neighbour wants the site, q [m] on the lattice, of a region turned by R_n.
template <class T>
MELTSIM_HD Vec3<T> site_offset(const Quat<T>& rotation, Vec3<T> q) {
  return to_matrix(rotation) * q;
}

/// Reach of a free site for liquid, in spacings: the radius (3/(4 pi))^(1/3) of the ball of volume dx^3,
/// which holds one particle of liquid at rest density on average. Less leaves holes in what grows; more
/// reaches for what stands at the next site.
inline constexpr double capture_radius = 0.62;
/// Largest distance of a p_n from p, in spacings. Beyond it the neighbours no longer agree where the site is:
/// they belong to pieces that moved apart, or the lattice is strained by a quarter.
inline constexpr double site_agreement = 0.25;
/// Nothing else, liquid or solid, may be nearer to the site than this, in spacings: the new solid particle
/// would throw it out (leak_distance in coupling.hpp). A direct neighbour that agrees never is. Hence the
/// particle within reach is the only one, and there is nothing to choose.
inline constexpr double site_clearance = 1.0 - site_agreement;
/// Smallest distance of a site from the faces of the domain, in spacings: a body resting on a wall has 0.5.
inline constexpr double site_margin = 0.25;

/// Rest volume on its way to m/rho0 [m^3]; share = dt / relaxation time. Once within rounding it is exact.
template <class T>
MELTSIM_HD T relaxed_volume(T volume, T target, T share) {
  const T gap = target - volume;
  if (std::fabs(gap) <= T(1e-5) * target) return target;
  return volume + gap * minimum(share, T(1));
}

/// Relaxation time in units of H/c: a tenfold change of volume then moves the surroundings far below the
/// sound speed.
inline constexpr double volume_relaxation = 40.0;

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
