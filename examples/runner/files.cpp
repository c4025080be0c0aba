// SPDX-License-Identifier: Apache-2.0
#include "files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

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

int OpenFile::write(std::string_view text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t written = ::write(descriptor_, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return errno;
    done += static_cast<std::size_t>(written);
  }
  return 0;
}

int OpenFile::close() {
  const int descriptor = std::exchange(descriptor_, -1);
  return descriptor < 0 || ::close(descriptor) == 0 ? 0 : errno;
}

namespace {

/// Under the temporary name. `put` writes the content; 0, or why not (errno).
template <class Put>
OpenFile write_temporary(const std::string& temporary, const std::string& path, const Put& put,
                         bool stays_open) {
  OpenFile file(open_new(temporary));
  int why = put(file);
  const int closed = why != 0 || !stays_open ? file.close() : 0;
  if (why == 0) why = closed;
  if (why != 0) {
    std::remove(temporary.c_str());  // half a file helps nobody, least of all on a full disk
    errno = why;
    fail(path, "written");
  }
  return file;
}

template <class Put>
OpenFile write_whole(const std::string& path, const Put& put, bool stays_open) {
  const std::string temporary = path + ".tmp";
  OpenFile file = write_temporary(temporary, path, put, stays_open);
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail(path, "replaced");
  return file;
}

}  // namespace

void write_file(const std::string& path, const std::string& content) {
  write_whole(
      path, [&content](OpenFile& file) { return file.write(content); }, false);
}

void write_file(const std::string& path, const std::function<void(std::string&)>& next) {
  const auto put = [&next](OpenFile& file) {
    std::string part;
    for (next(part); !part.empty(); next(part)) {
      if (const int why = file.write(part); why != 0) return why;
      part.clear();  // keeps its memory
    }
    return 0;
  };
  write_whole(path, put, false);
}

OpenFile replace_file(const std::string& path, const std::string& content) {
  return write_whole(
      path, [&content](OpenFile& file) { return file.write(content); }, true);
}

int open_new(const std::string& path) {
  // What is left of a killed run, or a link that somebody planted: the link goes, not the file that it names.
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail(path, "replaced");
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file < 0) fail(path, "written");
  return file;
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "read");
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

void make_directories(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw Failure(ExitCode::io, fmt::format("{}: cannot be made: {}", path, error.message()));
}

bool exists(const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

}  // namespace runner
