// SPDX-License-Identifier: Apache-2.0
#include "writer.hpp"

#include <algorithm>
#include <utility>

#include "wall_times.hpp"

namespace runner {

Writer::Writer() : thread_([this] { work(); }) {}

Writer::~Writer() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Writer::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    if (!failure_) {
      const std::function<void()> job = std::move(jobs_.front().work);
      lock.unlock();
      std::exception_ptr failure;
      double took = 0;
      try {
        const Stopwatch watch(took);
        job();
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      busy_ += took;
      failure_ = failure;
    }
    bytes_ -= jobs_.front().bytes;
    jobs_.pop_front();
    changed_.notify_all();
  }
}

void Writer::push(std::function<void()> job, std::size_t bytes) {
  bytes = std::max(bytes, least_bytes);
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(
      lock, [this, bytes] { return failure_ || jobs_.size() < most_queued || bytes_ + bytes <= most_bytes; });
  if (failure_) std::rethrow_exception(failure_);
  jobs_.push_back({std::move(job), bytes});
  bytes_ += bytes;
  changed_.notify_all();
}

void Writer::finish() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return failure_ || jobs_.empty(); });
  if (failure_) std::rethrow_exception(failure_);
}

double Writer::busy() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return busy_;
}

}  // namespace runner
