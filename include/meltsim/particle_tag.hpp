// SPDX-License-Identifier: Apache-2.0
// The 32-bit tag of a particle: its material, its body and its kind.
#pragma once

#include <cstdint>

#include "meltsim/physics/hd.hpp"

namespace meltsim {
inline namespace v0 {

using ParticleTag = std::uint32_t;  ///< bits below

inline constexpr ParticleTag tag_material_mask = 0x000000ffu;  ///< index into the material table
inline constexpr ParticleTag tag_solid = 0x00000100u;          ///< on a lattice; otherwise liquid
inline constexpr ParticleTag tag_surface = 0x00000200u;        ///< SBP: fewer than 27 live direct neighbours
inline constexpr ParticleTag tag_fixed = 0x00000400u;          ///< belongs to a body that no force moves
inline constexpr ParticleTag tag_removed = 0x00000800u;        ///< left through an open face
inline constexpr ParticleTag tag_held = 0x00001000u;  ///< liquid in a nozzle: moves at the nozzle's velocity
inline constexpr ParticleTag tag_kinematic = 0x00002000u;  ///< beside tag_fixed: the host moves the body
inline constexpr int tag_body_shift = 16;                  ///< body index + 1; kept after melting

MELTSIM_HD std::uint32_t material_of(ParticleTag t) { return t & tag_material_mask; }  ///< MaterialId::index
MELTSIM_HD std::uint32_t body_of(ParticleTag t) { return t >> tag_body_shift; }        ///< BodyId::index + 1
/// In a body.
MELTSIM_HD bool is_solid(ParticleTag t) { return (t & (tag_solid | tag_removed)) == tag_solid; }
MELTSIM_HD bool is_fluid(ParticleTag t) { return (t & (tag_solid | tag_removed)) == 0u; }  ///< liquid
/// Liquid in a nozzle.
MELTSIM_HD bool is_held(ParticleTag t) { return (t & (tag_solid | tag_removed | tag_held)) == tag_held; }
MELTSIM_HD bool is_removed(ParticleTag t) { return (t & tag_removed) != 0u; }  ///< no longer in the scene

}  // namespace v0
}  // namespace meltsim
