// SPDX-License-Identifier: Apache-2.0
// Open faces through which liquid leaves at a speed, or against a level.
//
// Sources: liquid near the face moves at one velocity, whatever forces act on it, as in Federico et al. (2012), Eur. J.
// Mech. B/Fluids 34:35. Against a level, that velocity follows from the invariant u + 2 sqrt(g h) that a wave carries
// downstream (Stoker 1957, Water Waves, sec. 10.2; Flather 1976, Mem. Soc. R. Sci. Liege 10:141), so waves leave the
// channel instead of coming back:
//
//   u_b = max(0, u + 2 sqrt(g h) - 2 sqrt(g h_L))                                         m/s
//   h   = sum V / A,   u = sum V v.n / sum V   over the liquid between H and 3 H from the face
//
//   symbol  meaning                                                                   unit
//   u_b     velocity of the liquid within H of the face, out of it                    m/s
//   h_L     height of the level beyond above the floor                                m
//   A       area of the floor between H and 3 H from the face                         m^2
//   n       unit normal of the face, outwards                                         -
//
// Deviations: pressure over the depth is taken as hydrostatic and the floor as the domain's; what stands on it within 3 H of the
// face counts as no liquid. Nothing comes in: where u_b would be negative, liquid stands still.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Distances from the face, in support radii: liquid nearer than the first is moved, up to the second it is measured.
inline constexpr double outlet_reach = 1, outlet_end = 3;  ///< the second

/// What is beyond the open faces of the domain; bit f, entry f: face f (2 axis + side).
template <class T>
struct Outlets {
  std::uint32_t taking{};  ///< liquid near the face moves out of it
  std::uint32_t levels{};  ///< its speed follows from a level
  std::uint32_t inlets{};  ///< and liquid comes in (physics/inlet.hpp)
  T speed[6]{};            ///< where it does not [m/s]
  T head[6]{};             ///< h_L [m]
  T floor[6]{};            ///< A [m^2]
};

/// Distance from face f of a box [m], negative beyond it.
template <class T>
MELTSIM_HD T face_distance(Vec3<T> low, Vec3<T> high, Vec3<T> x, std::uint32_t f) {
  const T at = f < 2u ? x.x : f < 4u ? x.y : x.z;
  const T lo = f < 2u ? low.x : f < 4u ? low.y : low.z, hi = f < 2u ? high.x : f < 4u ? high.y : high.z;
  return (f & 1u) == 0u ? at - lo : hi - at;
}

/// Unit normal of face f, outwards.
template <class T>
MELTSIM_HD Vec3<T> face_outwards(std::uint32_t f) {
  const T n = (f & 1u) == 0u ? T(-1) : T(1);
  return {f < 2u ? n : T(0), f >= 2u && f < 4u ? n : T(0), f >= 4u ? n : T(0)};
}

/// The face whose outlet takes a particle at x along, the last of several; 6: none.
template <class T>
MELTSIM_HD std::uint32_t taken_by(const Outlets<T>& o, T support, Vec3<T> low, Vec3<T> high, Vec3<T> x) {
  std::uint32_t face = 6u;
  for (std::uint32_t f = 0; f < 6u; ++f)
    if (((o.taking >> f) & 1u) != 0u && face_distance(low, high, x, f) < T(outlet_reach) * support) face = f;
  return face;
}

/// Liquid ahead of an outlet. Whole numbers, so that the order of the particles does not matter.
struct OutletSums {
  static constexpr double volume_units = 1 << 20;  ///< of `volume` to dx^3
  static constexpr double flow_units = 1 << 28;    ///< of `flow` to dx^3 c
  std::int64_t volume = 0;                         ///< sum V
  std::int64_t flow = 0;                           ///< sum V v.n
  /// Adds a particle of a volume [dx^3] and a speed out of the face, over the speed of sound [-].
  MELTSIM_HD void add(double v, double speed) {
    volume += static_cast<std::int64_t>(v * volume_units);
    flow += static_cast<std::int64_t>(v * speed * flow_units);
  }
  MELTSIM_HD static OutletSums combine(OutletSums a, const OutletSums& b) {  ///< sum of both
    a.volume += b.volume;
    a.flow += b.flow;
    return a;
  }
};

/// u_b [m/s] of liquid of these sums over a floor of this area; 0 without liquid.
MELTSIM_HD double outlet_speed(const OutletSums& s, double spacing, double sound_speed, double floor,
                               double head, double gravity) {
  if (s.volume <= 0) return 0;
  const double volume = static_cast<double>(s.volume) / OutletSums::volume_units;
  const double flow = static_cast<double>(s.flow) / OutletSums::flow_units * sound_speed;
  const double height = volume * spacing * spacing * spacing / floor;
  return maximum(0.0, flow / volume + 2 * (std::sqrt(gravity * height) - std::sqrt(gravity * head)));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
