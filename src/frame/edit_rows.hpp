// SPDX-License-Identifier: Apache-2.0
// Particles that the host adds and takes out between sub-steps, where they are.
#pragma once

#include <cstdint>

#include "frame/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// A particle that lies in a box that the host asks about.
struct FoundParticle {
  Vec3<double> position;  ///< stored coordinates [m]
  double mass = 0;        ///< [kg]
  double volume = 0;      ///< at rest [m^3]
  std::uint32_t id = 0, tag = 0;
  std::uint32_t slot = 0;  ///< none: slot_of_id has it
  std::uint32_t padding = 0;
};

/// Ranges of slots that hold all particles of a box: rows of cells, or slots in portions.
struct FoundBox {
  static constexpr std::uint32_t portion = 64;
  std::uint32_t by_cells = 0;
  std::int32_t x = 0, y = 0, z = 0;     ///< the first cell
  std::int32_t nx = 0, ny = 0, nz = 0;  ///< cells along each axis
  Vec3<double> low, high;               ///< the box [m]
};

/// Particles that the host took out.
struct TakenSum {
  std::uint64_t count = 0;
  MELTSIM_HD static TakenSum combine(TakenSum a, const TakenSum& b) {
    a.count += b.count;
    return a;
  }
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
