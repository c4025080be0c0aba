// SPDX-License-Identifier: Apache-2.0
// Files that are either whole or not there: written under a temporary name, then renamed.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace runner {

/// Replaces what has this name, a symbolic link as well; a file that a link names is never written to.
void write_file(const std::string& path, const std::string& content);
/// The same of content that is made part by part, so that all of it never lies in memory: `next` appends a part to an empty
/// string, and nothing when there is no more.
void write_file(const std::string& path, const std::function<void(std::string&)>& next);
/// An open file; closed when it goes.
class OpenFile {
 public:
  OpenFile() = default;
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  OpenFile(OpenFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { close(); }
  int write(std::string_view text);  ///< all of it, behind what was written; 0, or why not (errno)
  int close();                       ///< 0, or why what was written may not be there (errno)

 private:
  int descriptor_ = -1;
};

/// write_file(), and leaves the file open for more.
OpenFile replace_file(const std::string& path, const std::string& content);
/// A descriptor of a file that was not there before, for writing; what has this name is removed first.
int open_new(const std::string& path);
std::string read_file(const std::string& path);
bool exists(const std::string& path);
/// Makes a directory and those above it; nothing where it is there already.
void make_directories(const std::string& path);

}  // namespace runner
