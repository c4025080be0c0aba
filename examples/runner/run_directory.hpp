// SPDX-License-Identifier: Apache-2.0
// Where a run writes. Nothing is ever deleted: a new directory per run unless the user names one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace runner {

/// The right to write to a directory. The system takes it back when the process ends, however that ends, so none is ever
/// stale. Where the file system knows no locks there is no protection.
class DirectoryLock {
 public:
  /// Fails when another process writes there; `what` names that process in the message, e.g. "another run".
  DirectoryLock(const std::string& directory, const std::string& what);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  int file_ = -1;
};

struct RunDirectory {
  std::string path;
  std::shared_ptr<const DirectoryLock> lock{};  ///< held by a run, not by what only reads
  std::string file(const std::string& name) const { return path + "/" + name; }
  std::string frame(const std::string& what, std::uint64_t index, const std::string& extension) const;
  void make_frames() const;  ///< the directory that frame() names; what writes no frames has none
};

/// In the directory of a run: its scene as it came from standard input, so that the run can be resumed.
inline constexpr const char* stdin_scene = "stdin.yaml";

/// frames/particles_00012.ply, relative to the run directory.
std::string frame_file(const std::string& what, std::uint64_t index, const std::string& extension);
/// "particles_00012.ply" -> 12, "scene.00012.usda" -> 12
std::optional<std::int64_t> frame_number(const std::string& file);

/// out/<name>-001, -002, ... under the current directory.
RunDirectory new_run_directory(const std::string& name);
/// The path that it would have now.
std::string fresh_run_directory(const std::string& name);
/// Fails when --out DIR exists: said before a long build, not after it.
void refuse_existing(const std::string& path, const std::string& cure =
                                                  "name another directory, or add --overwrite to write "
                                                  "over it or --resume to continue the run in it");
/// --out DIR. This and the two others lock the directory.
RunDirectory named_run_directory(const std::string& path);
/// --out DIR --resume: refused when there is no checkpoint in it.
RunDirectory resumed_run_directory(const std::string& path);
/// Files of frames of an earlier run that this one, of these formats (output.export), did not replace.
std::size_t stale_frames(const RunDirectory& directory, std::uint64_t last_frame,
                         const std::vector<std::string>& formats);

}  // namespace runner
