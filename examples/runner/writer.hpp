// SPDX-License-Identifier: Apache-2.0
// The thread that writes a run's files while the run goes on.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace runner {

/// Jobs are done one after another, in the order they came. The thread sleeps while there are none.
class Writer {
 public:
  Writer();
  ~Writer();  ///< waits for the jobs; what fails then is not heard of
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Waits while `most_queued` jobs are. Throws what an earlier job threw; jobs after that one are not done.
  void push(std::function<void()> job);
  /// Waits until every job is done; throws what one of them threw.
  void finish();
  double busy() const;  ///< [s] spent on jobs so far

  /// One being written and one behind it: more would only hold memory.
  static constexpr std::size_t most_queued = 2;

 private:
  void work();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;  ///< the first is being done
  std::exception_ptr failure_;
  bool ending_ = false;
  double busy_ = 0;
  std::thread thread_;
};

}  // namespace runner
