// SPDX-License-Identifier: Apache-2.0
// Bodies touch bodies and walls.
//
// Source: Cundall & Strack (1979), Geotechnique 29:47 (soft spheres: spring, dashpot, Coulomb limit), with
// the stiffness chosen from a step as in Tsuji, Kawaguchi & Tanaka (1993), Powder Technol. 77:79.
//
//   k = kappa m*/dt_s^2,   c_n = 2 zeta sqrt(kappa) m*/dt_s,   k_t = kappa_t m*/dt_s^2,   c_t = tau m*/dt_s
//   F_t = -k_t s - c_t v_t,   |F_t| <= friction F_n
//   m* = m_i m_j/(m_i + m_j), or m_i against something immovable;  contact begins at one spacing.
//   dt_s: time step of the scene's springs (integrate.hpp: spring_dt), independent of the sub-step: one law, and no
//   energy from steps of varying length.
//
// The weights of all contacts of a particle add up to 1 (below), so k dt^2/m is at most kappa per side: with the dashpot
// 1.2 of the explicit limit of 4, of which shape matching takes 1. A light body on a heavy one is safe because m* never
// exceeds the lighter mass. A softer contact (kappa = 0.15) would let a block of 10000 on one of 200 kg/m^3 tip over: a
// column with its centre of mass at height h above a support of width b that is pressed in by d stands only
// if b^2/(12 d) > h.
//
// s [m] is the slip: how far two surfaces have moved along each other while in contact, limited to the length that
// friction holds. Without it friction is a dashpot, and a body on a soft support creeps: it tilts the support,
// slides down on it, and tilts it more. Deviation from the source: the slip is stored per particle, as the
// mean over its contacts, not per pair; a pair of movable particles has (s_i - s_j)/2.
//
// Geometry: spheres on a lattice would rest tip on tip and slide off. The normal is therefore that of the surface,
// that of the shape that the body was built from, or, where that does not say, or neighbours have melted, taken from the missing direct
// neighbours, in either case of the flatter of the two particles (Macklin et al. 2014, Unified
// particle physics, sec. 5.2, use a distance field's gradient for the same reason), and a pair counts by its
// sideways offset t as 1 - t/dx, which sums to about 1 however the two faces are shifted.
//
// Radii: a sphere of half a spacing around every particle would give a ball the steps of its lattice, on whose faces it stands
// instead of rolling. A particle at the surface of the shape that a body was built from therefore has a sphere as large as it is deep
// in that shape, laid evenly around the body's particles first, so that the spheres of a body together have its surface; half a
// spacing at most, so that bodies along the lattice, a spacing apart, do not touch, and a tenth at least, so that no particle gets to a wall. What
// melting uncovers has half a spacing.
#pragma once

#include "meltsim/physics/math.hpp"
#include "meltsim/physics/neighbour_mask.hpp"
#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Least radius of a particle in contact, in spacings: no particle gets to a wall.
inline constexpr double least_contact_radius = 0.1;
/// Largest radius, in spacings: of particles at flat faces, within a body, and of those that melting has uncovered.
inline constexpr double largest_contact_radius = 0.5;

/// Constants of a contact, in units of m*/dt_s^2 and m*/dt_s.
template <class T>
struct ContactLaw {
  T kappa, dashpot;          ///< normal: spring kappa; dashpot 2 zeta sqrt(kappa)
  T kappa_along, tau_along;  ///< along the surface: spring kappa_t; dashpot tau
};

/// Constants for bodies against bodies and walls.
template <class T>
MELTSIM_HD ContactLaw<T> body_contact() {
  return {T(0.4), T(0.3794733192), T(0.2), T(0.2)};
}

/// Time step of the springs of contacts [s] with which a column of this height [m] that comes to rest on its lowest particles presses
/// them in by at most a tenth of a spacing, of which half stays: kappa m d/dt_s^2 = m pull height/dx. What melts deeper in a wall is
/// liquid under pressure at once, which throws it out.
inline double standing_dt(double spacing, double pull, double height) {
  constexpr double stays = 0.05;  // of a spacing
  return spacing * std::sqrt(body_contact<double>().kappa * stays / (pull * height));
}

/// Constants for contacts without a stored slip, such as liquid: friction is a dashpot.
template <class T>
MELTSIM_HD ContactLaw<T> passing_contact() {
  return {T(0.15), T(0.3872983346), T(0), T(0.1)};
}
/// Result of a contact.
template <class T>
struct ContactResponse {
  Vec3<T> force{};  ///< on i [N]
  Vec3<T> slip{};   ///< after the step [m]
};

/// Force and slip of a contact. n: unit normal towards i; overlap > 0 [m]; v: velocity of i relative to the other side;
/// slip: of i along the other side at the start of the step [m]; spring_dt: dt_s. The force is that of the middle of
/// the step, to which positions belong. Odd in (n, v, slip) to the last bit.
template <class T>
MELTSIM_HD ContactResponse<T> contact_response(const ContactLaw<T>& law, T overlap, Vec3<T> n, Vec3<T> v,
                                               Vec3<T> slip, T reduced_mass, T friction, T dt, T spring_dt) {
  const T vn = dot(v, n);
  const T rate = reduced_mass / spring_dt;
  const T normal = maximum(law.kappa * rate * overlap / spring_dt - law.dashpot * rate * vn, T(0));
  const Vec3<T> vt = v - n * vn, st = slip - n * dot(slip, n);
  const Vec3<T> wanted =
      (st + vt * (T(0.5) * dt)) * (law.kappa_along * rate / spring_dt) + vt * (law.tau_along * rate);
  const T size = length(wanted), most = friction * normal;
  const T share = size > most ? most / size : T(1);
  return {n * normal - wanted * share, (st + vt * dt) * share};
}

/// Force of a contact without a stored slip [N].
template <class T>
MELTSIM_HD Vec3<T> contact_force(T overlap, Vec3<T> n, Vec3<T> v, T reduced_mass, T friction, T spring_dt) {
  return contact_response(passing_contact<T>(), overlap, n, v, Vec3<T>{}, reduced_mass, friction, spring_dt,
                          spring_dt)
      .force;
}

/// Outward normal in space (unit, or 0 inside) from the sum of the offsets of direct neighbours in units of the spacing; w =
/// their number.
template <class T>
MELTSIM_HD Vec4<T> outward_normal(Vec3<T> inward, T live, const Mat3<T>& rotation) {
  const T size = length(inward);
  if (!(size > T(0.5))) return with_w(Vec3<T>{}, live);  // inside, or a thin part with both sides open
  return with_w(rotation * (inward * (T(-1) / size)), live);
}

/// The same of a lattice vertex with its live direct neighbours (neighbour_mask.hpp).
template <class T>
MELTSIM_HD Vec4<T> surface_normal(std::uint32_t mask, const Mat3<T>& rotation) {
  return outward_normal(sum_of_offsets<T>(mask), T(popcount(mask)), rotation);
}

/// Live direct neighbours of a particle in a plane, itself among them.
inline constexpr double neighbours_of_plane = 18;
/// What stands for them in a curved face, which is not flat: balls overlap as their particles' spheres do, since tangent planes of balls that are
/// apart do overlap beside the nearest points.
inline constexpr double neighbours_of_curved = 15;
/// Those of a particle at a straight edge of two planes.
inline constexpr double neighbours_of_edge = 12;
/// What `built` below is longer by at curved faces.
inline constexpr double curved_mark = 0.25;

/// Whether the shape says how the surface lies at a particle with so many live direct neighbours. built: its outward normal in the frame of
/// the body as built, times how many of them the particle had then; 0: the shape does not say. w: below 0 at an edge.
template <class T>
MELTSIM_HD bool is_as_built(const Vec4<T>& built, T live) {
  return std::fabs(length(xyz(built)) - live) < T(0.5) && live > T(0.5);
}

/// The outward normal of the shape that a body was built from, as it lies in space. A face that is turned against the lattice, or curved,
/// is a staircase of particles: their own normals are those of its steps, which interlock with the steps of another.
template <class T>
MELTSIM_HD Vec4<T> built_normal(const Vec4<T>& built, T live, const Mat3<T>& rotation) {
  const T size = length(xyz(built));
  const double flat = size > live + T(0.5 * curved_mark) ? neighbours_of_curved : neighbours_of_plane;
  return with_w(rotation * (xyz(built) * (T(1) / size)), T(built.w < T(0) ? neighbours_of_edge : flat));
}

/// A normal of a surface that deforms: F^-T n, of F the one that takes the offsets d of neighbours as built to those that they have now, d', with
/// the least squares. moved: sum of d' d^T, built: of d d^T. Not of unit length; 0 where neighbours lie in a plane.
template <class T>
MELTSIM_HD Vec3<T> deformed_normal(const Mat3<T>& moved, const Mat3<T>& built, Vec3<T> n) {
  const Vec3<T> a{moved.m[0][0], moved.m[0][1], moved.m[0][2]},
      b{moved.m[1][0], moved.m[1][1], moved.m[1][2]}, c{moved.m[2][0], moved.m[2][1], moved.m[2][2]},
      v = built * n;
  return {dot(cross(b, c), v), dot(cross(c, a), v), dot(cross(a, b), v)};
}

/// Depth by which a sphere at x overlaps the plane of a face (in the order of DomainDesc::faces) [m].
template <class T>
MELTSIM_HD T wall_overlap(const WallBox<T>& b, T radius, Vec3<T> x, int face) {
  const auto along = [face](Vec3<T> v) { return face < 2 ? v.x : face < 4 ? v.y : v.z; };
  return face % 2 == 0 ? along(b.min) + radius - along(x) : along(x) - (along(b.max) - radius);
}

/// Unit normal of a face, inwards.
template <class T>
MELTSIM_HD Vec3<T> wall_normal(int face) {
  const T inwards = face % 2 == 0 ? T(1) : T(-1);
  return {face / 2 == 0 ? inwards : T(0), face / 2 == 1 ? inwards : T(0), face / 2 == 2 ? inwards : T(0)};
}
/// Geometry of a contact.
template <class T>
struct ContactGeometry {
  Vec3<T> normal{};  ///< towards i
  T overlap{};       ///< [m]
  T weight{};        ///< share of this pair in the contact of i, 0..1
};

/// How much of a face the surface at a particle with this many direct neighbours, itself among them, is: 1 on a plane (18 of 27, 17
/// where it is oblique to all axes), 0 on edges (12 where they are right), corners and steps.
template <class T>
MELTSIM_HD T flatness(T live) {
  return minimum(maximum((live - T(15)) * T(0.5), T(0)), T(1));
}

/// Normal, overlap and share of a pair; antisymmetric in i and j to the last bit. x_ij = x_i - x_j.
///
/// The flatter of both decides as far as it is a face. Where edges and corners alone meet, both point across the faces that touch,
/// each another way: the mean of both normals is nearer to that of the faces, and their particles overlap as spheres do, so that
/// none does at a distance of one spacing, however the normal leans.
template <class T>
MELTSIM_HD ContactGeometry<T> contact_geometry(const Vec4<T>& normal_i, const Vec4<T>& normal_j, Vec3<T> x_ij,
                                               T r2, T spacing) {
  ContactGeometry<T> g;
  const T r = std::sqrt(r2);
  const bool has_i = dot(xyz(normal_i), xyz(normal_i)) > T(0),
             has_j = dot(xyz(normal_j), xyz(normal_j)) > T(0);
  const bool by_i = has_i && (!has_j || normal_i.w > normal_j.w),
             by_j = has_j && (!has_i || normal_j.w > normal_i.w);
  const Vec3<T> both = (xyz(normal_j) - xyz(normal_i)) * (has_i && has_j ? T(0.5) : T(1));
  const T flat = flatness(maximum(has_i ? normal_i.w : T(0), has_j ? normal_j.w : T(0)));
  Vec3<T> n = both;
  if (by_i) n = both * (T(1) - flat) - xyz(normal_i) * flat;
  if (by_j) n = both * (T(1) - flat) + xyz(normal_j) * flat;
  const T size = length(n);
  n = size > T(0.05) ? n * (T(1) / size)
                     : x_ij * (T(1) / r);  // for faces that face each other; others keep x_ij/r
  const T along = dot(x_ij, n);
  const T t2 = maximum(r2 - along * along, T(0)), reach = maximum(along, T(0));
  g.normal = n;
  g.overlap = spacing - (along * flat + std::sqrt(t2 + reach * reach) * (T(1) - flat));
  if (along < T(-0.5) * spacing) g.overlap = T(0);  // the far side of a thin part
  g.weight = T(1) - std::sqrt(t2) / spacing;
  return g;
}
/// The overlap of spheres of these radii where that of spheres of half a spacing is `overlap` [m].
template <class T>
MELTSIM_HD T overlap_of_radii(T overlap, T spacing, T radius_i, T radius_j) {
  return overlap - (spacing - (radius_i + radius_j));
}

/// m* [kg].
template <class T>
MELTSIM_HD T reduced_mass(T m_i, T m_j) {
  return m_i * m_j / (m_i + m_j);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
