// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

namespace meltsim {
inline namespace v0 {
namespace core {

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
