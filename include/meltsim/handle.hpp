// SPDX-License-Identifier: Apache-2.0
// Ids are values: an index and a generation, by which an id of a removed object is recognised. 0 is null.
#pragma once

#include <cstdint>

namespace meltsim {
inline namespace v0 {
/// Identifies an object of one World. A default one is null and identifies nothing.
template <class Tag>
struct Handle {
  std::uint32_t index = 0;       ///< position in the World's table, from 0
  std::uint32_t generation = 0;  ///< 0 = null
  constexpr explicit operator bool() const { return generation != 0; }  ///< false if null
  friend constexpr bool operator==(Handle a, Handle b) {                ///< whether both are the same object
    return a.index == b.index && a.generation == b.generation;
  }
  friend constexpr bool operator!=(Handle a, Handle b) { return !(a == b); }  ///< whether they differ
};

/// From World::add_material(); {index, 1} names the material of that index, as particle tags have it, of any World.
using MaterialId = Handle<struct MaterialTag>;
using BodyId = Handle<struct BodyTag>;              ///< from World::add_solid()
using HeatRegionId = Handle<struct HeatRegionTag>;  ///< from World::add_heat_region()
using EmitterId = Handle<struct EmitterTag>;        ///< from World::add_emitter()
using ProbeId = Handle<struct ProbeTag>;            ///< from World::add_probe()
using ForceFieldId = Handle<struct ForceFieldTag>;  ///< from World::add_force_field()

}  // namespace v0
}  // namespace meltsim
