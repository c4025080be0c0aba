// SPDX-License-Identifier: Apache-2.0
// Events on the device: a ring of rows, and their numbers.
#pragma once

#include <cstdint>

#include "meltsim/physics/math.hpp"
#include "meltsim/reading.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// One event. Indices are none = 0xffffffff where they do not apply.
struct EventRow {
  std::uint32_t kind = 0;                ///< EventKind
  std::uint32_t particle = 0xffffffffu;  ///< id
  std::uint32_t body = 0xffffffffu;      ///< index
  std::uint32_t other = 0xffffffffu;     ///< index of the other body
  std::uint32_t wall = 0xffffffffu;      ///< face
  std::uint32_t piece = 0, from = 0;     ///< labels + 1
  std::uint32_t unused = 0;              ///< keeps the size a multiple of 8
  std::uint64_t step = 0;                ///< index of the sub-step
  double time = 0;                       ///< at its end [s]
  Vec3<double> at{};                     ///< in stored coordinates [m]
};

/// Numbers of events since the host last took them.
struct EventHead {
  std::int64_t count[event_kinds + 1] = {};  ///< of each kind; the last one stays 0
  std::uint64_t written = 0;                 ///< in all; the ring has the last of them
  std::int64_t pending = 0;                  ///< of this sub-step
  std::uint32_t idle = 1;                    ///< a guard: 1 but while those of a sub-step are being written
  std::uint32_t unused = 0;                  ///< keeps the size a multiple of 8
};

/// Largest number of bodies whose contacts are tracked: the table has an entry for each pair.
inline constexpr std::uint64_t most_touching_bodies = 1024;
/// Columns of the table of contacts ahead of those of bodies: the walls.
inline constexpr std::uint32_t wall_columns = 6;
inline constexpr std::uint32_t contact_events =
    event_bit(EventKind::contact_begun) | event_bit(EventKind::contact_ended) | event_bit(EventKind::gone);

/// Entries of the table of contacts: a row per body; columns are walls, then bodies. On the diagonal whether a body has solid
/// particles.
inline std::uint64_t touch_entries(std::uint64_t bodies, std::uint32_t kinds) {
  return (kinds & contact_events) != 0u ? bodies * (bodies + wall_columns) : 0u;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
