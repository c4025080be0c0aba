// SPDX-License-Identifier: Apache-2.0
#include "show/deflate.hpp"

#include <zlib.h>

#include "failure.hpp"

namespace runner {

std::string deflated(const std::string& data, int level) {
  uLongf size = compressBound(static_cast<uLong>(data.size()));
  std::string packed(size, '\0');
  const int status =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
                static_cast<uLong>(data.size()), level);
  if (status != Z_OK) throw Failure(ExitCode::device, "out of memory while packing frames");
  packed.resize(size);
  return packed;
}

bool inflated(const std::string& packed, std::uint64_t size, std::string& data) {
  // zlib packs by at most 1 : 1032, so a damaged length asks for no more memory than that.
  if (size > packed.size() * std::uint64_t{1100} + 1100) return false;
  data.assign(size, '\0');
  uLongf got = static_cast<uLongf>(size);
  const int status =
      uncompress(reinterpret_cast<Bytef*>(data.data()), &got, reinterpret_cast<const Bytef*>(packed.data()),
                 static_cast<uLong>(packed.size()));
  return status == Z_OK && got == size;
}

std::string base64(const std::string& data) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((data.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < data.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < data.size() ? static_cast<unsigned char>(data[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > data.size() ? '=' : digits[bits >> (18 - 6 * k) & 63u];
    }
  }
  return text;
}

}  // namespace runner
