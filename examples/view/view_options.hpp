// SPDX-License-Identifier: Apache-2.0
// The command line of meltsim-view.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "color_map.hpp"
#include "options.hpp"

namespace view {

struct ViewOptions {
  runner::SceneOptions scene;
  runner::MachineOptions machine;
  int width = 1280, height = 800;  ///< of the window
  std::optional<ColorBy> color;
  bool paused = false, panel = true;
  std::string screenshot;               ///< PNG to write, then to end
  std::optional<double> after;          ///< simulated seconds until then
  std::optional<std::uint64_t> frames;  ///< or frames of the scene
  /// Pictures are to come out the same on every machine: frames are then as long as the scene says.
  bool scripted() const { return after || frames; }
};

/// Nothing when help or the version was asked for and has been given. Throws runner::Failure (code 1).
std::optional<ViewOptions> parse_view_options(int argc, char** argv);

}  // namespace view
