// SPDX-License-Identifier: Apache-2.0
// Filling an OpenGL buffer on the GPU that simulates, without a detour over the host. Which implementation is
// compiled CMake decides: device_feed_cuda.cu, or device_feed_none.cpp where CUDA is not built in.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "meltsim/world.hpp"

namespace view {

class DeviceFeed {
 public:
  virtual ~DeviceFeed() = default;
  /// Lends the buffer to the GPU's steps. Nothing may draw from it until after_steps().
  virtual void before_steps() = 0;
  /// Takes it back. How many particles were written; 0 when no sub-step ran or they did not fit.
  virtual std::size_t after_steps() = 0;
  virtual std::size_t needed() const = 0;        ///< particles that the World held in its last sub-step
  virtual const std::string& error() const = 0;  ///< empty: all is well
};

struct DeviceFeedResult {
  std::unique_ptr<DeviceFeed> feed;  ///< null: copy instead
  std::string reason;                ///< why it is null
};

/// `buffer`: an OpenGL buffer of `capacity` ParticleVertex, in the context that is current. The feed adds a
/// stage to the World and must be removed, by remove_device_feed, before either of them goes.
DeviceFeedResult make_device_feed(meltsim::World& world, const std::vector<meltsim::MaterialId>& materials,
                                  unsigned buffer, std::size_t capacity);
void remove_device_feed(meltsim::World& world, std::unique_ptr<DeviceFeed>& feed);

}  // namespace view
