// SPDX-License-Identifier: Apache-2.0
// The thread that writes a run's files while the run goes on.
#pragma once

#include <condition_variable>
#include <cstddef>
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

  /// bytes: of memory that the job holds. Waits while `most_queued` jobs are there and hold more than `most_bytes` with this one. Throws
  /// what an earlier job threw; jobs after that one are not done.
  void push(std::function<void()> job, std::size_t bytes = most_bytes);
  /// Waits until every job is done; throws what one of them threw.
  void finish();
  double busy() const;  ///< [s] spent on jobs so far

  /// One being written and one behind it; more where they are small, since disks stall for longer than a frame takes.
  static constexpr std::size_t most_queued = 2, most_bytes = std::size_t{64} << 20;
  static constexpr std::size_t least_bytes =
      most_bytes / 64;  ///< of any job, so that small ones are no more than 64

 private:
  void work();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  struct Job {
    std::function<void()> work;
    std::size_t bytes;
  };
  std::deque<Job> jobs_;  ///< the first is being done
  std::size_t bytes_ = 0;
  std::exception_ptr failure_;
  bool ending_ = false;
  double busy_ = 0;
  std::thread thread_;
};

}  // namespace runner
