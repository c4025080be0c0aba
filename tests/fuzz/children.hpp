// SPDX-License-Identifier: Apache-2.0
// Runs numbered cases in child processes, so that a crash or a hang of one is a finding and not the end of the run.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace fuzz {

/// What a case is doing; shared between the child that runs it and the parent that watches.
struct Progress {
  volatile std::uint64_t item = 0;  ///< case under way
  volatile std::uint64_t done = 0;  ///< cases that ended well in this child
  volatile std::uint64_t calls =
      0;                 ///< rises with every call of the library, so a hang is told from a long case
  char what[1024] = {};  ///< the last call, for the report of a crash
};

struct Options {
  std::uint64_t first = 0, count = 1000;
  double seconds = 0;        ///< ends the run after this long; 0 = when all cases are done
  double hang_seconds = 60;  ///< a call that takes longer is a hang
  std::uint64_t per_child = 50;
  bool here = false;  ///< in this process: for a debugger, or a checker that does not follow children
};

/// Outcome of one case: empty, or what was violated.
using Case = std::function<std::string(std::uint64_t item, Progress& progress)>;

/// Parses --cases N, --first K, --seconds S, --hang S, --here 0|1; leaves the other arguments to `other` (name, value), which
/// returns false for names it does not know. False: the usage was printed.
bool parse(int argc, char** argv, Options& options,
           const std::function<bool(const std::string&, const std::string&)>& other, const char* usage);

/// Runs the cases; prints findings and a closing line. Returns the exit status: 0 without findings, 1 with.
int run(const Options& options, const Case& one);

}  // namespace fuzz
