// SPDX-License-Identifier: Apache-2.0
// Sets of channels, one bit each: there are more of them than an integer has bits. Written out word by word, since compilers count
// every step of the checks that are made of them at compile time.
#pragma once

#include <cstdint>

namespace meltsim {
inline namespace v0 {
namespace core {

struct FieldSet {
  static constexpr int size = 192;
  std::uint64_t low = 0, middle = 0, high = 0;

  constexpr FieldSet() = default;
  constexpr FieldSet(std::uint64_t bits) : low(bits) {}  // NOLINT: as of an integer
  constexpr FieldSet(std::uint64_t l, std::uint64_t m, std::uint64_t h) : low(l), middle(m), high(h) {}

  constexpr FieldSet operator~() const { return {~low, ~middle, ~high}; }
  friend constexpr FieldSet operator|(const FieldSet& a, const FieldSet& b) {
    return {a.low | b.low, a.middle | b.middle, a.high | b.high};
  }
  friend constexpr FieldSet operator&(const FieldSet& a, const FieldSet& b) {
    return {a.low & b.low, a.middle & b.middle, a.high & b.high};
  }
  constexpr FieldSet& operator|=(const FieldSet& o) { return *this = *this | o; }
  constexpr FieldSet& operator&=(const FieldSet& o) { return *this = *this & o; }
  constexpr bool operator==(const FieldSet& o) const {
    return low == o.low && middle == o.middle && high == o.high;
  }
  constexpr bool operator!=(const FieldSet& o) const { return !(*this == o); }
  /// 0 <= by < size; what goes beyond is lost.
  constexpr FieldSet operator<<(int by) const {
    if (by >= 128) return {0, 0, low << (by - 128)};
    if (by >= 64)
      return by == 64 ? FieldSet{0, low, middle}
                      : FieldSet{0, low << (by - 64), middle << (by - 64) | low >> (128 - by)};
    return by == 0 ? *this
                   : FieldSet{low << by, middle << by | low >> (64 - by), high << by | middle >> (64 - by)};
  }
  /// Whether a channel is in it.
  constexpr bool has(int field) const {
    return ((field < 64    ? low >> field
             : field < 128 ? middle >> (field - 64)
                           : high >> (field - 128)) &
            1u) != 0;
  }
};

static_assert((FieldSet{3} << 63).has(63) && (FieldSet{3} << 63).has(64) && !(FieldSet{3} << 63).has(65));
static_assert((FieldSet{5} << 126).has(126) && (FieldSet{5} << 126).has(128) && (FieldSet{5} << 64).has(66));

}  // namespace core
}  // namespace v0
}  // namespace meltsim
