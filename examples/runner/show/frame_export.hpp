// SPDX-License-Identifier: Apache-2.0
// The files of a frame that output.export and --export name.
#pragma once

#include <optional>
#include <set>

#include "build_world.hpp"
#include "checkpoint.hpp"
#include "run_directory.hpp"
#include "show/camera.hpp"
#include "show/shapes.hpp"
#include "show/usd_file.hpp"

namespace runner {

class FrameExport {
 public:
  /// `times` of the frames that were written before a resume.
  FrameExport(const Scene& scene, RunDirectory directory, const std::vector<double>& times);

  /// Whether it needs the particles of a frame at all.
  bool any() const;
  /// Whether it needs surfaces, which only the World can make, at the time of the frame.
  bool wants_shapes() const;
  FrameShapes shapes(meltsim::World& world, double time, const meltsim::ParticleFrame& particles);
  /// `shapes` where wants_shapes(), null otherwise. Touches no World: another thread than the World's may call it.
  void write(std::uint64_t index, double time, const meltsim::ParticleFrame& particles,
             const FrameShapes* shapes);
  /// Why surfaces were replaced by particles, if they were.
  const std::string& problem() const { return problem_; }
  /// Why pictures of frames show nothing, if so; when all is written.
  const std::string& camera_problem() const { return camera_problem_; }

 private:
  bool wants(const char* format) const { return formats_.count(format) > 0; }
  void write_particles(std::uint64_t index, double time, const meltsim::ParticleFrame& particles,
                       const std::vector<std::string>& contents);
  void write_usd(std::uint64_t index, double time, const meltsim::ParticleFrame& particles,
                 const FrameShapes& shapes, const std::vector<std::string>& contents);
  void write_shapes(const FrameShapes& shapes, std::uint64_t index, const std::vector<std::string>& contents);

  const Scene& scene_;
  RunDirectory directory_;
  std::set<std::string> formats_;
  std::vector<std::pair<double, std::string>> vtp_frames_;
  UsdRun usd_;
  std::optional<std::uint64_t> usd_first_;  ///< the frame that scene.usda begins with
  UsdBounds usd_before_;                    ///< of the last frame that was written
  std::string problem_;
  std::string camera_problem_;  ///< of write(), which another thread calls
};

/// The coldest and the warmest that the scene itself names: colours that stay the same from frame to frame.
std::pair<double, double> temperature_range(const Scene& scene);

}  // namespace runner
