// SPDX-License-Identifier: Apache-2.0
// Sums over rows whose words overflow, as those over pieces do where a sub-step is absurd: they wrap, which is defined, and the World
// halts. This file is compiled so that an overflow of signed numbers, which is not defined, ends the program.
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "exec/exec_cpu.hpp"

namespace verbs_test {
namespace {

struct Words {
  std::int64_t up = 0, down = 0;
  static constexpr int words = 2;
};
/// The largest terms that frame/rigid_sums.hpp makes: three of one sign are more than a word holds.
struct LargeTerms {
  using Sum = Words;
  std::uint32_t rows;
  std::uint32_t operator()(std::uint64_t i, Words& s) const {
    s.up = 4000000000000000000 + static_cast<std::int64_t>(i);
    s.down = -s.up;
    return static_cast<std::uint32_t>(i) % rows;
  }
};

TEST(SumByRow, WordsThatOverflowWrap) {
  for (const int threads : {1, 2})
    for (const std::uint32_t rows : {1u, 3u}) {
      meltsim::core::CpuExec ex(threads);
      constexpr std::uint64_t n = 20001;  // several parts of a thread
      std::vector<Words> sums(rows);
      ex.sum_by_row(n, LargeTerms{rows}, sums.data());
      for (std::uint32_t row = 0; row < rows; ++row) {
        std::uint64_t up = 0;
        for (std::uint64_t i = row; i < n; i += rows) up += 4000000000000000000u + i;
        EXPECT_EQ(static_cast<std::uint64_t>(sums[row].up), up);
        EXPECT_EQ(static_cast<std::uint64_t>(sums[row].down), 0u - up);
      }
    }
}

}  // namespace
}  // namespace verbs_test
