// SPDX-License-Identifier: Apache-2.0
// The rate at which a liquid is sheared, from the velocities of neighbours.
//
// Source: the velocity gradient A is the least-squares fit of v_i - v_j = A (x_i - x_j) over all neighbours, weighted with
// V_j L_ij (moving least squares: Lancaster & Salkauskas 1981, Math. Comput. 37:141; as a corrected SPH gradient: Randles &
// Libersky 1996, Comput. Methods Appl. Mech. Eng. 139:375), exact for a linear field at surfaces, too:
//
//   A M = G,  M = 1/2 sum_j V_j L_ij x_ij x_ij^T,  G = 1/2 sum_j V_j L_ij v_ij x_ij^T
//
// M is the unit matrix inside. A no-slip wall at distance d is one more neighbour, at the foot of the normal. Its weight is
// S/d^3, S = sum_j V_j L_ij s^3, s = x_j - x_i along the normal inwards: what curves the profile across the wall then cancels, as
// it does inside, where neighbours lie on both sides; but at least that of the wall's ghosts, I(d)/d (wall_exchange.hpp),
// which all a film has that is a particle thick. Particles of bodies are neighbours of no_slip_factor times the velocity
// difference, as in the viscous force (coupling.hpp): the profile goes on beyond the surface of the body.
// Deviation: `least_moment` is added to the diagonal of M, so that sheets and threads of single particles, which
// neighbours on one side only or none say nothing about, have no rate across them.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Sums over the neighbours of a particle.
template <class T>
struct GradientSum {
  Vec3<T> x{}, y{}, z{};  ///< rows of 2 G: of the components of the velocity [1/s]
  Sym3<T> moment;         ///< 2 M [-]
  Vec3<T> skew{};         ///< sum V L x_ij^3 of every component [m]
};

/// Added to the diagonal of M [-]: makes a rate too small by as much.
inline constexpr double least_moment = 1e-3;

/// Adds a neighbour of weight V L [1/m^2].
template <class T>
MELTSIM_HD void add_neighbour(GradientSum<T>& s, T weight, Vec3<T> x_ij, Vec3<T> v_ij) {
  const Vec3<T> u = x_ij * weight;
  s.x += u * v_ij.x;
  s.y += u * v_ij.y;
  s.z += u * v_ij.z;
  s.moment.diagonal += Vec3<T>{u.x * x_ij.x, u.y * x_ij.y, u.z * x_ij.z};
  s.moment.mixed += Vec3<T>{u.y * x_ij.z, u.z * x_ij.x, u.x * x_ij.y};
  s.skew += Vec3<T>{u.x * (x_ij.x * x_ij.x), u.y * (x_ij.y * x_ij.y), u.z * (x_ij.z * x_ij.z)};
}

/// Weight of a no-slip wall at `depth` [m], on the side of `normal`, inwards, of a particle with these neighbours [1/m^2];
/// ghosts: I(d)/d of the wall.
template <class T>
MELTSIM_HD T wall_weight(Vec3<T> skew, Vec3<T> normal, T depth, T ghosts) {
  return maximum(ghosts, -dot(skew, normal) / (depth * depth * depth));
}

/// The fit A [1/s]: A.m[a][b] = d v_a/d x_b.
template <class T>
MELTSIM_HD Mat3<T> velocity_gradient(const GradientSum<T>& s) {
  const T two = T(2 * least_moment);
  const Vec3<T> d = s.moment.diagonal + Vec3<T>{two, two, two}, o = s.moment.mixed;
  const Vec3<T> a{d.x, o.z, o.y}, b{o.z, d.y, o.x}, c{o.y, o.x, d.z};  // rows
  const Vec3<T> bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
  const T inverse = T(1) / dot(a, bc);  // positive: M is at least least_moment
  Mat3<T> A;
  const Vec3<T> rows[3] = {s.x, s.y, s.z};
  for (int k = 0; k < 3; ++k) {
    A.m[k][0] = dot(rows[k], bc) * inverse;
    A.m[k][1] = dot(rows[k], ca) * inverse;
    A.m[k][2] = dot(rows[k], ab) * inverse;
  }
  return A;
}

/// gd = sqrt(2 D:D) [1/s], D the symmetric part of A without its trace: rotation and compression do not shear.
template <class T>
MELTSIM_HD T shear_rate(const Mat3<T>& A) {
  const T third = (A.m[0][0] + A.m[1][1] + A.m[2][2]) * T(1.0 / 3.0);
  const T xx = A.m[0][0] - third, yy = A.m[1][1] - third, zz = A.m[2][2] - third;
  const T xy = A.m[0][1] + A.m[1][0], yz = A.m[1][2] + A.m[2][1], zx = A.m[2][0] + A.m[0][2];
  return std::sqrt(T(2) * (xx * xx + yy * yy + zz * zz) + (xy * xy + yz * yz + zx * zx));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
