// SPDX-License-Identifier: Apache-2.0
// Files that are either whole or not there: written under a temporary name, then renamed.
#pragma once

#include <string>

namespace runner {

/// Replaces what has this name, a symbolic link as well; a file that a link names is never written to.
void write_file(const std::string& path, const std::string& content);
/// A descriptor of a file that was not there before, for writing; what has this name is removed first.
int open_new(const std::string& path);
std::string read_file(const std::string& path);
bool exists(const std::string& path);

}  // namespace runner
