// SPDX-License-Identifier: Apache-2.0
// Scenes compiled into the program, so that `meltsim run ice_block` needs no file.
#pragma once

#include <string>
#include <vector>

namespace runner {

struct BuiltinScene {
  std::string name;
  std::string text;   ///< the YAML file
  std::string title;  ///< its title line, for `meltsim list`
};

const std::vector<BuiltinScene>& builtin_scenes();
std::vector<std::string> builtin_names();
const BuiltinScene* find_builtin(const std::string& name);

}  // namespace runner
