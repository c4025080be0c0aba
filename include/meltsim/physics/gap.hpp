// SPDX-License-Identifier: Apache-2.0
// Pressure of the liquid in the gap between two bodies.
//
// As between a body and a wall (seepage.hpp, with the source) no particle of liquid fits between bodies that touch, and the gap
// holds the pressure that liquid has at its rim. A body has no plane, so direction and area come from both lattices.
//
//   symbol   meaning                                                                                unit
//   g_kj     2 V_k V_j f x_kj: force on particle k of a body per pressure of the pair (fluid.hpp)    m^2
//   G_k      sum of g_kj over the surfaces of other pieces; n = G_k/|G_k| points away from them      m^2
//   o_k      -n.(sum of g_kj over k's own piece): side that its piece leaves open towards them       m^2
//   l_k      n.(sum of g_ki times the mean pressure of the pair over liquid and its images)          N
//   h_k      share of the gap's pressure, by the distance of the nearest particle across it, less
//            what liquid fills of it, times c                                                        -
//   c        forces of the pairs across a gap between two half-spaces over those of their outermost
//            layers with the other one                                                               -
//   S_k      sum of g_kj over particles of bodies and their images                                   m^2
//   w_k      -S_k.(sum of g_ki over liquid and its images)/S_k^2, within bounds: how wet it is       -
//   p_k      mean over liquid and its images, by |g_ki|, of the pair's pressure at the height of k   Pa
//   A        sum of h_k |S_k| over a piece: area of the rim of its gaps                              m^2
//   p(x)     sum over them of h_k |S_k| w_k (p_k + rho g.(x - x_k)), over A                          Pa
//   s_k      h_k (o_k p(x_k - n dx/2) - l_k)^+ / |G_k|: pressure that k asks for in its pairs        Pa
//   p_kj     (|G_k| s_k + |G_j| s_j)/(|G_k| + |G_j|), of s_k alone where no force moves j's body       Pa
//   F_kj     p_kj g_kj on k, the negative on j                                                       N
//
// Sums of g over what is all around a particle vanish, so at one pressure o_k p - l_k is what the pairs of k with other bodies would
// press with, were these liquid: Archimedes holds for what lies on them. Layers behind the outermost ask for nothing; c has their part.
// Of two
// sides the one that sees more of the gap has more of a say: beside a body the other one asks for what liquid's stand-off leaves open.
// Forces act along the line between the particles: momentum and angular momentum are exact.
// Deviations: as of seepage.hpp; one pressure per piece, with its height, so that gaps of a piece are as wet as they are in the mean.
#pragma once

#include "meltsim/physics/seepage.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Distance in spacings of the nearest particle across a gap from which on liquid can enter.
inline constexpr double gap_reach = 1.9;

/// What a neighbour of k is for these sums.
template <class T>
struct GapNeighbour {
  bool solid = false;  ///< a particle of a body
  bool own = false;    ///< of k's piece
  bool faces = false;  ///< at the surface of another piece
  T pressure{};        ///< of liquid: mean of the pair [Pa]
  T level{};           ///< the same, taken to the height of k [Pa]
  T density{};         ///< of liquid [kg/m^3]
};

/// Sums over the neighbours of a particle at the surface of a body.
template <class T>
struct GapSums {
  Vec3<T> facing{};   ///< G_k [m^2]
  Vec3<T> own{};      ///< sum of g over the piece of k, without images [m^2]
  Vec3<T> solid{};    ///< S_k [m^2]
  Vec3<T> liquid{};   ///< sum of g over liquid and its images [m^2]
  Vec3<T> pressed{};  ///< the same, times the mean pressure of the pair [N]
  T size{};           ///< sum of |g| over them [m^2]
  T level{};          ///< the same, times the pressure at the height of k [N]
  T heavy{};          ///< the same, times rho [kg/m]
  T nearness{};       ///< 1/r^2 of the nearest particle of `facing`, 0 without [1/m^2]

  /// Sums over other neighbours.
  MELTSIM_HD void add(const GapSums& o) {
    facing += o.facing;
    own += o.own;
    solid += o.solid;
    liquid += o.liquid;
    pressed += o.pressed;
    size += o.size;
    level += o.level;
    heavy += o.heavy;
    nearness = maximum(nearness, o.nearness);
  }
  /// One neighbour and its images; volumes: V_k V_j.
  MELTSIM_HD void add(const SphKernel<T>& k, const WallView<T>& walls, const GapNeighbour<T>& j, T volumes,
                      Vec3<T> x_kj, T r2) {
    const auto area = [&](const Vec3<T>& x, T square) {
      return x * (T(2) * volumes * kernel_gradient_factor(k, std::sqrt(square)));
    };
    const Vec3<T> g = area(x_kj, r2);
    if (j.own) own += g;
    if (j.faces) {
      facing += g;
      nearness = maximum(nearness, T(1) / r2);
    }
    add_one(j, g);
    for_each_masked_image(walls, k.support2, x_kj, r2,
                          [&](std::uint32_t, const Vec3<T>& x, T square) { add_one(j, area(x, square)); });
  }

 private:
  MELTSIM_HD void add_one(const GapNeighbour<T>& j, const Vec3<T>& g) {
    if (j.solid) {
      solid += g;
      return;
    }
    const T magnitude = length(g);
    liquid += g;
    pressed += g * j.pressure;
    size += magnitude;
    level += magnitude * j.level;
    heavy += magnitude * j.density;
  }
};

/// c, of a square lattice with this spacing [m] in both half-spaces, a spacing apart.
inline double gap_scale(const SphKernel<double>& k, double spacing) {
  double outermost = 0, all = 0;
  const int reach = static_cast<int>(k.support / spacing) + 1;
  for (int apart = 1; apart <= reach; ++apart)
    for (int b = -reach; b <= reach; ++b)
      for (int c = -reach; c <= reach; ++c) {
        const double r = spacing * std::sqrt(double(apart * apart + b * b + c * c));
        if (!(r < k.support)) continue;
        const double across = apart * kernel_gradient_factor(k, r);
        outermost += across;
        all += apart * across;  // of `apart` pairs of layers
      }
  return outermost > 0 ? all / outermost : 1;
}

/// What a particle tells of the gaps of its piece, and asks of them.
template <class T>
struct GapFace {
  Vec3<T> across{};  ///< from k to the middle of the gap, -n dx/2 [m]
  T side{};          ///< h_k o_k / |G_k| [-]
  T filled{};        ///< h_k l_k / |G_k| [Pa]
  T area{};          ///< h_k |S_k| [m^2]
  T press{};         ///< h_k |S_k| w_k p_k [N]
  T weight{};        ///< h_k |S_k| w_k rho [kg/m]
};

/// scale: c.
template <class T>
MELTSIM_HD GapFace<T> gap_face(const GapSums<T>& s, T spacing, T scale) {
  GapFace<T> face;
  const T across = length(s.facing);
  if (!(across > T(0)) || !(s.nearness > T(0))) return face;
  const Vec3<T> n = s.facing * (T(1) / across);
  const T near = seepage_share(T(1) / std::sqrt(s.nearness), T(gap_reach), spacing);
  const T open = -dot(s.own, n), fills = open > T(0) ? dot(s.liquid, n) / open : T(0);
  const T share = near * (T(1) - clamp((fills - static_cast<T>(0.85)) / static_cast<T>(0.15), T(0), T(1)));
  if (!(share > T(0))) return face;
  face.across = n * (T(-0.5) * spacing);
  face.side = scale * share * open / across;
  face.filled = scale * share * dot(s.pressed, n) / across;
  const T rim = length(s.solid);
  if (!(rim > T(0))) return face;
  face.area = share * rim;
  if (!(s.size > T(0))) return face;
  const T wet = clamp(-dot(s.liquid, s.solid) / (rim * rim), T(0), T(most_wet)) * (face.area / s.size);
  face.press = wet * s.level;
  face.weight = wet * s.heavy;
  return face;
}

/// s_k [Pa] at the height `below` [m] below the place that press is taken to, from sums over a piece: A, A p there and A rho g.
template <class T>
MELTSIM_HD T gap_pressure(T side, T filled, double area, double press, double slope, T below) {
  if (!(area > 0)) return T(0);
  const T pressure = maximum(static_cast<T>(press / area) + static_cast<T>(slope / area) * below, T(0));
  return maximum(side * pressure - filled, T(0));
}

/// p_kj [Pa] from s and |G| of both; push and sees are 0 of one whose body no force moves. Even in k and j to the last bit.
template <class T>
MELTSIM_HD T gap_pair_pressure(T push_k, T sees_k, T push_j, T sees_j) {
  const T sum = sees_k + sees_j;
  return sum > T(0) ? (push_k * sees_k + push_j * sees_j) / sum : T(0);
}

/// F_kj [N] from the pressure of the pair and g_kj's factors; odd in x_kj to the last bit.
template <class T>
MELTSIM_HD Vec3<T> gap_pair_force(const SphKernel<T>& k, T pressure, T volumes, Vec3<T> x_kj, T r2) {
  return x_kj * (T(2) * volumes * kernel_gradient_factor(k, std::sqrt(r2)) * pressure);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
