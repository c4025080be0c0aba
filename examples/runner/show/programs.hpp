// SPDX-License-Identifier: Apache-2.0
// Other programs that pictures may be made with. None of them is needed.
#pragma once

#include <string>
#include <vector>

namespace runner {

/// Where a program is in PATH, or empty.
std::string find_program(const std::string& name);
/// Runs it and waits; everything it says goes to the file `log`. Returns its exit status, 128 + n for signal
/// n, 127 when it could not be started.
int run_program(const std::vector<std::string>& arguments, const std::string& log);

}  // namespace runner
