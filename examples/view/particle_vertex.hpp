// SPDX-License-Identifier: Apache-2.0
// A particle as it is drawn.
#pragma once

#include <cstdint>

namespace view {

struct ParticleVertex {
  float x = 0, y = 0, z = 0;  ///< [m], relative to Resolved::origin
  float speed = 0;            ///< [m/s]
  float temperature = 0;      ///< [degrees Celsius]
  std::uint32_t tag = 0;      ///< meltsim/particle_tag.hpp
};
static_assert(sizeof(ParticleVertex) == 24, "the layout that particle_renderer.cpp declares");

}  // namespace view
