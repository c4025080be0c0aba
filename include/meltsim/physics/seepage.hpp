// SPDX-License-Identifier: Apache-2.0
// Pressure of the liquid in the gap between a body and a wall.
//
// No particle of liquid fits between a wall and a body nearer to it than a spacing, so none would lift a light body off the floor.
// Liquid seeps into such gaps in less time than bodies take to move, and where it does not flow, the pressure across a thin
// film is the one at its rim (Reynolds 1886, Phil. Trans. R. Soc. 177:157, eq. (18), without motion). So gaps hold that pressure.
//
//   symbol   meaning                                                                                unit
//   g_kj     2 V_k V_j f x_kj: force on particle k of the body per pressure of the pair (fluid.hpp)  m^2
//   n, d     normal of the wall, inwards; distance of k from it                                      m
//   o_k      -n.(sum of g_kj over particles of bodies and their images in other walls): area of the
//            underside                                                                               m^2
//   l_k      n.(sum of g_ki times the mean pressure of the pair over liquid and its images): what
//            presses there already                                                                   N
//   p_k      mean over liquid and its images, by |g_ki|, of the pair's pressure taken to the height of k
//            with rho g                                                                              Pa
//   S_k      part across n of the sum of g_kj over particles of bodies and all their images          m^2
//   w_k      -S_k.(sum of g_ki over liquid and its images)/S_k^2, within bounds: how much of it is
//            wet, 1 all around                                                                       -
//   A        sum of |S_k| over the particles of a piece near the wall: area of the rim of its gap    m^2
//   p        sum over them of |S_k| w_k p_k, over A, taken to the wall                               Pa
//   F_k      (o_k (p + rho g.n (d - dx/2)) - l_k)^+ n; the wall receives the negative                  N
//
// Sums of g over what is all around a particle vanish, and those within a body cancel in pairs. So in liquid at rest its forces
// and these add up to what Archimedes says. It only presses, since a film that is squeezed presses more; it fades where liquid fills the
// underside. Where the rim is dry, nothing presses: under a body that is wet on one side only the mean of both holds.
// Deviations: the time in which liquid seeps in, and pressure that falls along the gap (a moment on the body); bodies on
// bodies have no such gap; bodies that are fixed or that the host moves need none, and get none, nor do plates and grains one particle
// thick, which have no underside of their own.
#pragma once

#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Distance from the wall in spacings up to which particles belong to its gap: two layers of a body that is a spacing off, where
/// liquid can enter.
inline constexpr double seepage_reach = 2.5;
/// That of the outermost layer, which has most of the underside, alone.
inline constexpr double outermost_reach = 1.7;

/// Bound of w_k: sums over few neighbours are above 1 as often as below, and where S_k is next to nothing they say nothing.
inline constexpr double most_wet = 1.5;

/// Share of the gap's pressure at a distance: 1, and 0 from the reach on [-].
template <class T>
MELTSIM_HD T seepage_share(T distance, T reach, T spacing) {
  return clamp((reach * spacing - distance) / (T(0.2) * spacing), T(0), T(1));
}

/// Reach of a particle with this underside, in dx^2: layers within the body have 0.14 at most, corners of the outermost 0.47 or more.
template <class T>
MELTSIM_HD T reach_of(T under) {
  const T outermost = clamp((under - T(0.25)) * T(10), T(0), T(1));
  return T(seepage_reach) - outermost * T(seepage_reach - outermost_reach);
}

/// What a neighbour of k is for these sums.
template <class T>
struct SeepageNeighbour {
  bool solid = false;  ///< a particle of a body
  T pressure{};        ///< of liquid: mean of the pair [Pa]
  T level{};           ///< the same, taken to the height of k [Pa]
  T density{};         ///< of liquid [kg/m^3]
};

/// Sums over the neighbours of a particle of a body; components of `body`, `above` and `below` each for the near wall of their axis.
template <class T>
struct SeepageSums {
  Vec3<T> solid{};    ///< sum of g over bodies and all their images [m^2]
  Vec3<T> body{};     ///< -n.(sum of g over bodies and their images in other walls) [m^2]
  Vec3<T> above{};    ///< -n.(sum of g over liquid above) [m^2]
  Vec3<T> below{};    ///< n.(sum of g over liquid below and images) [m^2]
  Vec3<T> liquid{};   ///< sum of g over liquid and its images [m^2]
  Vec3<T> pressed{};  ///< sum of g_ki p over them, p the mean of the pair [N]
  T size{};           ///< sum of |g| over them [m^2]
  T level{};          ///< the same, times the pressure at the height of k [N]
  T heavy{};          ///< the same, times rho [kg/m]

  /// Sums over other neighbours.
  MELTSIM_HD void add(const SeepageSums& o) {
    solid += o.solid;
    body += o.body;
    above += o.above;
    below += o.below;
    liquid += o.liquid;
    pressed += o.pressed;
    size += o.size;
    level += o.level;
    heavy += o.heavy;
  }
  /// One neighbour and its images; volumes: V_k V_j.
  MELTSIM_HD void add(const SphKernel<T>& k, const WallView<T>& walls, const SeepageNeighbour<T>& j,
                      T volumes, Vec3<T> x_kj, T r2) {
    const auto area = [&](const Vec3<T>& x, T square) {
      return x * (T(2) * volumes * kernel_gradient_factor(k, std::sqrt(square)));
    };
    add_one(walls, j, area(x_kj, r2), 0u);
    for_each_masked_image(walls, k.support2, x_kj, r2, [&](std::uint32_t mask, const Vec3<T>& x, T square) {
      add_one(walls, j, area(x, square), mask);
    });
  }

 private:
  /// mask: bit per axis in whose wall it is mirrored.
  MELTSIM_HD void add_one(const WallView<T>& walls, const SeepageNeighbour<T>& j, const Vec3<T>& g,
                          std::uint32_t mask) {
    if (j.solid) {
      solid += g;
    } else {
      const T magnitude = length(g);
      liquid += g;
      pressed += g * j.pressure;
      size += magnitude;
      level += magnitude * j.level;
      heavy += magnitude * j.density;
    }
    along(walls.from.x, g.x, j.solid, mask & 1u, body.x, above.x, below.x);
    along(walls.from.y, g.y, j.solid, mask & 2u, body.y, above.y, below.y);
    along(walls.from.z, g.z, j.solid, mask & 4u, body.z, above.z, below.z);
  }
  MELTSIM_HD static void along(T from, T g, bool is_solid, std::uint32_t mirrored, T& of_body, T& from_above,
                               T& from_below) {
    const T up = from > T(0) ? g : -g;
    if (is_solid) of_body -= mirrored != 0u ? T(0) : up;
    else if (up > T(0)) from_below += up;
    else from_above -= up;
  }
};

/// What a particle tells of the gap at the near wall of one axis.
template <class T>
struct SeepageFace {
  T under{};   ///< o_k [m^2]
  T filled{};  ///< l_k [N]
  T area{};    ///< |S_k| [m^2]
  T press{};   ///< |S_k| w_k p_k at the wall [N]
  T slope{};   ///< |S_k| w_k rho g.n: how that changes away from the wall [N/m]
};

/// Of axis 0 to 2, within whose wall's reach the particle is.
template <class T>
MELTSIM_HD SeepageFace<T> seepage_face(const SeepageSums<T>& s, const WallView<T>& walls, int axis, T spacing,
                                       Vec3<T> gravity) {
  const auto part = [axis](const Vec3<T>& v) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; };
  const T from = part(walls.from), distance = std::fabs(from),
          share = seepage_share(distance, T(seepage_reach), spacing);
  SeepageFace<T> face;
  if (!(share > T(0))) return face;
  const T under = part(s.body), all = under + part(s.above), below = part(s.below);
  if (under > static_cast<T>(0.01) * spacing * spacing && all > T(0)) {
    // Beneath a corner of a body liquid is three quarters of what is there; from 0.85 on it counts as filling the underside.
    const T full = clamp((below / all - static_cast<T>(0.85)) / static_cast<T>(0.15), T(0), T(1));
    const T dry = seepage_share(distance, reach_of(under / (spacing * spacing)), spacing) * (T(1) - full);
    face.under = dry * under;
    face.filled = dry * (from > T(0) ? part(s.pressed) : -part(s.pressed));
  }
  Vec3<T> out = s.solid;
  (axis == 0 ? out.x : axis == 1 ? out.y : out.z) = T(0);
  const T area = length(out);
  if (!(area > T(0))) return face;
  face.area = share * area;
  if (!(s.size > T(0))) return face;
  const T pull = from > T(0) ? part(gravity) : -part(gravity);
  const T wet = clamp(-dot(s.liquid, out) / (area * area), T(0), T(most_wet)) * (face.area / s.size);
  face.slope = wet * s.heavy * pull;
  face.press = wet * s.level - face.slope * distance;
  return face;
}

/// F_k . n [N] from o_k, l_k and the sums over a piece: A, A p and A rho g.n.
template <class T>
MELTSIM_HD T seepage_force(T under, T filled, double area, double press, double slope, T distance,
                           T spacing) {
  if (!(area > 0)) return T(0);
  const T gap = maximum(distance - T(0.5) * spacing, T(0));
  const T pressure = maximum(static_cast<T>(press / area) + static_cast<T>(slope / area) * gap, T(0));
  return maximum(under * pressure - filled, T(0));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
