// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <vector>

#include "failure.hpp"
#include "writer.hpp"

namespace runner {
namespace {

TEST(Writer, DoesJobsInOrderAndFinishWaitsForThem) {
  std::vector<int> done;
  Writer writer;
  for (int i = 0; i < 100; ++i) writer.push([&done, i] { done.push_back(i); });
  writer.finish();
  ASSERT_EQ(done.size(), 100u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

/// Jobs that are taken before the first one is done, and `more` that have to wait.
void expect_taken(std::size_t jobs, std::size_t more, std::size_t bytes) {
  std::promise<void> go;
  const std::shared_future<void> gone = go.get_future().share();
  std::atomic<std::size_t> pushed{0};
  Writer writer;
  std::thread pusher([&] {
    for (std::size_t i = 0; i < jobs + more; ++i) {
      writer.push([gone] { gone.wait(); }, bytes);
      ++pushed;
    }
  });
  while (pushed < jobs) std::this_thread::yield();
  EXPECT_EQ(pushed, jobs);  // the next push waits for the first job, which waits for `go`
  go.set_value();
  pusher.join();
  writer.finish();
  EXPECT_EQ(pushed, jobs + more);
}

TEST(Writer, HoldsNoMoreJobsThanItSays) {
  expect_taken(Writer::most_queued, 3, Writer::most_bytes);
  expect_taken(Writer::most_queued, 3, 10 * Writer::most_bytes);
  expect_taken(4, 3, Writer::most_bytes / 4);
  expect_taken(64, 3, 0);
}

TEST(Writer, WhatAJobThrowsComesOutAndLaterJobsAreNotDone) {
  bool later = false;
  Writer writer;
  writer.push([] { throw Failure(ExitCode::io, "stats.csv: the disk is full"); });
  try {
    writer.push([&later] { later = true; });
    writer.finish();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.code(), ExitCode::io);
    EXPECT_STREQ(failure.what(), "stats.csv: the disk is full");
  }
  EXPECT_THROW(writer.push([&later] { later = true; }), Failure);
  EXPECT_THROW(writer.finish(), Failure);
  EXPECT_FALSE(later);
}

TEST(Writer, ItsEndWaitsForTheJobs) {
  std::atomic<int> done{0};
  {
    Writer writer;
    writer.push([&done] { ++done; });
    writer.push([&done] { ++done; });
  }
  EXPECT_EQ(done, 2);
}

}  // namespace
}  // namespace runner
