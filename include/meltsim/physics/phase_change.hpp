// SPDX-License-Identifier: Apache-2.0
// Conditions under which a lattice particle melts and liquid joins a lattice.
//
// Source: Shao & Yu (2017), sec. 2: a surface boundary particle (SBP, fewer than 27 direct neighbours) that
// reaches its melting point turns liquid; an internal one (IBP) never does, so solids melt from the outside
// in. Deviation: with latent heat the criterion is liquid fraction 1; an IBP may hold more heat than that and
// melts as soon as it is exposed. L = 0 reproduces the paper's T >= T_melt. Mass, momentum and enthalpy are
// unchanged; the rest volume relaxes to m/rho0 of the liquid, so that a solid much denser than its liquid
// does not expand abruptly. Where it is crushed, as between a hot blade and what that cuts, it begins with a part of its volume.
//
// Freezing is not in the paper. It is the inverse of melting: liquid that has released all of its latent heat
// joins a free site of an adjacent lattice. Mass, velocity and enthalpy are unchanged; the particle is drawn
// to the site, slowly, so that the liquid around it makes room, and its rest volume becomes dx^3.
//
//   symbol  meaning                                                        unit
//   v, n    a free site, a live direct neighbour of it on the lattice      -
//   q       rest position of v relative to n (lattice)                     m
//   R_n     rotation of the region of n (unity on a fixed body)            -
//   p_n     x_n + R_n q: place of v according to n                         m
//   p       mean of p_n over n                                             m
//   s       share of its way to p that a particle is drawn in a sub-step   -
//
// Deviations from a real solid: at each place it grows by at most one site per step, and by one in up to 52
// acoustic steps where liquid is off its sites; a particle is moved by up to the capture radius (momentum is exact,
// the centre of mass of the scene shifts by m/M of that); a lattice holds one particle per site, so frozen liquid
// keeps its density and does not expand.
#pragma once

#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/heat.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {
/// Whether a particle melts: at the surface of its body (SBP), with all of its latent heat; h [J/kg].
template <class T>
MELTSIM_HD bool melts(const MaterialRow<T>& m, bool surface, double h) {
  return m.melts != 0u && surface && liquid_fraction(m, h) >= 1.0;
}

/// Whether liquid beside a free site freezes: it holds no latent heat any more; h [J/kg]. With L = 0: below the
/// melting point; at exactly that point liquid stays liquid, and a solid melts.
template <class T>
MELTSIM_HD bool freezes(const MaterialRow<T>& m, double h) {
  return m.freezes != 0u && liquid_fraction(m, h) <= 0.0;
}

/// p_n - x_n [m]: place of the site relative to a neighbour, from q [m] on the lattice and the rotation R_n.
template <class T>
MELTSIM_HD Vec3<T> site_offset(const Quat<T>& rotation, Vec3<T> q) {
  return to_matrix(rotation) * q;
}

/// Distance, in spacings, up to which a free site captures liquid: the radius (3/(4 pi))^(1/3) of a ball of volume
/// dx^3, which holds one liquid particle at rest density on average. A smaller radius leaves holes in the body, a larger
/// one captures particles of the next site.
inline constexpr double capture_radius = 0.62;
/// Largest distance of a p_n from p, in spacings. Beyond it the neighbours disagree on the place of the site:
/// they belong to pieces that moved apart, or the lattice is strained by a quarter.
inline constexpr double site_agreement = 0.25;
/// Smallest distance of any other particle from the site, in spacings: the new solid particle would repel a closer
/// one (leak_distance in coupling.hpp). A direct neighbour that agrees is never closer. While another is,
/// the nearest one is drawn to the site and pushes it away.
inline constexpr double site_clearance = 1.0 - site_agreement;
/// Distance from its site, in spacings, within which a particle joins the body: the jump that is left moves no liquid.
inline constexpr double joins_within = 0.1;
/// What a particle is drawn to its site in an acoustic step, in spacings: at about a hundredth of the sound speed
/// liquid gives way without being compressed.
inline constexpr double drawn_step = 0.01;

/// s, of what is a distance [m] from its site; acoustic: the scene's acoustic step [s]. Longer sub-steps draw no further. Ours.
template <class T>
MELTSIM_HD T drawn_share(T distance, T spacing, T dt, T acoustic) {
  const T step = T(drawn_step) * spacing * (dt < acoustic ? dt / acoustic : T(1));
  return distance > step ? step / distance : T(1);
}

/// v_i - v_site [m/s] of a particle drawn along `way` to a body that is held: what leads away from the site is taken, so that what
/// falls as fast as it is drawn arrives. The body takes its momentum.
template <class T>
MELTSIM_HD Vec3<T> drawn_velocity(Vec3<T> relative, Vec3<T> way) {
  const T away = minimum(dot(relative, way), T(0)), distance2 = dot(way, way);
  return distance2 > T(0) ? relative - way * (away / distance2) : relative;
}

/// Smallest distance of a site from the faces of the domain, in spacings: a body resting on a wall has 0.5.
inline constexpr double site_margin = 0.25;

/// Rest volume, relaxing to m/rho0 [m^3]; share = dt / relaxation time. Within rounding it becomes exact.
template <class T>
MELTSIM_HD T relaxed_volume(T volume, T target, T share) {
  const T gap = target - volume;
  if (std::fabs(gap) <= T(1e-5) * target) return target;
  return volume + gap * minimum(share, T(1));
}

/// phi from which on a place is crushed [-], far beyond what weight makes of liquid.
inline constexpr double crushed = 1.1;
/// Share of its volume that a particle has when it melts [-], so that its push, V P/phi^2, is at most that at `crushed`; tau: that of the solid
/// that it was (solid_term). A lattice bears being pressed into another body; liquid of phi = 1.6 there has 27 times the pressure
/// of phi = 1.1, and would be thrown out. Ours.
template <class T>
MELTSIM_HD T born_share(T tau) {
  const T most = solid_term(T(crushed));
  return tau > most ? most / tau : T(1);
}

/// Relaxation time in units of H/c: even a tenfold change of volume then moves the surroundings at far less than
/// the sound speed.
inline constexpr double volume_relaxation = 40.0;

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
