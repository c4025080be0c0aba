// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "numbers.hpp"
#include "option_values.hpp"
#include "suggest.hpp"

namespace runner {
namespace {

TEST(Numbers, WholeTextOrNothing) {
  EXPECT_EQ(parse_number("3.34e5"), 3.34e5);
  EXPECT_EQ(parse_number("-10"), -10);
  EXPECT_EQ(parse_number("+10"), 10);
  EXPECT_EQ(parse_number("+-10"), std::nullopt);
  // Beyond a double: what is too large is infinite, what is too small 0, however it is written.
  EXPECT_EQ(parse_number("-1e400"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("1" + std::string(400, '0')), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("1e-400"), 0);
  EXPECT_EQ(parse_number("0." + std::string(400, '0') + "1"), 0);
  EXPECT_TRUE(std::isinf(*parse_number(".inf")));
  for (const char* bad : {"", " 1", "1 ", "1m", "0x10", "1e", "--1", "heavy", "1,5"}) {
    EXPECT_FALSE(parse_number(bad)) << bad;
  }
}

TEST(Numbers, WholeNumbersDoNotOverflow) {
  EXPECT_EQ(parse_integer("-7"), -7);
  EXPECT_FALSE(parse_integer("99999999999999999999"));
  EXPECT_FALSE(parse_integer("1.5"));
}

TEST(Numbers, ForPeople) {
  EXPECT_EQ(bytes_text(4.2e9), "4.2 GB");
  EXPECT_EQ(count_text(1234567), "1,234,567");
  EXPECT_EQ(count_text(999), "999");
  EXPECT_EQ(duration_text(80), "1 min 20 s");
  EXPECT_EQ(percent_text(0.99999), "99.9 %");
  EXPECT_EQ(percent_text(1), "100.0 %");
}

TEST(Numbers, ALimitThatIsPrintedIsNoLargerThanItIs) {
  EXPECT_DOUBLE_EQ(rounded_down(0.00239626, 2), 0.0023);
  EXPECT_DOUBLE_EQ(rounded_down(0.0025, 2), 0.0025);  // 0.0025 / 0.0001 is a little less than 25
  EXPECT_DOUBLE_EQ(rounded_down(987, 1), 900);
  EXPECT_DOUBLE_EQ(rounded_down(1, 3), 1);
}

TEST(Suggest, CountsSwapsAsOne) {
  EXPECT_EQ(edit_distance("viscocity", "viscosity"), 1u);
  EXPECT_EQ(edit_distance("cdua", "cuda"), 1u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
}

TEST(Suggest, OnlyWhatIsNear) {
  EXPECT_EQ(nearest("bodys", {"fluids", "bodies"}), "bodies");
  EXPECT_EQ(nearest("wibble", {"fluids", "bodies"}), "");
  EXPECT_EQ(suggestion("x9", {"a", "b"}, "keys"), "; known keys: a, b");
}

TEST(Options, QuotedForTheShell) {
  EXPECT_EQ(shell_quoted("out/a-1"), "out/a-1");
  EXPECT_EQ(shell_quoted("fluids[0].x=1"), "'fluids[0].x=1'");
  EXPECT_EQ(shell_quoted("it's"), "'it'\\''s'");
}

}  // namespace
}  // namespace runner
