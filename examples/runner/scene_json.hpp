// SPDX-License-Identifier: Apache-2.0
// The scene as it is run, every default and every `auto` as a value. It is a scene again: `meltsim run` takes
// it.
#pragma once

#include "meltsim/world.hpp"
#include "scene.hpp"

namespace runner {

Json scene_json(const Scene& scene, const meltsim::Resolved& resolved);

}  // namespace runner
