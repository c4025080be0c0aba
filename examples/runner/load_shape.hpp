// SPDX-License-Identifier: Apache-2.0
// Shapes of a scene: {box: ...}, {union: [...]}, each with an optional transform.
#pragma once

#include "scene.hpp"

namespace runner {

SceneShape load_shape(const Node& node);

}  // namespace runner
