// SPDX-License-Identifier: Apache-2.0
// Positions for the vector loops of a CPU: one array per coordinate.
#pragma once

#include <cstdint>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Number of SIMD lanes: neighbours processed side by side, whatever the width of the machine's vectors; part of the order
/// of sums.
inline constexpr std::uint32_t lanes = 8;

/// Sums by lanes end in other bits than sums one by one, which is what GPUs do: where both are to have the
/// same bits the CPU works one by one, too.
#if defined(MELTSIM_REPRODUCIBLE)
inline constexpr bool sums_by_lanes = false;
#else
inline constexpr bool sums_by_lanes = true;
#endif

/// x, y, z and volume of every particle, readable up to `lanes` beyond the last one.
template <class T>
struct LanePositions {
  const T *x = nullptr, *y = nullptr, *z = nullptr, *w = nullptr;
};

/// Whether an executor runs the bodies that work on lanes: it then makes LanePositions.
template <class E, class = void>
inline constexpr bool runs_lanes = false;
template <class E>
inline constexpr bool runs_lanes<E, decltype(static_cast<void>(E::lanes))> = E::lanes;

}  // namespace core
}  // namespace v0
}  // namespace meltsim
