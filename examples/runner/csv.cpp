// SPDX-License-Identifier: Apache-2.0
#include "csv.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "failure.hpp"
#include "numbers.hpp"

namespace runner {

std::vector<std::string> split_commas(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') cells.emplace_back();
    else cells.back() += c;
  }
  return cells;
}

namespace {

/// 10^k; exact up to 10^22.
constexpr double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                             1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr int digits = 9;
constexpr int most_power = 22;

/// The 9 digits of a positive value in [1e8, 1e9), and its decimal exponent; false where rounding might go the wrong way. One product
/// or quotient with an exact power of ten is off by half a unit of double, 1e-7 of the last digit.
bool decimal(double value, std::uint32_t& mantissa, int& exponent) {
  int binary = 0;
  std::frexp(value, &binary);
  exponent = static_cast<int>(std::floor((binary - 1) * 0.30102999566398120));  // right, or one too small
  for (int tries = 0; tries < 2; ++tries, ++exponent) {
    const int shift = digits - 1 - exponent;
    if (shift > most_power || shift < -most_power) return false;
    const double scaled = shift >= 0 ? value * powers[shift] : value / powers[-shift];
    const double whole = std::floor(scaled), part = scaled - whole;
    if (std::fabs(part - 0.5) < 1e-6) return false;
    const double rounded = part > 0.5 ? whole + 1 : whole;
    if (rounded >= 1e9) continue;
    if (rounded < 1e8) return false;
    mantissa = static_cast<std::uint32_t>(rounded);
    return true;
  }
  return false;
}

constexpr char two_digits[] =
    "00010203040506070809101112131415161718192021222324252627282930313233343536373839404142434445464748495051"
    "525354555657585960616263"
    "646566676869707172737475767778798081828384858687888990919293949596979899";

/// What printf does with %g.
char* write_decimal(char* to, std::uint32_t mantissa, int exponent) {
  char all[digits];
  for (int k = digits - 2; k > 0; k -= 2, mantissa /= 100)
    std::memcpy(all + k, two_digits + 2 * (mantissa % 100), 2);
  all[0] = static_cast<char>('0' + mantissa);
  int used = digits;
  while (used > 1 && all[used - 1] == '0') --used;
  const auto put = [&](int from, int count) {
    for (int k = 0; k < count; ++k) *to++ = from + k < used ? all[from + k] : '0';
  };
  if (exponent < -4 || exponent >= digits) {
    put(0, 1);
    if (used > 1) *to++ = '.';
    put(1, used - 1);
    *to++ = 'e';
    *to++ = exponent < 0 ? '-' : '+';
    const int size = std::abs(exponent);
    *to++ = static_cast<char>('0' + size / 10);
    *to++ = static_cast<char>('0' + size % 10);
  } else if (exponent < 0) {
    *to++ = '0';
    *to++ = '.';
    for (int k = -1; k > exponent; --k) *to++ = '0';
    put(0, used);
  } else {
    put(0, exponent + 1);
    if (used > exponent + 1) *to++ = '.';
    put(exponent + 1, used - exponent - 1);
  }
  return to;
}

}  // namespace

char* write_csv_number(char* to, double value) {
  if (std::isnan(value)) {
    std::memcpy(to, "nan", 3);
    return to + 3;
  }
  std::uint32_t mantissa = 0;
  int exponent = 0;
  if (std::isfinite(value) && value != 0 && decimal(std::fabs(value), mantissa, exponent)) {
    if (value < 0) *to++ = '-';
    return write_decimal(to, mantissa, exponent);
  }
  return fmt::format_to(to, "{:.9g}", value);
}

std::string csv_number(double value) {
  char text[longest_csv_number];
  return {text, write_csv_number(text, value)};
}

CsvFile::CsvFile(const std::string& path, std::string content, bool)
    : path_(path), file_(replace_file(path, content)) {}

CsvFile::CsvFile(std::string path, const std::string& header) : CsvFile(path, header + "\n", true) {}

CsvFile CsvFile::resume(std::string path, const std::string& header, std::size_t time_column, double time,
                        std::vector<std::string>* kept) {
  if (!exists(path)) return {std::move(path), header};
  std::istringstream old(read_file(path));
  std::string line, content = header + "\n";
  const double last = parse_number(csv_number(time)).value_or(time);  // rows hold nine digits
  const std::size_t columns = split_commas(header).size();
  std::getline(old, line);  // the header
  while (std::getline(old, line)) {
    const std::vector<std::string> cells = split_commas(line);
    const auto at = cells.size() == columns ? parse_number(cells[time_column]) : std::nullopt;
    if (!at || !(*at <= last)) continue;
    content += line + "\n";
    if (kept != nullptr) kept->push_back(line);
  }
  return {path, std::move(content), true};
}

std::string& CsvFile::checked(int why) {
  if (why != 0)
    throw Failure(ExitCode::io, fmt::format("{}: cannot be written: {}", path_, std::strerror(why)));
  return buffer_;
}

void CsvFile::flush() {
  const int why = file_.write(buffer_);
  buffer_.clear();
  checked(why);
}

}  // namespace runner
