// SPDX-License-Identifier: Apache-2.0
// `--set path=value`: changes to the scene before it is read, so that they are checked like the file itself.
#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <string>
#include <vector>

namespace runner {

/// Applies e.g. "bodies[0].temperature=-5" to `root`; returns path -> option text for messages.
std::map<std::string, std::string> apply_overrides(YAML::Node& root, const std::vector<std::string>& options);

}  // namespace runner
