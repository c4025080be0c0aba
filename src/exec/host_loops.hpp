// SPDX-License-Identifier: Apache-2.0
// Loops of the host over what it holds of a scene, while the scene is built: shared among threads, whatever the backend.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <utility>
#include <vector>

#include "exec/shares.hpp"
#include "exec/threads.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Pieces are the same for any number of threads, and so is all that is put together from them in order.
class HostLoops {
 public:
  /// asked: WorldDesc::threads. No more than such loops gain from, since they wait for memory.
  explicit HostLoops(int asked) : threads_(std::min(threads_for(asked), most_threads)) {}

  /// run(k) for every k in [0, parts), in any order. What one of them throws is thrown here once all have ended: a thread that an
  /// exception leaves ends the process.
  template <class Run>
  void each(std::int64_t parts, const Run& run) const {
    if (threads_ <= 1 || parts <= 1) {
      for (std::int64_t k = 0; k < parts; ++k) run(k);
      return;
    }
    std::exception_ptr thrown;
    std::atomic<bool> failed{false};
    Shares(threads_).each(parts, [&](std::int64_t k) {
      if (failed.load(std::memory_order_relaxed)) return;
      try {
        run(k);
      } catch (...) {
        if (!failed.exchange(true)) thrown = std::current_exception();
      }
    });
    if (thrown) std::rethrow_exception(thrown);
  }

  /// run(begin, end) over pieces of [0, n).
  template <class Run>
  void pieces(std::size_t n, const Run& run) const {
    each(static_cast<std::int64_t>((n + piece - 1) / piece), [&](std::int64_t k) {
      const std::size_t begin = static_cast<std::size_t>(k) * piece;
      run(begin, std::min(n, begin + piece));
    });
  }

  /// of(begin, end) of all pieces of [0, n), in order.
  template <class Result, class Of>
  std::vector<Result> of_pieces(std::size_t n, const Of& of) const {
    std::vector<Result> results((n + piece - 1) / piece);
    pieces(n, [&](std::size_t begin, std::size_t end) { results[begin / piece] = of(begin, end); });
    return results;
  }

  /// Whether holds(i) of every i in [0, n).
  template <class Holds>
  bool all_of(std::size_t n, const Holds& holds) const {
    const std::vector<char> all = of_pieces<char>(n, [&](std::size_t begin, std::size_t end) {
      std::size_t i = begin;
      while (i < end && holds(i)) ++i;
      return static_cast<char>(i == end);
    });
    return std::find(all.begin(), all.end(), char{0}) == all.end();
  }

  /// Room for `more` items, which are about to be added. Twice what there was, so that many small additions cost what they add. The
  /// system hands out memory where it is first written, page by page, which takes longer than to fill it: all threads ask.
  template <class T>
  void make_room(std::vector<T>& v, std::size_t more) const {
    const std::size_t size = v.size();
    if (v.capacity() - size < more) {
      std::vector<T> larger;
      larger.reserve(std::max(size + more, 2 * size));
      touch(larger.data(), 0, size + more);
      larger.insert(larger.end(), v.begin(), v.end());
      v.swap(larger);
    } else {
      touch(v.data(), size, size + more);
    }
  }

  /// resize(), the memory of a large vector asked for as above.
  template <class T>
  void resize(std::vector<T>& v, std::size_t n, const T& added = T{}) const {
    if (n > v.size()) make_room(v, n - v.size());
    v.resize(n, added);
  }

 private:
  static constexpr int most_threads = 16;
  static constexpr std::size_t piece = 8192, page = 4096, pages_at_once = 64;

  /// Writes one byte to every page of the items [first, end) of memory that holds nothing there.
  template <class T>
  void touch(T* items, std::size_t first, std::size_t end) const {
    auto* const bytes = reinterpret_cast<unsigned char*>(items);
    const std::size_t from = first * sizeof(T), n = (end - first) * sizeof(T), part = page * pages_at_once;
    if (threads_ <= 1 || n < 2 * part) return;
    each(static_cast<std::int64_t>((n + part - 1) / part), [&](std::int64_t k) {
      const std::size_t begin = static_cast<std::size_t>(k) * part;
      for (std::size_t at = begin; at < std::min(n, begin + part); at += page) bytes[from + at] = 0;
    });
  }

  int threads_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
