// SPDX-License-Identifier: Apache-2.0
// Where a run writes. Nothing is ever deleted: a new directory per run unless the user names one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace runner {

struct RunDirectory {
  std::string path;
  std::string file(const std::string& name) const { return path + "/" + name; }
  std::string frame(const std::string& what, std::uint64_t index, const std::string& extension) const;
};

/// frames/particles_00012.ply, relative to the run directory.
std::string frame_file(const std::string& what, std::uint64_t index, const std::string& extension);
/// "particles_00012.ply" -> 12
std::optional<std::int64_t> frame_number(const std::string& file);

/// out/<name>-001, -002, ... under the current directory.
RunDirectory new_run_directory(const std::string& name);
/// The path that it would have now.
std::string fresh_run_directory(const std::string& name);
/// Fails when --out DIR exists: said before a long build, not after it.
void refuse_existing(const std::string& path);
/// --out DIR.
RunDirectory named_run_directory(const std::string& path);
/// --out DIR --resume: refused when there is no checkpoint in it.
RunDirectory resumed_run_directory(const std::string& path);
/// Frame files of an earlier, longer run that this one did not replace.
std::size_t stale_frames(const RunDirectory& directory, std::uint64_t last_frame);

}  // namespace runner
