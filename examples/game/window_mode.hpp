// SPDX-License-Identifier: Apache-2.0
// The game in a window, where the viewer's libraries were found.
#pragma once

#include "game.hpp"

namespace game {

/// Plays until the window is closed; the exit code of the program.
int run_window(Game& game);

}  // namespace game
