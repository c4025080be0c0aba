// SPDX-License-Identifier: Apache-2.0
// Helpers of a thread: every part of the work is done once, whoever finds the time for it.
#include "exec/team.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>
#include <vector>

#include "exec/shares.hpp"

using namespace meltsim::core;

namespace {

/// Work on `parts` shared out over `threads`; how often each part was done.
std::vector<int> times_done(Shares& shares, std::int64_t parts) {
  std::vector<int> done(static_cast<std::size_t>(parts), 0);
  // A part belongs to one thread: an increment that is not atomic is lost where two take the same.
  shares.each(parts, [&done](std::int64_t c) { ++done[static_cast<std::size_t>(c)]; });
  return done;
}

/// Calls run() until a helper has taken part, at most 10 s: a machine with other work may have no processor for it.
template <class Look>
bool helped(int members, const Look& look) {
  struct Job {
    const Look* look;
    std::atomic<bool> entered{false};
  };
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < until) {
    Job job{&look, {}};
    Team::of_this_thread().run(
        members,
        [](const void* data, int member) {
          Job& j = *static_cast<Job*>(const_cast<void*>(data));
          if (member > 0) {
            (*j.look)(member);
            j.entered = true;
            return;
          }
          const auto patient = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
          while (!j.entered && std::chrono::steady_clock::now() < patient) std::this_thread::yield();
        },
        &job);
    if (job.entered) return true;
  }
  return false;
}

}  // namespace

TEST(Team, EveryPartIsDoneOnce) {
  for (const int threads : {1, 2, 3, 16}) {
    Shares shares(threads);
    // Fewer parts than threads, as many, many more; often, so that helpers come late, sleep and are called again.
    for (const std::int64_t parts : {1, 2, 16, 1000})
      for (int k = 0; k < 200; ++k)
        ASSERT_EQ(times_done(shares, parts), std::vector<int>(static_cast<std::size_t>(parts), 1)) << threads;
  }
}

TEST(Team, HelpersTakePart) {
  std::atomic<int> member{0};
  EXPECT_TRUE(helped(3, [&member](int m) { member = m; }));
  EXPECT_GE(member, 1);
  EXPECT_LE(member, 2);
}

TEST(Team, HelpersThatHaveSleptAreCalled) {
  EXPECT_TRUE(helped(2, [](int) {}));
  std::this_thread::sleep_for(
      std::chrono::milliseconds(20));  // 400 times what a helper waits before it sleeps
  EXPECT_TRUE(helped(2, [](int) {}));
}

TEST(Team, AfterASmallerTeamALargerOneHelps) {
  EXPECT_TRUE(helped(2, [](int) {}));
  std::atomic<bool> third{false};
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!third && std::chrono::steady_clock::now() < until)
    helped(4, [&third](int m) { third = third || m == 3; });
  EXPECT_TRUE(third);
}

TEST(Team, SignalsAreLeftToTheHostsThreads) {
  std::atomic<int> blocked{-1};
  ASSERT_TRUE(helped(2, [&blocked](int) {
    sigset_t mask;
    pthread_sigmask(SIG_SETMASK, nullptr, &mask);
    blocked = sigismember(&mask, SIGINT) + sigismember(&mask, SIGTERM);
  }));
  EXPECT_EQ(blocked, 2);
  sigset_t mask;
  pthread_sigmask(SIG_SETMASK, nullptr, &mask);
  EXPECT_EQ(sigismember(&mask, SIGINT), 0);  // the caller takes them as before
}

TEST(Team, WorkInsideOfWorkIsDoneByItsCaller) {
  Shares outer(3);
  std::atomic<int> done{0};
  outer.each(8, [&](std::int64_t) {
    Shares own(3);
    own.each(5, [&done](std::int64_t) { ++done; });
  });
  EXPECT_EQ(done, 40);
}

TEST(Team, EachThreadOfTheHostHasItsOwn) {
  std::atomic<int> wrong{0};
  std::vector<std::thread> hosts;
  for (int h = 0; h < 4; ++h)
    hosts.emplace_back([&wrong] {
      Shares shares(3);
      for (int k = 0; k < 200; ++k)
        if (times_done(shares, 50) != std::vector<int>(50, 1)) ++wrong;
    });
  for (std::thread& t : hosts) t.join();
  EXPECT_EQ(wrong, 0);
}

// A child has the memory of its parent's helpers, but not the helpers: it makes its own, and ends.
TEST(Team, AChildOfAForkWorksAndEnds) {
  Shares shares(4);
  times_done(shares, 100);
  ::testing::FLAGS_gtest_death_test_style = "fast";
  EXPECT_EXIT(
      {
        const bool right = times_done(shares, 100) == std::vector<int>(100, 1);
        std::exit(right ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "");
  EXPECT_EQ(times_done(shares, 100), std::vector<int>(100, 1));
}

TEST(Team, AChildOfAForkThatDoesNothingEnds) {
  Shares shares(4);
  times_done(shares, 100);
  ::testing::FLAGS_gtest_death_test_style = "fast";
  EXPECT_EXIT(std::exit(0), ::testing::ExitedWithCode(0), "");
}
