// SPDX-License-Identifier: Apache-2.0
// Numbers in binary files, independent of the byte order of this machine.
#pragma once

#include <cstdint>
#include <cstring>

namespace meltsim {
inline namespace v0 {

inline std::uint64_t load_bits(const char* at, std::size_t size, bool big_endian) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const auto byte = static_cast<unsigned char>(at[big_endian ? i : size - 1 - i]);
    bits = bits << 8 | byte;
  }
  return bits;
}

inline float load_float(const char* at, bool big_endian) {
  const auto bits = static_cast<std::uint32_t>(load_bits(at, 4, big_endian));
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

inline double load_double(const char* at, bool big_endian) {
  const std::uint64_t bits = load_bits(at, 8, big_endian);
  double value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace v0
}  // namespace meltsim
