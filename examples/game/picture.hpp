// SPDX-License-Identifier: Apache-2.0
// A picture of the game by the runner's renderer, where that is built.
#pragma once

#include <string>

#include "game.hpp"

namespace game {

/// Writes a PNG. Returns why not; empty: it did.
std::string write_picture(Game& game, const std::string& path);

}  // namespace game
