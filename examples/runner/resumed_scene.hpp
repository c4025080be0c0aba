// SPDX-License-Identifier: Apache-2.0
// What a run that is resumed has of a scene that was changed meanwhile.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"

namespace runner {

/// Takes over from `scene`, resolved as `now`, what a World goes on with after restore(): speeds of emitters and of kinematic bodies are
/// part of its state and are set again. What is state and cannot be set becomes what `before` has, and sound is as fast as that World
/// has it, so that `now` says what runs. Returns a sentence for every difference: taken over or ignored. Fails where a body would jump.
std::vector<std::string> take_over(const Scene& scene, Built& built, const Json& before, Json& now);

/// A line for every difference, of a scene that the checkpoint does not fit.
std::string changed_since(const Json& before, const Json& now);

}  // namespace runner
