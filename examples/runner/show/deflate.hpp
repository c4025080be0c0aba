// SPDX-License-Identifier: Apache-2.0
// zlib and base64, as strings.
#pragma once

#include <cstdint>
#include <string>

namespace runner {

/// In zlib's format, which browsers call "deflate". `level` 1 (fast) to 9 (small). threads: at most so many, 0: as many as there are processors; the bytes are the same.
std::string deflated(const std::string& data, int level, int threads);
/// False when `packed` is not the packed form of `size` bytes.
bool inflated(const std::string& packed, std::uint64_t size, std::string& data);
std::string base64(const std::string& data);

}  // namespace runner
