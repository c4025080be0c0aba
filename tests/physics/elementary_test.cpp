// SPDX-License-Identifier: Apache-2.0
// Elementary functions against those of the C library, over the ranges that formulas use.
#include "meltsim/physics/elementary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace {

using namespace meltsim::physics;

// A unit in the last place is 2.2e-16. Series end below it; the last few operations round: 4 units.
constexpr double rounding = 9e-16;
constexpr int draws = 100000;  // as many as run in a moment

TEST(Elementary, ExponentialIsThatOfTheLibrary) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> all(-700, 700), small(-1, 1);
  for (int k = 0; k < draws; ++k)
    for (const double x : {all(random), small(random)})
      ASSERT_NEAR(exponential(x), std::exp(x), rounding * std::exp(x)) << x;
}

TEST(Elementary, LogarithmIsThatOfTheLibraryAlsoCloseToOne) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> exponent(-300, 300), close(-1e-3, 1e-3);
  for (int k = 0; k < draws; ++k)
    for (const double x : {std::pow(10, exponent(random)), 1 + close(random)})
      ASSERT_NEAR(logarithm(x), std::log(x), rounding * std::fabs(std::log(x))) << x;
}

// y ln x is at most 2 ln 1e6 = 28, and a power is off by as many units.
TEST(Elementary, PowerIsThatOfTheLibrary) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-6, 6), index(-2, 2);
  for (int k = 0; k < draws; ++k) {
    const double x = std::pow(10, exponent(random)), y = index(random);
    ASSERT_NEAR(power(x, y), std::pow(x, y), 30 * rounding * std::pow(x, y)) << x << ", " << y;
  }
}

// Rounding of the argument itself is 1e-16 of it: a thousand radians, in which a body turns 160 times.
TEST(Elementary, SineAndCosineAreThoseOfTheLibrary) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> angle(-1000, 1000);
  for (int k = 0; k < draws; ++k) {
    const double a = angle(random);
    ASSERT_NEAR(sine_cosine(a).sine, std::sin(a), rounding) << a;
    ASSERT_NEAR(sine_cosine(a).cosine, std::cos(a), rounding) << a;
  }
}

TEST(Elementary, AngleComesBackFromSineAndCosineAtAnyDistance) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(0, 1.5707963267948966), distance(0.1, 10);
  for (int k = 0; k < draws; ++k) {
    const double a = angle(random), r = distance(random);
    ASSERT_NEAR(angle_of({r * std::sin(a), r * std::cos(a)}), a, 2 * rounding * a);  // sin, cos: rounded, too
  }
}

TEST(Elementary, WhatCannotBeRepresentedIsInfiniteOrNone) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(exponential(711), infinity);
  EXPECT_EQ(exponential(infinity), infinity);
  EXPECT_EQ(exponential(-750), 0);
  EXPECT_EQ(exponential(-infinity), 0);
  EXPECT_TRUE(std::isnan(exponential(std::nan(""))));
  EXPECT_EQ(logarithm(0), -infinity);
  EXPECT_EQ(logarithm(infinity), infinity);
  EXPECT_TRUE(std::isnan(logarithm(-1)));
}

}  // namespace
