// SPDX-License-Identifier: Apache-2.0
#include "device_feed.hpp"

namespace view {

DeviceFeedResult make_device_feed(meltsim::World&, const std::vector<meltsim::MaterialId>&, unsigned,
                                  std::size_t) {
  return {nullptr, "built without CUDA"};
}

void remove_device_feed(meltsim::World&, std::unique_ptr<DeviceFeed>& feed) { feed.reset(); }

}  // namespace view
