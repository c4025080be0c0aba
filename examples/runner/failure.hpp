// SPDX-License-Identifier: Apache-2.0
// How the runner gives up: one exception with the message for the user and the exit code for scripts.
#pragma once

#include <stdexcept>
#include <string>

namespace runner {

enum class ExitCode { ok = 0, usage = 1, scene = 2, diverged = 3, device = 4, io = 5 };

class Failure : public std::runtime_error {
 public:
  Failure(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace runner
