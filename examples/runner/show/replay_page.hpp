// SPDX-License-Identifier: Apache-2.0
// index.html: a run as one self-contained page for any browser.
#pragma once

#include <string>

#include "show/camera.hpp"
#include "show/replay.hpp"

namespace runner {

struct ReplayPage {
  std::string title, note;
  double spacing = 0;  ///< [m]
  Box box;             ///< drawn as edges; grown to hold every particle
  Camera camera;
  std::vector<std::string> bodies;  ///< names
  std::vector<SceneLook> looks;     ///< of materials
  /// Per species the material whose colour what is dissolved of it shows; clear_species of one that it does not show.
  std::vector<std::uint32_t> species;
  std::string stats;        ///< text of stats.csv, for the plots
  std::uint64_t share = 1;  ///< one particle in so many is shown
  int threads = 0;          ///< that pack it, at most; 0: all
};

/// The whole page, below 10 MB: frames are left out until it is, which the page then says.
std::string replay_page(const ReplayPage& page, const std::vector<ReplayFrame>& frames);

extern const char* const replay_template;  ///< show/replay.html

}  // namespace runner
