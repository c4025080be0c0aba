// SPDX-License-Identifier: Apache-2.0
#include "show/deflate.hpp"

#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "failure.hpp"

namespace runner {

namespace {

// What one thread packs at a time, and how much of what comes before it knows: as far as deflate looks back. Fixed, so that the packed
// bytes are the same on every machine (as pigz does: Adler).
constexpr std::size_t part_size = 256 * 1024, window = 32 * 1024;

/// A part of a deflate stream, ended at a byte; empty where there was no memory.
std::string packed_part(const std::string& data, std::size_t from, int level) {
  const std::size_t to = std::min(data.size(), from + part_size);
  const auto bytes = [&data](std::size_t at) {
    return reinterpret_cast<Bytef*>(const_cast<char*>(data.data() + at));  // zlib's interface; it only reads
  };
  z_stream stream{};
  constexpr int raw = -15, memory = 8;
  if (deflateInit2(&stream, level, Z_DEFLATED, raw, memory, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  const std::size_t known = std::min(from, window);
  if (known > 0) deflateSetDictionary(&stream, bytes(from - known), static_cast<uInt>(known));
  constexpr std::size_t of_flush = 16;
  std::string packed(deflateBound(&stream, static_cast<uLong>(to - from)) + of_flush, '\0');
  stream.next_in = bytes(from);
  stream.avail_in = static_cast<uInt>(to - from);
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const bool last = to == data.size();
  const int status = deflate(&stream, last ? Z_FINISH : Z_SYNC_FLUSH);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  return status == (last ? Z_STREAM_END : Z_OK) ? packed : std::string();
}

}  // namespace

std::string deflated(const std::string& data, int level, int threads) {
  const std::size_t count = std::max<std::size_t>(1, (data.size() + part_size - 1) / part_size);
  std::vector<std::string> parts(count);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  const auto work = [&]() noexcept {
    try {
      for (std::size_t k = next++; k < count; k = next++)
        if ((parts[k] = packed_part(data, k * part_size, level)).empty()) failed = true;
    } catch (const std::bad_alloc&) {
      failed = true;
    }
  };
  std::vector<std::thread> helpers;
  const unsigned most =
      threads > 0 ? static_cast<unsigned>(threads) : std::max(1u, std::thread::hardware_concurrency());
  try {
    while (helpers.size() + 1 < std::min<std::size_t>(count, most)) helpers.emplace_back(work);
  } catch (const std::system_error&) {  // as many as the machine grants
  }
  work();
  for (std::thread& helper : helpers) helper.join();
  if (failed) throw Failure(ExitCode::device, "out of memory while packing frames");
  std::string packed = "\x78\x9c";  // zlib's header
  for (const std::string& part : parts) packed += part;
  const uLong sum =
      adler32_z(adler32(0, nullptr, 0), reinterpret_cast<const Bytef*>(data.data()), data.size());
  for (int shift = 24; shift >= 0; shift -= 8) packed += static_cast<char>(sum >> shift & 255u);
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
