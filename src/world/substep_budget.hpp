// SPDX-License-Identifier: Apache-2.0
// Number of sub-steps that fit into a span of wall time, from the cost of past ones. Times are arguments: nothing here reads a
// clock.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Running mean and mean deviation of the cost of a sub-step [s], as of round-trip times in Jacobson (1988), "Congestion
/// avoidance and control", SIGCOMM: weights 1/8 and 1/4. Deviations from it: the margin has 2 deviations instead of 4, as
/// a sub-step too many costs little.
class SubstepCost {
 public:
  /// Adds a measurement: that many sub-steps took so long together.
  void learn(double seconds, std::uint64_t substeps) {
    if (substeps == 0 || !(seconds >= 0)) return;
    const double each = seconds / static_cast<double>(substeps);
    if (!known_ || each < mean_ / 2) {  // the first ones allocate and record: those after them tell more
      known_ = true;
      mean_ = each;
      deviation_ = 0;
      return;
    }
    deviation_ += (std::abs(each - mean_) - deviation_) / 4;
    mean_ += (each - mean_) / 8;
  }
  bool known() const { return known_; }
  double mean() const { return mean_; }                     ///< [s]
  double margin() const { return mean_ + 2 * deviation_; }  ///< [s] few sub-steps take longer

 private:
  bool known_ = false;
  double mean_ = 0, deviation_ = 0;
};

/// Sub-steps that may be enqueued next, where `left` [s] of the budget are left and `ahead` sub-steps are enqueued and not
/// known to be done: a quarter of those that fit, so that the next batch follows from the cost of this one. 0: no more fit.
/// 1 if the cost is not known yet.
inline std::uint64_t next_batch(const SubstepCost& cost, double left, std::uint64_t ahead) {
  constexpr double most = 64;  // an interrupt comes between two batches
  if (!cost.known()) return ahead == 0 && left > 0 ? 1 : 0;
  const double spare = left - static_cast<double>(ahead) * cost.mean();
  if (!(spare >= cost.margin())) return 0;
  const double fit = cost.margin() > 0 ? spare / cost.margin() : most;
  return static_cast<std::uint64_t>(std::clamp(std::floor(fit / 4), 1.0, most));
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
