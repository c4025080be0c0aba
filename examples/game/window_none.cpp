// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "window_mode.hpp"

namespace game {

int run_window(Game&) {
  std::fprintf(stderr,
               "game: --window: this build has no window; build with the viewer (MELTSIM_BUILD_VIEWER)\n");
  return 1;
}

}  // namespace game
