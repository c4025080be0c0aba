// SPDX-License-Identifier: Apache-2.0
#include "run_directory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

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

}  // namespace

std::optional<std::int64_t> frame_number(const std::string& file) {
  const std::size_t dot = file.find('.'), line = file.rfind('_', dot);
  if (dot == std::string::npos || line == std::string::npos || dot - line < 6) return std::nullopt;
  return parse_integer(file.substr(line + 1, dot - line - 1));
}

std::string frame_file(const std::string& what, std::uint64_t index, const std::string& extension) {
  return fmt::format("frames/{}_{:05}.{}", what, index, extension);
}

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
    if (fresh) {
      make(fs::path(path) / "frames");
      return {path};
    }
  }
}

std::string fresh_run_directory(const std::string& name) {
  for (int number = 1;; ++number) {
    const std::string path = fmt::format("out/{}-{:03}", name, number);
    if (!exists(path)) return path;
  }
}

void refuse_existing(const std::string& path) {
  if (!exists(path)) return;
  throw Failure(ExitCode::io,
                fmt::format("{}: exists already; name another directory, or add --overwrite to write "
                            "over it or --resume to continue the run in it",
                            path));
}

RunDirectory named_run_directory(const std::string& path) {
  make(fs::path(path) / "frames");
  return {path};
}

RunDirectory resumed_run_directory(const std::string& path) {
  if (!exists(path)) throw Failure(ExitCode::io, path + ": there is no such directory to resume");
  const RunDirectory directory{path};
  if (!exists(directory.file("checkpoint.bin"))) {
    throw Failure(ExitCode::io, fmt::format("{}: holds no checkpoint.bin; only runs that were stopped, that "
                                            "diverged or that ran for a minute leave one",
                                            path));
  }
  make(fs::path(path) / "frames");
  return directory;
}

std::size_t stale_frames(const RunDirectory& directory, std::uint64_t last_frame) {
  std::size_t count = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory.file("frames"), error)) {
    const auto number = frame_number(entry.path().filename().string());
    if (number && *number > static_cast<std::int64_t>(last_frame)) ++count;
  }
  return count;
}

}  // namespace runner
