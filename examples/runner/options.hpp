// SPDX-License-Identifier: Apache-2.0
// What the command line asks for, checked.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "meltsim/types.hpp"

namespace runner {

enum class LogStyle { text, json };
enum class Quality { draft, balanced, accurate };

/// How to compute: `run` and `check` share these.
struct MachineOptions {
  meltsim::Backend backend = meltsim::Backend::automatic;
  meltsim::Precision precision = meltsim::Precision::single_precision;
  int threads = 0;                  ///< 0 = all; at most the processors there are
  std::uint64_t threads_asked = 0;  ///< as typed
};

/// Changes to the scene: `run` and `check` share these.
struct SceneOptions {
  std::string scene;  ///< file or built-in name
  std::vector<std::string> set;
  double scale = 1;  ///< linear resolution factor
  Quality quality = Quality::balanced;
};

struct RunOptions {
  SceneOptions scene;
  MachineOptions machine;
  std::string out;  ///< empty = a new out/<name>-NNN
  std::optional<double> time;
  std::optional<std::uint64_t> frames, steps;
  std::optional<double> fps;
  std::optional<std::vector<std::string>> formats;
  bool resume = false, overwrite = false, quiet = false;
  bool still = true;  ///< still.png, where anything is exported
  bool page = true;   ///< index.html
  LogStyle log = LogStyle::text;
  std::optional<double> max_error;  ///< settings are chosen for it; share of the observable's scale
  std::string of;                   ///< which observable; empty: the scene's first
  double time_limit = 60;           ///< [s] of the probes that tell the settings
  bool cache = true;                ///< of what probes came to
  std::optional<double> budget_ms;  ///< [ms] of computing that a frame may take
  std::string repeat;               ///< directory of a run under a budget, whose sub-steps are taken again
  std::string resume_command;       ///< the command that continues this run, but for --out
};

/// `render`: of what, how, how many.
struct RenderOptions {
  RunOptions run;                 ///< run.scene.scene is the directory, or the scene to run first
  std::string renderer = "auto";  ///< auto, povray or builtin
  std::optional<std::string> look;
  std::optional<int> width, height, samples;
  std::uint64_t frames = 60;  ///< pictures at most; 0 = all
};

/// `trade`: of what, how exactly, how long.
struct TradeOptions {
  SceneOptions scene;
  MachineOptions machine;
  std::vector<std::string> observe;
  std::optional<double> error;  ///< share of the first observable's scale
  std::optional<double> time;   ///< simulated seconds
  double seconds = 60;
  int points = 8;
  std::optional<int> ensemble;  ///< instead of a front: that many starts that are alike
  bool cache = true, support = false;
  bool measure = true;  ///< points of the front are run
  std::string out;      ///< empty = a new out/<name>-trade-NNN
};

/// `validate`: which cases, how, and where to write.
struct ValidateOptions {
  MachineOptions machine;
  std::vector<std::string> filters;
  bool long_cases = false, list = false;
  int draws = 3;                ///< of each case that is drawn at random
  unsigned long long seed = 1;  ///< of those draws
  std::string out;              ///< empty = nothing is written
};

/// `stress`: which cells, where to compute them, and where to write.
struct StressOptions {
  std::vector<meltsim::Backend> backends;  ///< empty: those that are usable
  std::vector<meltsim::Precision> precisions{meltsim::Precision::single_precision,
                                             meltsim::Precision::double_precision};
  std::vector<std::string> filters;  ///< parts of "axis: value"
  bool long_cells = false, list = false;
  std::uint64_t draws = 0, seed = 1;  ///< cells drawn at random instead of those of the map; 0: the map
  std::string out;                    ///< empty = nothing is written
};

}  // namespace runner
