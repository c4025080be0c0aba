// SPDX-License-Identifier: Apache-2.0
// Heat through surfaces that a scene asks for and does not get.
#pragma once

#include "node.hpp"
#include "scene.hpp"

namespace runner {

/// Whether heat goes through a surface at all.
inline bool acts(const meltsim::SurfaceHeatDesc& s) {
  return s.temperature || s.flux != 0 || s.convection != 0 || s.emissivity != 0;
}

/// Notes in `scene.warnings` what can only be an oversight.
void check_heat(const Node& root, Scene& scene);

}  // namespace runner
