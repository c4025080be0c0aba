// SPDX-License-Identifier: Apache-2.0
// The particles of a World in an OpenGL buffer: written by the GPU that simulates where that works, else
// copied by way of the host.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "device_feed.hpp"
#include "meltsim/types.hpp"
#include "temperature_table.hpp"

namespace view {

class ParticleFeed {
 public:
  ParticleFeed();
  ~ParticleFeed();
  ParticleFeed(const ParticleFeed&) = delete;
  ParticleFeed& operator=(const ParticleFeed&) = delete;

  /// Another World; the buffer shows it as it is.
  void attach(runner::Built& built);
  /// Brings the buffer up to date with the World.
  void update(runner::Built& built);

  unsigned buffer() const { return buffer_; }
  std::size_t count() const { return count_; }
  const meltsim::Vec3d& origin() const { return origin_; }  ///< vertices are relative to it
  /// "host copy: built without CUDA", for the panel.
  std::string path() const;

 private:
  void reserve(runner::Built& built, std::size_t particles);
  std::size_t convert(const meltsim::StageContext& state);
  std::size_t copy(meltsim::World& world);

  unsigned buffer_ = 0;
  std::size_t capacity_ = 0, count_ = 0;
  meltsim::Vec3d origin_;
  std::unique_ptr<DeviceFeed> device_;
  std::string reason_;
  std::vector<SubstanceCurve> curves_;
  bool failed_ = false;  ///< the GPU could not write the buffer
};

}  // namespace view
