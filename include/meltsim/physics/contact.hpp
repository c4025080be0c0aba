// SPDX-License-Identifier: Apache-2.0
// Bodies touch bodies and walls.
//
// Source: Cundall & Strack (1979), Geotechnique 29:47 (soft spheres: spring, dashpot, Coulomb limit), with
// the stiffness chosen from the step as in Tsuji, Kawaguchi & Tanaka (1993), Powder Technol. 77:79.
//
//   k = kappa m*/dt^2,   c_n = 2 zeta sqrt(kappa) m*/dt,   c_t = tau m*/dt,   |F_t| <= friction F_n
//   m* = m_i m_j/(m_i + m_j), or m_i against something immovable;  contact begins at one spacing.
//
// kappa = 0.15: what touches a particle weighs 1 in all (below), so k dt^2/m <= 0.15, far below the explicit
// limit; light on heavy is safe because m* never exceeds the lighter mass.
//
// Geometry: spheres on a lattice would rest tip on tip and slide off. The normal is therefore the surface's,
// taken from the missing direct neighbours of the flatter of the two particles (Macklin et al. 2014, Unified
// particle physics, sec. 5.2, use a distance field's gradient for the same reason), and a pair counts by its
// sideways offset t as 1 - t/dx, which sums to about 1 however the two faces are shifted.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Force on i [N]. n: unit normal towards i; overlap > 0 [m]; v: velocity of i relative to the other.
template <class T>
MELTSIM_HD Vec3<T> contact_force(T overlap, Vec3<T> n, Vec3<T> v, T reduced_mass, T friction, T dt) {
  const T kappa = T(0.15), zeta = T(0.5), tau = T(0.1);
  const T root_kappa = T(0.3872983346);  // sqrt(kappa)
  const T vn = dot(v, n);
  const T rate = reduced_mass / dt;
  const T normal = maximum(kappa * rate * overlap / dt - T(2) * zeta * root_kappa * rate * vn, T(0));
  const Vec3<T> vt = v - n * vn;
  const T speed = length(vt);
  const T tangential = speed > T(0) ? minimum(tau * rate, friction * normal / speed) : T(0);
  return n * normal - vt * tangential;
}

/// Outward normal of a lattice vertex in space (unit, or zero inside); w = number of live direct neighbours.
/// mask: arrayN, bit (dx+1) + 3(dy+1) + 9(dz+1).
template <class T>
MELTSIM_HD Vec4<T> surface_normal(std::uint32_t mask, const Mat3<T>& rotation) {
  Vec3<T> inward{};
  for (int bit = 0; bit < 27; ++bit)
    if (((mask >> bit) & 1u) != 0u) inward += Vec3<T>{T(bit % 3 - 1), T(bit / 3 % 3 - 1), T(bit / 9 - 1)};
  const T size = length(inward);
  const T live = T(popcount(mask));
  if (!(size > T(0.5))) return with_w(Vec3<T>{}, live);  // inside, or thin: both sides open
  return with_w(rotation * (inward * (T(-1) / size)), live);
}

template <class T>
struct ContactGeometry {
  Vec3<T> normal{};  ///< towards i
  T overlap{};       ///< [m]
  T weight{};        ///< share of this pair
};

/// Normal, overlap and share of a pair; antisymmetric in i and j to the last bit. x_ij = x_i - x_j.
template <class T>
MELTSIM_HD ContactGeometry<T> contact_geometry(const Vec4<T>& normal_i, const Vec4<T>& normal_j, Vec3<T> x_ij,
                                               T r2, T spacing) {
  ContactGeometry<T> g;
  const T r = std::sqrt(r2);
  const bool has_i = dot(xyz(normal_i), xyz(normal_i)) > T(0),
             has_j = dot(xyz(normal_j), xyz(normal_j)) > T(0);
  Vec3<T> n = x_ij * (T(1) / r);
  if (has_i && (!has_j || normal_i.w > normal_j.w)) n = -xyz(normal_i);
  if (has_j && (!has_i || normal_j.w > normal_i.w)) n = xyz(normal_j);
  if (has_i && has_j && normal_i.w == normal_j.w) {
    const Vec3<T> sum = xyz(normal_j) - xyz(normal_i);
    const T size = length(sum);
    if (size > T(0.1)) n = sum * (T(1) / size);  // facing faces; else they do not face each other at all
  }
  const T along = dot(x_ij, n);
  g.normal = n;
  g.overlap = spacing - along;
  if (along < T(-0.5) * spacing) g.overlap = T(0);  // the far side of something thin
  const T t2 = maximum(r2 - along * along, T(0));
  g.weight = T(1) - std::sqrt(t2) / spacing;
  return g;
}

template <class T>
MELTSIM_HD T reduced_mass(T m_i, T m_j) {
  return m_i * m_j / (m_i + m_j);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
