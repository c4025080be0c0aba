// SPDX-License-Identifier: Apache-2.0
// The particles of a World in an OpenGL buffer: written by the GPU that simulates where that works, else
// copied by way of the host.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "build_world.hpp"
#include "device_feed.hpp"
#include "meltsim/types.hpp"

namespace view {

class ParticleFeed {
 public:
  ParticleFeed();
  ~ParticleFeed();  ///< detach() first
  ParticleFeed(const ParticleFeed&) = delete;
  ParticleFeed& operator=(const ParticleFeed&) = delete;

  void attach(runner::Built& built);
  void detach(meltsim::World& world);

  void before_steps();
  /// Brings the buffer up to date. `changed`: the World is not as it was at the last call.
  void after_steps(runner::Built& built, bool changed);

  unsigned buffer() const { return buffer_; }
  std::size_t count() const { return count_; }
  const meltsim::Vec3d& origin() const { return origin_; }  ///< vertices are relative to it
  /// "host copy: built without CUDA", for the panel.
  std::string path() const;

 private:
  void copy(meltsim::World& world);
  void reserve(std::size_t particles);
  void make_device(runner::Built& built);

  unsigned buffer_ = 0;
  std::size_t capacity_ = 0, count_ = 0;
  meltsim::Vec3d origin_;
  std::unique_ptr<DeviceFeed> device_;
  std::string reason_;
  bool on_device_ = false;
};

}  // namespace view
