// SPDX-License-Identifier: Apache-2.0
// Where the time that a user waits for goes.
#pragma once

#include <chrono>

namespace runner {

using Clock = std::chrono::steady_clock;

/// Seconds of waiting since then.
inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Adds the time it lives to a sum [s].
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum), start_(Clock::now()) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { sum_ += seconds_since(start_); }

 private:
  double& sum_;
  Clock::time_point start_;
};

/// When the program began.
Clock::time_point program_start();

/// Of one session, in its main thread [s].
struct WallTimes {
  double start_up = 0;  ///< from the start of the program to the first step
  double stepping = 0;  ///< enqueuing steps and waiting for them
  double reading = 0;   ///< sums and particles from the World, after their steps are done
  double writing = 0;   ///< waiting for the thread that writes, and writing checkpoints and run.json
  double surfaces = 0;  ///< of frames that are exported as such
  double pictures = 0;  ///< index.html and still.png at the end
};

}  // namespace runner
