// SPDX-License-Identifier: Apache-2.0
// Key of a sub-step's launches: equal keys, equal launches.
#pragma once

#include <array>
#include <cstdint>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Everything that changes between sub-steps without a new upload, as bits. The clock is not part of it: it
/// is set by step.begin, whose arguments are given anew every time.
using RepeatKey = std::array<std::uint64_t, 19>;

}  // namespace core
}  // namespace v0
}  // namespace meltsim
