// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Which parts of a sub-step are timed.
enum class Sample { nothing, stages, whole };

/// Times the stages of one sub-step of every `every`, and the whole of the next. Which one of them follows no period, so that
/// stages that run in one sub-step of several get their turn whatever `every` is.
struct Sampling {
  int every = 0;  ///< 0: nothing is timed
  std::uint64_t count = 0;
  Sample next() {
    if (every == 0) return Sample::nothing;
    const auto n = static_cast<std::uint64_t>(every), window = count / n, place = count++ % n;
    // Skips the first sub-steps, in which modules and pages are loaded.
    const std::uint64_t stages = window == 0 ? std::min<std::uint64_t>(n - 1, 8) : scattered(window) % n;
    return place == stages ? Sample::stages : place == (stages + 1) % n ? Sample::whole : Sample::nothing;
  }

 private:
  /// The mixing function of splitmix64 (Steele, Lea & Flood 2014, OOPSLA).
  static std::uint64_t scattered(std::uint64_t x) {
    x *= 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
};

/// The last `window` durations of every stage; the median is what is reported.
class Timings {
 public:
  void add(int index, double ms) {
    if (index >= static_cast<int>(rings_.size())) rings_.resize(static_cast<std::size_t>(index) + 1);
    Ring& r = rings_[static_cast<std::size_t>(index)];
    if (r.values.size() < window) r.values.push_back(ms);
    else r.values[r.next++ % window] = ms;
  }
  double median(int index) const {
    if (index >= static_cast<int>(rings_.size())) return 0;
    std::vector<double> v = rings_[static_cast<std::size_t>(index)].values;
    if (v.empty()) return 0;
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  }

 private:
  static constexpr std::size_t window = 256;
  struct Ring {
    std::vector<double> values;
    std::size_t next = 0;
  };
  std::vector<Ring> rings_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
