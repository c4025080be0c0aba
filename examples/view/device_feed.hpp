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
  /// Writes a vertex for each particle of World::device_state(), behind the steps that it stands for; waits for nothing.
  /// OpenGL commands that follow come after it. False: error() says why.
  virtual bool write(const meltsim::StageContext& state) = 0;
  virtual const std::string& error() const = 0;  ///< empty: all is well
};

struct DeviceFeedResult {
  std::unique_ptr<DeviceFeed> feed;  ///< null: copy instead
  std::string reason;                ///< why it is null
};

/// `buffer`: an OpenGL buffer in the context that is current, which must outlive the feed and have room for every
/// particle that is written.
DeviceFeedResult make_device_feed(const meltsim::World& world,
                                  const std::vector<meltsim::MaterialId>& materials, unsigned buffer);

}  // namespace view
