// SPDX-License-Identifier: Apache-2.0
#include "files.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "failure.hpp"

namespace runner {

namespace {

[[noreturn]] void fail(const std::string& path, const char* what) {
  throw Failure(ExitCode::io, fmt::format("{}: cannot be {}: {}", path, what, std::strerror(errno)));
}

}  // namespace

void write_file(const std::string& path, const std::string& content) {
  const std::string temporary = path + ".tmp";
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    if (!file) fail(temporary, "written");
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
    file.close();
    if (!file) {
      const int why = errno;
      std::remove(temporary.c_str());  // half a file helps nobody, least of all on a full disk
      errno = why;
      fail(path, "written");
    }
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail(path, "replaced");
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "read");
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

bool exists(const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

}  // namespace runner
