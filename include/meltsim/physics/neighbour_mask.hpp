// SPDX-License-Identifier: Apache-2.0
// Direct neighbours of a lattice site as the bits of arrayN: bit (dx+1) + 3(dy+1) + 9(dz+1) of each that is live, that of the site
// itself included. Source: Rivers & James (2007), FastLSM, ACM Trans. Graph. 26(3):82, for the lattice; the sums are ours.
#pragma once

#include "meltsim/physics/hd.hpp"
#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

inline constexpr std::uint32_t all_sites = (1u << 27) - 1u;  ///< the site and its 26 direct neighbours

inline constexpr std::uint32_t behind_x = 0x1249249u;  ///< the nine sites behind along x
inline constexpr std::uint32_t behind_y = 0x1c0e07u;   ///< the same along y
inline constexpr std::uint32_t behind_z = 0x1ffu;      ///< the same along z
inline constexpr int ahead_x = 2;                      ///< those ahead along x are so many bits on
inline constexpr int ahead_y = 6;                      ///< the same along y
inline constexpr int ahead_z = 18;                     ///< the same along z
inline constexpr std::uint32_t across_a_face =
    1u << 4 | 1u << 10 | 1u << 12 | 1u << 14 | 1u << 16 | 1u << 22;  ///< six that share a face with it

/// Sum of the offsets of the sites in `mask` [dx].
template <class T>
MELTSIM_HD Vec3<T> sum_of_offsets(std::uint32_t mask) {
  const auto along = [&](std::uint32_t behind, int ahead) {
    return T(static_cast<int>(popcount(mask & behind << ahead)) - static_cast<int>(popcount(mask & behind)));
  };
  return {along(behind_x, ahead_x), along(behind_y, ahead_y), along(behind_z, ahead_z)};
}

/// The mask of a site at a plane half a spacing behind it along `axis` (ahead of it otherwise), of the lattice with its image in the plane: the
/// nine sites beyond the plane are those of the site's own layer.
MELTSIM_HD std::uint32_t with_image(std::uint32_t mask, int axis, bool behind) {
  const std::uint32_t sites = axis == 0 ? behind_x : axis == 1 ? behind_y : behind_z;
  const int step = axis == 0 ? 1 : axis == 1 ? 3 : 9;
  const std::uint32_t beyond = behind ? sites : sites << (2 * step);
  const std::uint32_t images = behind ? mask >> step : mask << step;
  return (mask & ~beyond) | (images & beyond);
}

/// How many of the six sides around a site, of nine sites each, are missing as a whole, if that is all that is missing of its 26 direct neighbours, as
/// on faces, edges and corners of a box, on sheets and rods; 0 of all others.
MELTSIM_HD int whole_sides_open(std::uint32_t mask) {
  std::uint32_t open = 0;
  int sides = 0;
  const auto look = [&](std::uint32_t side) {
    if ((mask & side) != 0u) return;
    open |= side;
    ++sides;
  };
  look(behind_x), look(behind_x << ahead_x);
  look(behind_y), look(behind_y << ahead_y);
  look(behind_z), look(behind_z << ahead_z);
  return open == (all_sites & ~mask) ? sides : 0;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
