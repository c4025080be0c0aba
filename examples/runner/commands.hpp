// SPDX-License-Identifier: Apache-2.0
// The commands of the program. Each returns an exit code or throws a Failure.
#pragma once

#include <string>

#include "options.hpp"
#include "scene.hpp"

namespace runner {

int cmd_run(const RunOptions& options);
int cmd_check(const SceneOptions& scene, const MachineOptions& machine, bool verbose);
int cmd_list();
int cmd_new(const std::string& name);
int cmd_info();
/// 0 when every row of every case passes, else 1.
int cmd_validate(const ValidateOptions& options);
int cmd_render(const RenderOptions& options);
int cmd_trade(const TradeOptions& options);
/// 0 when every cell holds, is clamped or is refused, else 1.
int cmd_stress(const StressOptions& options);
int cmd_plot(const std::string& directory);

/// Reads the scene and applies --set, --scale and --quality.
Scene load_scene(const SceneOptions& options);

}  // namespace runner
