// SPDX-License-Identifier: Apache-2.0
// FNV-1a, 64 bits: tells contents apart, keeps no secret.
#pragma once

#include <cstddef>
#include <cstdint>

namespace runner {

constexpr std::uint64_t hash_start = 14695981039346656037ull;

/// Goes on from `hash`, of what came before.
inline std::uint64_t fnv1a(const void* data, std::size_t size, std::uint64_t hash = hash_start) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
  return hash;
}

}  // namespace runner
