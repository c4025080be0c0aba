// SPDX-License-Identifier: Apache-2.0
// Files that are either whole or not there: written under a temporary name, then renamed.
#pragma once

#include <string>

namespace runner {

void write_file(const std::string& path, const std::string& content);
std::string read_file(const std::string& path);
bool exists(const std::string& path);

}  // namespace runner
