// SPDX-License-Identifier: Apache-2.0
// Everything a run writes while it runs, apart from run.json and the checkpoint.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "build_world.hpp"
#include "checkpoint.hpp"
#include "csv.hpp"
#include "run_directory.hpp"
#include "show/frame_export.hpp"
#include "show/run_pictures.hpp"
#include "tables.hpp"

namespace runner {

/// What has melted and not frozen again; 0 when more froze than melted.
inline std::uint64_t net_melted(std::uint64_t melted, std::uint64_t frozen) {
  return melted > frozen ? melted - frozen : 0;
}

class Recorder {
 public:
  /// `resumed`: goes on with the tables in the directory from this state's time.
  /// `planned_frames` is a guess for pictures, 0 = not known.
  Recorder(const Scene& scene, RunDirectory directory, Built& built, std::uint64_t planned_frames,
           const RunState* resumed);

  /// One row of stats.csv, the bodies, and the exported files of frame state.next_frame.
  void frame(Built& built, const RunState& state, double dt, double ms_per_step);
  /// Samples every probe for which a sample came due after `since`; one answers all that did.
  void probes(meltsim::World& world, double since, double now);
  /// When the next sample is due; infinite without probes.
  double next_probe(double now) const;
  void flush();
  /// flush(), and what pictures need to go on after a resume.
  void save();
  /// The pictures a run ends with.
  void finish(meltsim::World& world, const RunState& state);
  /// What went wrong with surfaces, if anything did.
  const std::string& problem() const;

  const StatsRow& last() const { return last_; }
  bool anything_left_to_melt() const { return meltable_left_ > 0; }
  std::uint64_t meltable_left() const { return meltable_left_; }

 private:
  void write_bodies(Built& built, double time);
  void write_particles(meltsim::World& world, const RunState& state);

  const Scene& scene_;
  RunDirectory directory_;
  std::vector<std::string> kept_stats_;  ///< rows from before a resume
  CsvFile stats_, bodies_;
  std::optional<CsvFile> probes_;
  FrameExport export_;
  RunPictures pictures_;
  StatsRow last_;
  std::uint64_t meltable_left_ = 0;
};

}  // namespace runner
