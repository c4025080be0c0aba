// SPDX-License-Identifier: Apache-2.0
// Other programs that pictures may be made with. None of them is needed.
#pragma once

#include <string>
#include <vector>

namespace runner {

/// A private directory for the files of another program. Programs are run in it on names that are written in this source,
/// because to gnuplot, POV-Ray or ffmpeg a path that a user chose can be more than a path: a command, a pipe, an option, a
/// protocol. It goes with all its files when it goes out of scope.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  /// Moves a file out of it; replaces what is there.
  void take(const std::string& name, const std::string& to) const;
  /// Makes a directory or file elsewhere readable under a name in it.
  void link(const std::string& name, const std::string& to) const;

 private:
  std::string path_;
};

/// The file in the scratch directory that holds what the program said.
inline constexpr const char* program_log = "log.txt";

/// Absolute path of a program in PATH, or empty.
std::string find_program(const std::string& name);
/// Runs a program in the scratch directory and waits. Returns its exit status, 128 + n for signal n, 127 when it could not
/// be started.
int run_program(const std::vector<std::string>& arguments, const Scratch& scratch);

}  // namespace runner
