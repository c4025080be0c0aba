// SPDX-License-Identifier: Apache-2.0
// `meltsim info` and `meltsim list`.
#include <fmt/format.h>

#include "builtin.hpp"
#include "commands.hpp"
#include "failure.hpp"
#include "meltsim/world.hpp"

namespace runner {

int cmd_info() {
  const meltsim::BuildInfo info = meltsim::build_info();
  const auto or_none = [](const std::string& text) { return text.empty() ? std::string("none") : text; };
  fmt::print("meltsim         {}\n", info.version);
  fmt::print("scene format    1\n");
  fmt::print("cpu threads     {}\n", info.cpu_threads);
  fmt::print("cuda            {}\n", info.cuda ? "built in" : "not built in");
  fmt::print("cuda runtime    {}\n", or_none(info.cuda_runtime));
  fmt::print("cuda driver     {}\n", or_none(info.cuda_driver));
  fmt::print("architectures   {}\n", or_none(info.architectures));
  for (const std::string& device : info.devices) fmt::print("device          {}\n", device);
  if (!info.cuda_reason.empty()) fmt::print("why no cuda     {}\n", info.cuda_reason);
  return 0;
}

int cmd_list() {
  for (const BuiltinScene& scene : builtin_scenes()) fmt::print("{:<16}{}\n", scene.name, scene.title);
  return 0;
}

}  // namespace runner
