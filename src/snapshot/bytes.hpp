// SPDX-License-Identifier: Apache-2.0
// Bytes of files that hold a state: written and read in one order, with a checksum.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

namespace meltsim {
inline namespace v0 {
namespace core {

/// FNV-1a, 64 bits.
inline constexpr std::uint64_t hash_start = 14695981039346656037ull;
constexpr std::uint64_t hash_byte(std::uint64_t hash, unsigned char byte) {
  return (hash ^ byte) * 1099511628211ull;
}
constexpr std::uint64_t hash_text(std::uint64_t hash, const char* text) {
  for (; *text != 0; ++text) hash = hash_byte(hash, static_cast<unsigned char>(*text));
  return hash_byte(hash, 0);
}

class Hash {
 public:
  void add(const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) value_ = hash_byte(value_, p[i]);
  }
  template <class V>
  void add(const std::vector<V>& v) {
    if (!v.empty()) add(v.data(), v.size() * sizeof(V));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = hash_start;
};

class Writer {
 public:
  template <class V>
  void value(const V& v) {
    const auto* p = reinterpret_cast<const std::uint8_t*>(&v);
    bytes.insert(bytes.end(), p, p + sizeof(V));
  }
  template <class V>
  void array(const std::vector<V>& v) {
    value(static_cast<std::uint64_t>(v.size()));
    if (v.empty()) return;
    const auto* p = reinterpret_cast<const std::uint8_t*>(v.data());
    bytes.insert(bytes.end(), p, p + v.size() * sizeof(V));
  }
  std::vector<std::uint8_t> bytes;
};

class Reader {
 public:
  Reader(const std::uint8_t* data, std::size_t bytes) : p_(data), left_(bytes) {}
  template <class V>
  bool value(V& v) {
    if (left_ < sizeof(V)) return false;
    std::memcpy(&v, p_, sizeof(V));
    p_ += sizeof(V);
    left_ -= sizeof(V);
    return true;
  }
  template <class V>
  bool array(std::vector<V>& v) {
    std::uint64_t n = 0;
    if (!value(n) || n > left_ / sizeof(V)) return false;
    v.resize(static_cast<std::size_t>(n));
    if (n != 0) std::memcpy(v.data(), p_, v.size() * sizeof(V));
    p_ += v.size() * sizeof(V);
    left_ -= v.size() * sizeof(V);
    return true;
  }
  std::size_t left() const { return left_; }

 private:
  const std::uint8_t* p_;
  std::size_t left_;
};

/// What a snapshot and a saved World begin with, by which one is told that was given in place of the other.
inline constexpr char snapshot_magic[8] = {'M', 'E', 'L', 'T', 'S', 'N', 'A', 'P'};
inline constexpr char saved_world_magic[8] = {'M', 'E', 'L', 'T', 'S', 'A', 'V', 'E'};
inline bool begins_with(const char (&magic)[8], const std::uint8_t* data, std::size_t bytes) {
  return data != nullptr && bytes >= sizeof magic && std::memcmp(data, magic, sizeof magic) == 0;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
