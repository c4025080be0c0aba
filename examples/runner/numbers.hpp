// SPDX-License-Identifier: Apache-2.0
// Text to numbers, strictly, and numbers to text for people.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace runner {

/// Of an angle of 1 rad.
inline constexpr double degrees = 57.295779513082323;

/// The whole text as a number ("3.34e5", "-10", ".inf", "inf"), or nothing.
std::optional<double> parse_number(const std::string& text);
/// The number of six significant digits that it is printed as.
double typed(double value);
/// "0.03" or "3%" as a share above 0 and up to 1, or nothing.
std::optional<double> parse_share(const std::string& text);
/// The whole text as a whole number, or nothing.
std::optional<std::int64_t> parse_integer(const std::string& text);

/// The largest number of so many significant digits that is no larger: a limit that still holds when it is typed in. value > 0.
double rounded_down(double value, int digits);

std::string bytes_text(double bytes);       ///< "4.2 GB"
std::string duration_text(double seconds);  ///< "1 min 20 s"
std::string count_text(std::uint64_t n);    ///< "12,345"
std::string two_digits(double value);       ///< "0.51", "12", "130"
std::string percent_text(double share);     ///< "12.5 %"; "100.0 %" only when it is all

}  // namespace runner
