// SPDX-License-Identifier: Apache-2.0
// Ids are values: an index and a generation, so that an id of a removed thing is recognised. Zero is null.
#pragma once

#include <cstdint>

namespace meltsim {
inline namespace v0 {

template <class Tag>
struct Handle {
  std::uint32_t index = 0;       ///< position in the World's table, from 0
  std::uint32_t generation = 0;  ///< 0 = null
  constexpr explicit operator bool() const { return generation != 0; }
  friend constexpr bool operator==(Handle a, Handle b) {
    return a.index == b.index && a.generation == b.generation;
  }
  friend constexpr bool operator!=(Handle a, Handle b) { return !(a == b); }
};

using MaterialId = Handle<struct MaterialTag>;
using BodyId = Handle<struct BodyTag>;
using HeatRegionId = Handle<struct HeatRegionTag>;
using EmitterId = Handle<struct EmitterTag>;
using ProbeId = Handle<struct ProbeTag>;

}  // namespace v0
}  // namespace meltsim
