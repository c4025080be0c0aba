// SPDX-License-Identifier: Apache-2.0
// run.json: everything needed to know, repeat and compare a run.
#pragma once

#include <string>
#include <vector>

#include "build_world.hpp"
#include "options.hpp"
#include "scene.hpp"

namespace runner {

/// Written when the run starts (without `final`) and again when it ends.
Json run_json(const Scene& scene, const Json& resolved_scene, const RunOptions& options, Built& built,
              const std::vector<std::string>& warnings, const Json& final_block);

}  // namespace runner
