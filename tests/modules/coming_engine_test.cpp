// SPDX-License-Identifier: Apache-2.0
// An engine that is made in a thread of its own.
#include "engine/coming_engine.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace {

using namespace meltsim;
using core::ComingEngine;

ComingEngine::Made cpu() { return core::make_cpu_engine(WorldDesc{}); }

// It is asked for only once it is there, by two threads that ask at once.
TEST(ComingEngine, IsWaitedForByWhoeverAsks) {
  const ComingEngine::Made wanted = cpu();
  std::atomic<bool> go{false};
  ComingEngine engine;
  engine.begin(
      [&]() -> ComingEngine::Made {
        while (!go) std::this_thread::yield();
        return wanted;
      },
      cpu());
  std::atomic<int> right{0}, asked{0};
  const auto ask = [&] {
    ++asked;
    if (&*engine == wanted->get()) ++right;
  };
  std::thread first(ask), second(ask);
  while (asked < 2) std::this_thread::yield();
  EXPECT_EQ(right, 0);
  go = true;
  first.join();
  second.join();
  EXPECT_EQ(right, 2);
  EXPECT_TRUE(engine.status());
  EXPECT_EQ(engine.error(), "");
}

TEST(ComingEngine, WhatStandsInSaysWhy) {
  const ComingEngine::Made other = cpu();
  ComingEngine engine;
  engine.begin(
      []() -> ComingEngine::Made {
        return Error{ErrorCode::no_device, "device: 0 is there but cannot be used: busy"};
      },
      other);
  EXPECT_EQ(&*engine, other->get());
  EXPECT_EQ(engine.error(), "device: 0 is there but cannot be used: busy");
  ASSERT_FALSE(engine.status());
  EXPECT_EQ(engine.status().error().code, ErrorCode::no_device);
}

// Whoever leaves before it has come does not leave a thread behind.
TEST(ComingEngine, MayBeLeftBeforeItComes) {
  std::atomic<bool> made{false};
  {
    ComingEngine engine;
    engine.begin(
        [&]() -> ComingEngine::Made {
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
          made = true;
          return cpu();
        },
        cpu());
  }
  EXPECT_TRUE(made);
}

}  // namespace
