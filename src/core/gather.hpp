// SPDX-License-Identifier: Apache-2.0
// How a long sum is shared out; the same on every backend, so that the order of addition is.
#pragma once

#include <cstdint>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Below this many items one thread per item would leave most of a large GPU idle, and the longest sum
/// decides.
inline constexpr std::uint64_t gather_few = 200000;

/// Parts a sum over each of n items is made of.
constexpr std::uint32_t gather_parts(std::uint64_t n) { return n < gather_few ? 3u : 1u; }

}  // namespace core
}  // namespace v0
}  // namespace meltsim
