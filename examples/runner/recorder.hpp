// SPDX-License-Identifier: Apache-2.0
// Everything a run writes while it runs, apart from run.json and the checkpoint.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "build_world.hpp"
#include "checkpoint.hpp"
#include "csv.hpp"
#include "probes.hpp"
#include "run_directory.hpp"
#include "show/frame_export.hpp"
#include "show/run_pictures.hpp"
#include "tables.hpp"
#include "writer.hpp"

namespace runner {

/// What has melted and not frozen again; 0 when more froze than melted.
inline std::uint64_t net_melted(std::uint64_t melted, std::uint64_t frozen) {
  return melted > frozen ? melted - frozen : 0;
}

/// What the tables say of one frame.
struct Frame {
  std::uint64_t index = 0;
  StatsRow row;
  std::vector<meltsim::PieceInfo> pieces;
};

/// Works out rows in the thread of the World, and writes everything in a thread of its own. Whatever an earlier frame's
/// files failed with is thrown by the next call that writes.
class Recorder {
 public:
  using Samples = std::vector<meltsim::ProbeSeries>;

  /// `resumed`: goes on with the tables in the directory from this state's time.
  /// `planned_frames` is a guess for pictures, 0 = not known. `still` and `page`: whether still.png and index.html are wanted.
  Recorder(const Scene& scene, RunDirectory directory, Built& built, std::uint64_t planned_frames,
           const RunState* resumed, bool still, bool page);

  /// Whether write() needs the particles of frame `index`.
  bool wants_particles(std::uint64_t index) const;
  /// Whether write() needs the World as it is at a frame, so that no step may be taken before.
  bool wants_world(std::uint64_t index) const { return export_.wants_shapes() || index == still_frame_; }
  /// Whether wants_world() is known only when the steps of a frame are done.
  bool decides_at_frames() const { return still_ && few_frames_; }
  /// Chooses the frame that still.png shows. `counted` is the frame that last() is of, `ahead` the first one whose steps have not been
  /// taken yet. Called for every frame, so that what is chosen follows from the frames.
  void choose_still(std::uint64_t counted, std::uint64_t ahead);
  /// Molten share of the frame that still.png shows, of a run of few frames; for the checkpoint.
  std::optional<double> still_share() const { return still_share_; }
  /// What a frame comes to. `row` has step, time, dt and ms_per_step, the reading totals and pieces. From then on the
  /// frame is last(). Frames come in order.
  Frame count(const Built& built, std::uint64_t index, StatsRow row, meltsim::Reading reading,
              std::uint64_t meltable);
  /// Its row of stats.csv, its bodies, the probes since the last frame and its exported files. `particles` where
  /// wants_particles(), `shapes` from shapes().
  void write(Frame frame, meltsim::ParticleFrame particles, Samples samples,
             std::shared_ptr<const FrameShapes> shapes);
  /// Surfaces of a frame, from the World as it is; null where wants_world() is false.
  std::shared_ptr<const FrameShapes> shapes(meltsim::World& world, const meltsim::ParticleFrame& particles,
                                            std::uint64_t index, double time);
  /// Writes what a resumed run needs, the checkpoint behind everything that it counts on.
  void save(Checkpoint checkpoint, Samples samples);
  /// Waits until everything is written.
  void finish();
  /// The pictures a run ends with. `ended`: it will not be resumed, so that a still of its end is of use.
  void pictures(meltsim::World& world, const RunState& state, bool ended);
  /// What went wrong with surfaces and pictures, each once; after finish().
  std::set<std::string> problems() const;

  const StatsRow& last() const { return last_; }
  bool anything_left_to_melt() const { return meltable_left_ > 0; }
  std::uint64_t meltable_left() const { return meltable_left_; }
  double busy() const { return writer_.busy(); }  ///< [s] of the thread that writes

 private:
  void flush();

  const Scene& scene_;
  RunDirectory directory_;
  ProbeTable probe_table_;
  std::vector<std::string> kept_stats_;  ///< rows from before a resume
  StatsRow last_;
  std::uint64_t meltable_left_ = 0;
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  bool still_ = true;        ///< still.png is wanted
  bool page_ = true;         ///< index.html is
  bool wants_still_ = true;  ///< still.png is wanted and its frame has not been chosen yet
  bool few_frames_ = false;  ///< two frames may lie between a scene that has not begun and one that is over
  std::optional<double> still_share_;  ///< see still_share()
  std::uint64_t still_frame_ = none;
  std::atomic<std::uint64_t> replay_every_{1};
  // The writer's, while it runs.
  CsvFile stats_, bodies_, probes_;
  FrameExport export_;
  RunPictures pictures_;
  Writer writer_;  ///< the last member: its thread ends before what it writes
};

}  // namespace runner
