// SPDX-License-Identifier: Apache-2.0
// `meltsim new NAME`: a commented scene to start from.
#include <fmt/format.h>

#include <filesystem>

#include "commands.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "option_values.hpp"
#include "template_scene.hpp"

namespace runner {

int cmd_new(const std::string& name) {
  const std::filesystem::path given(name);
  if (given.filename().empty())
    throw Failure(ExitCode::usage, "NAME: expected the name of a file to write, got \"" + name + "\"");
  const bool has_ending = given.extension() == ".yaml" || given.extension() == ".yml";
  const std::string path = has_ending ? name : name + ".yaml";
  if (exists(path))
    throw Failure(ExitCode::io, path + ": exists already and is left as it is; choose another name");
  write_file(path, template_scene);
  const std::string typed = shell_quoted(path[0] == '-' ? "./" + path : path);
  fmt::print("wrote {}\ncheck it: meltsim check {}\nrun it:   meltsim run {}\n", path, typed, typed);
  return 0;
}

}  // namespace runner
