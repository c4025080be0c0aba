// SPDX-License-Identifier: Apache-2.0
// What makes a run seen: index.html, written when it ends however it ends.
#pragma once

#include <future>
#include <memory>

#include "build_world.hpp"
#include "checkpoint.hpp"
#include "run_directory.hpp"
#include "show/camera.hpp"
#include "show/replay.hpp"
#include "show/shapes.hpp"

namespace runner {

class RunPictures {
 public:
  /// `resumed`: goes on with what the interrupted run kept in replay.bin.
  RunPictures(const Scene& scene, RunDirectory directory, Built& built, std::uint64_t planned_frames,
              const RunState* resumed);

  /// Every so many-th frame is kept; others need no particles from the World.
  std::uint64_t every() const { return replay_.every(); }
  void frame(std::uint64_t index, double time, const meltsim::ParticleFrame& particles);
  /// With the checkpoint: what a resumed run needs.
  void save() const;
  /// still.png of a frame, drawn in a thread of its own: other files, and with them the steps, do not wait for it. Touches no World:
  /// another thread than the World's may call it.
  void still(std::shared_ptr<const FrameShapes> shapes);
  /// What a run ends with: index.html and still.png, those that are asked for. Waits for still(), and fails where that did.
  void finish(meltsim::World& world, const RunState& state, bool page, bool still);
  /// Why the still is not what it should be, if so.
  const std::string& problem() const { return problem_; }

 private:
  void write_page(std::vector<ReplayFrame> frames, const Box& seen, const RunState& state) const;
  void write_still(const FrameShapes& shapes, const Box& seen);

  const Scene& scene_;
  RunDirectory directory_;
  Replay replay_;
  std::string problem_;
  std::future<void> drawing_;  ///< still(); the last member: it ends before what it uses
};

}  // namespace runner
