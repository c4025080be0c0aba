// SPDX-License-Identifier: Apache-2.0
// Slips that leave a scene valid: values that a reader accepts and that hardly anybody means.
#pragma once

#include "scene.hpp"

namespace runner {

/// Fails where a value can only be a mistake; what may be meant goes to `scene.warnings`.
void check_units(const Node& root, Scene& scene);

/// Fails when the run would have more frames than anybody can store; options may have changed what the scene said.
void check_frames(const Scene& scene);

/// The largest speed [m/s] that things start with or that a fall through the height of what there is gives; to_floor: through that down to
/// the lowest corner of a bounded domain.
double speed_of(const Scene& scene, bool to_floor);

/// For a shape that is `size` m large where `room` m are there: what to do if it is in millimetres.
/// Empty when that would not help.
std::string millimetre_hint(const SceneShape& shape, double size, double room, double spacing);

}  // namespace runner
