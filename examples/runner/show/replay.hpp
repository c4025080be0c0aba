// SPDX-License-Identifier: Apache-2.0
// What a run keeps of its frames for index.html: few enough particles and frames for a page of some
// megabytes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "particle_files.hpp"

namespace runner {

struct ReplayParticle {
  std::uint32_t id;
  float position[3];  ///< [m]
  float temperature;  ///< [degrees Celsius]
  /// Low byte: 128 if solid, plus 1 + body (bodies past the 127th share), 0 = of no body. Next: the material; then
  /// what is dissolved, 5 bits for each species, 31 = nothing else.
  std::uint32_t look;
};

struct ReplayFrame {
  double time = 0;  ///< [s]
  std::uint64_t index = 0;
  std::vector<ReplayParticle> particles;  ///< in order of id
};

/// Keeps every `every()`-th frame, and of each the particles that a hash of their id picks, one in `share()`.
/// Both double when the budget is used up, so what is kept depends on the frames only, not on interruptions.
class Replay {
 public:
  /// `planned_frames` saves copying frames that would be dropped later; 0 = not known.
  explicit Replay(std::uint64_t planned_frames = 0, std::uint64_t particles = 0);

  bool wants(std::uint64_t index) const { return index % every_ == 0; }
  void add(std::uint64_t index, double time, const meltsim::ParticleFrame& particles);
  /// The frame a run ends with, kept or not.
  ReplayFrame picked(std::uint64_t index, double time, const meltsim::ParticleFrame& particles) const;

  const std::vector<ReplayFrame>& frames() const { return frames_; }
  std::uint64_t every() const { return every_; }
  std::uint64_t share() const { return share_; }
  std::size_t particles() const;  ///< of all frames together

  /// For a run that is interrupted. `load` drops frames later than `time` and leaves an empty replay when
  /// there is nothing that can be read: a page with a gap is better than a run that does not resume.
  void save(const std::string& path, int threads) const;
  bool load(const std::string& path, double time);

 private:
  void thin();

  std::vector<ReplayFrame> frames_;
  std::uint64_t every_ = 1, share_ = 1;
};

}  // namespace runner
