// SPDX-License-Identifier: Apache-2.0
// What the program says while it runs: plain lines or JSON objects, with progress on one line of a terminal.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "options.hpp"
#include "scene.hpp"

namespace runner {

struct Progress {
  double done = 0;                   ///< 0..1
  double time = 0, end = 0, dt = 0;  ///< [s]; end is infinite when a number of steps was asked for
  std::uint64_t steps = 0, fluid = 0, solid = 0;
  std::optional<double> melted;  ///< 0..1; nothing where nothing can melt
  double ms_per_step = 0;
  double real_time_ratio = 0;  ///< simulated seconds per second of waiting
  double eta = 0;              ///< [s]
};

class Log {
 public:
  Log(LogStyle style, bool quiet);
  void info(const std::string& message, const Json& fields = Json::object());
  /// Said once per text; repeated in run.json.
  void warn(const std::string& message);
  /// Always said, on stderr: an error, or what `event` calls it.
  void error(const std::string& message, const std::string& event = "error");
  void progress(const Progress& progress);  ///< shown when it is time to
  void end_progress(const Progress& progress);
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  using Clock = std::chrono::steady_clock;
  void line(const std::string& text);
  void show(const Progress& progress);
  void clear_line();

  LogStyle style_;
  bool quiet_, terminal_;
  bool line_open_ = false;
  Clock::time_point last_shown_;
  Progress shown_;
  std::vector<std::string> warnings_;
};

std::string progress_text(const Progress& progress);
/// The same with a bar, in at most `columns` (80 where there are more).
std::string progress_bar(const Progress& progress, std::size_t columns);

}  // namespace runner
