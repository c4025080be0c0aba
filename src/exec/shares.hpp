// SPDX-License-Identifier: Apache-2.0
// How the CPU's threads share out a loop: each thread begins with a run of its own and helps the others when
// finished.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "exec/team.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// The runs are the same in every loop over as many parts, so that a thread finds in its own cache what it
/// wrote in the stages before, and neighbours mostly next to it. Handing out parts one by one balances as
/// well, but then every line comes from another core: two threads were 1.5 times as fast as one, 16 threads 8
/// times. A thread takes a quarter of the rest of a run, so that no thread waits long for the last one.
class Shares {
 public:
  explicit Shares(int threads) : next_(static_cast<std::size_t>(threads)) {}

  /// run(c) for every part c in [0, parts), in any order, by all threads.
  template <class Run>
  void each(std::int64_t parts, const Run& run) {
    const auto threads = static_cast<int>(next_.size());
    const auto first_of = [parts, threads](int t) { return parts * t / threads; };
    for (int t = 0; t < threads; ++t) next_[static_cast<std::size_t>(t)].part = first_of(t);
    const auto take_part = [&](int self) {
      for (int k = 0; k < threads; ++k) {
        const int whose = self + k < threads ? self + k : self + k - threads;
        std::int64_t* const next = &next_[static_cast<std::size_t>(whose)].part;
        const std::int64_t end = first_of(whose + 1);
        for (std::int64_t left; (left = end - __atomic_load_n(next, __ATOMIC_RELAXED)) > 0;) {
          const std::int64_t take = (left + 3) / 4;
          const std::int64_t first = __atomic_fetch_add(next, take, __ATOMIC_RELAXED);
          for (std::int64_t c = first; c < first + take && c < end; ++c) run(c);
        }
      }
    };
    using TakePart = decltype(take_part);
    Team::of_this_thread().run(
        threads, [](const void* data, int self) { (*static_cast<const TakePart*>(data))(self); }, &take_part);
  }

 private:
  struct alignas(64) Counter {  // a cache line each
    std::int64_t part = 0;
  };
  std::vector<Counter> next_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
