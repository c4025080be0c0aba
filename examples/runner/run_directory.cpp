// SPDX-License-Identifier: Apache-2.0
#include "run_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>

#include "failure.hpp"
#include "files.hpp"
#include "numbers.hpp"

namespace runner {

namespace fs = std::filesystem;

namespace {

void make(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error)
    throw Failure(ExitCode::io, fmt::format("{}: cannot be created: {}", path.string(), error.message()));
}

RunDirectory locked(const std::string& path) {
  return {path, std::make_shared<DirectoryLock>(path, "another run")};
}

/// The first line of an open file.
std::string line_of(int file) {
  char text[200];
  const ssize_t size = pread(file, text, sizeof text, 0);
  const std::string all(text, size > 0 ? static_cast<std::size_t>(size) : 0);
  return all.substr(0, all.find('\n'));
}

/// Of output.export, which wrote a file of a frame; empty: none did.
std::string format_of(const std::string& file) {
  static const struct {
    const char *what, *extension, *format;
  } files[] = {{"particles", "ply", "ply"}, {"particles", "vtp", "vtp"}, {"liquid", "ply", "surface"},
               {"solid", "ply", "surface"}, {"liquid", "obj", "obj"},    {"solid", "obj", "obj"},
               {"surface", "glb", "glb"},   {"scene", "usda", "usd"},    {"scene", "pov", "pov"},
               {"picture", "png", "png"}};
  const std::string what = file.substr(0, file.find_first_of("_.")),
                    extension = file.substr(file.rfind('.') + 1);
  for (const auto& known : files)
    if (what == known.what && extension == known.extension) return known.format;
  return "";
}

}  // namespace

DirectoryLock::DirectoryLock(const std::string& directory, const std::string& what) {
  const std::string path = directory + "/.lock";
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK, 0666);
  struct stat about {};
  if (file_ < 0 || fstat(file_, &about) != 0 || !S_ISREG(about.st_mode)) {
    const int why = file_ < 0 ? errno : EINVAL;
    if (file_ >= 0) ::close(file_);
    throw Failure(ExitCode::io, fmt::format("{}: cannot be opened: {}", path, std::strerror(why)));
  }
  if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return;  // a file system without locks
    const std::string who = line_of(file_);
    ::close(file_);
    throw Failure(ExitCode::io,
                  fmt::format("{}: {} is writing there{}; wait until it has ended, or name another directory",
                              directory, what, who.empty() ? "" : " (" + who + ")"));
  }
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  const std::string us = fmt::format("process {} on {}\n", getpid(), host);
  // Only for the message; a full disk is found out where it matters.
  if (ftruncate(file_, 0) == 0 && pwrite(file_, us.data(), us.size(), 0) < 0) return;
}

DirectoryLock::~DirectoryLock() { ::close(file_); }

std::optional<std::int64_t> frame_number(const std::string& file) {
  const std::size_t dot = file.rfind('.'), line = dot > 0 ? file.find_last_of("_.", dot - 1) : dot;
  if (dot == std::string::npos || line == std::string::npos || dot - line < 6) return std::nullopt;
  return parse_integer(file.substr(line + 1, dot - line - 1));
}

std::string frame_file(const std::string& what, std::uint64_t index, const std::string& extension) {
  return fmt::format("frames/{}_{:05}.{}", what, index, extension);
}

void RunDirectory::make_frames() const { make(fs::path(path) / "frames"); }

std::string RunDirectory::frame(const std::string& what, std::uint64_t index,
                                const std::string& extension) const {
  return file(frame_file(what, index, extension));
}

RunDirectory new_run_directory(const std::string& name) {
  make("out");
  for (int number = 1;; ++number) {
    const std::string path = fmt::format("out/{}-{:03}", name, number);
    std::error_code error;
    // create_directory says whether it was new, so two runs started at once get one each.
    const bool fresh = fs::create_directory(path, error);
    if (error && !fs::exists(path)) {
      throw Failure(ExitCode::io, fmt::format("{}: cannot be created: {}", path, error.message()));
    }
    if (fresh) return locked(path);
  }
}

std::string fresh_run_directory(const std::string& name) {
  for (int number = 1;; ++number) {
    const std::string path = fmt::format("out/{}-{:03}", name, number);
    if (!exists(path)) return path;
  }
}

void refuse_existing(const std::string& path, const std::string& cure) {
  if (!exists(path)) return;
  throw Failure(ExitCode::io, fmt::format("{}: exists already; {}", path, cure));
}

RunDirectory named_run_directory(const std::string& path) {
  make(path);
  return locked(path);
}

RunDirectory resumed_run_directory(const std::string& path) {
  if (!exists(path)) throw Failure(ExitCode::io, path + ": there is no such directory to resume");
  // A run that is going on there has no checkpoint yet, and is what to say.
  std::optional<RunDirectory> directory;
  if (exists(path + "/.lock")) directory = locked(path);
  if (!exists(path + "/checkpoint.bin")) {
    throw Failure(ExitCode::io, fmt::format("{}: holds no checkpoint.bin; only runs that were stopped, that "
                                            "diverged or that ran for a minute leave one",
                                            path));
  }
  return directory ? *directory : locked(path);
}

std::size_t stale_frames(const RunDirectory& directory, std::uint64_t last_frame,
                         const std::vector<std::string>& formats) {
  std::size_t count = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory.file("frames"), error)) {
    const std::string name = entry.path().filename().string();
    const auto number = frame_number(name);
    const std::string format = format_of(name);
    if (!number || format.empty()) continue;
    const bool written = std::count(formats.begin(), formats.end(), format) > 0;
    if (!written || *number > static_cast<std::int64_t>(last_frame)) ++count;
  }
  return count;
}

}  // namespace runner
