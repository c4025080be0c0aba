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

/// Sum of the offsets of the sites in `mask` [dx].
template <class T>
MELTSIM_HD Vec3<T> sum_of_offsets(std::uint32_t mask) {
  const auto along = [&](std::uint32_t behind, int ahead) {
    return T(static_cast<int>(popcount(mask & behind << ahead)) - static_cast<int>(popcount(mask & behind)));
  };
  return {along(behind_x, ahead_x), along(behind_y, ahead_y), along(behind_z, ahead_z)};
}

/// How many of the two sites that share a face with the one in the middle are in `mask`, per axis.
template <class T>
MELTSIM_HD Vec3<T> across_faces(std::uint32_t mask) {
  const auto along = [&](int behind, int ahead) { return T((mask >> behind & 1u) + (mask >> ahead & 1u)); };
  return {along(12, 14), along(10, 16), along(4, 22)};
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
