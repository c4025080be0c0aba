// SPDX-License-Identifier: Apache-2.0
// Means over starts that are alike.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "meltsim/trade.hpp"
#include "trade/check.hpp"
#include "trade/measure.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

namespace {
Error invalid(const std::string& message) { return {ErrorCode::invalid_argument, message}; }
}  // namespace

Result<std::vector<Mean>> average(const std::vector<Observable>& observables,
                                  const std::vector<Measurement>& runs) {
  std::vector<const Measurement*> good;
  for (const Measurement& m : runs)
    if (m.complete) good.push_back(&m);
  if (good.size() < 2)
    return invalid("average: runs: a mean needs 2 that are complete, got " + std::to_string(good.size()) +
                   (runs.empty() || runs.front().complete ? "" : "; the first one: " + runs.front().problem));
  std::vector<Mean> all;
  for (std::size_t k = 0; k < observables.size(); ++k) {
    Mean mean;
    mean.runs = static_cast<int>(good.size());
    for (const Measurement* m : good)
      if (k >= m->values.size() || m->values[k].size() != good.front()->values[k].size())
        return invalid("average: runs: they have values of \"" + observables[k].name +
                       "\" in different number; average runs of one problem");
    double worst = 0;
    for (std::size_t i = 0; i < good.front()->values[k].size(); ++i) {
      // Deviations from the first number, so that a small spread about a large mean keeps its digits.
      double first = std::numeric_limits<double>::quiet_NaN(), sum = 0, squares = 0;
      int n = 0;
      for (const Measurement* m : good) {
        const double v = m->values[k][i];
        if (!std::isfinite(v)) continue;
        if (n++ == 0) first = v;
        sum += v - first;
        squares += (v - first) * (v - first);
      }
      mean.values.push_back(n > 1 ? first + sum / n : std::numeric_limits<double>::quiet_NaN());
      if (n > 1) worst = std::max(worst, (squares - sum * sum / n) / (n - 1));
    }
    mean.spread = std::sqrt(std::max(0.0, worst));
    mean.error = mean.spread / std::sqrt(static_cast<double>(mean.runs));
    all.push_back(std::move(mean));
  }
  return all;
}

Result<std::vector<Mean>> ensemble(const Problem& problem, const Knobs& knobs, int runs,
                                   std::vector<Measurement>* members,
                                   const std::function<bool(const Measurement&, int)>& progress) {
  if (runs < 2) return invalid("ensemble: runs: expected at least 2, got " + std::to_string(runs));
  if (const Status s = check(problem); !s) return s.error();
  if (const Status s = check(knobs); !s) return s.error();
  const Result<Reference> reference = reference_to(problem);
  if (!reference) return reference.error();
  std::vector<Measurement> all;
  for (int n = 0; n < runs; ++n) {
    Knobs stirred = knobs;
    stirred.stir = n;
    Result<Measurement> m = measure_from(problem, stirred, infinity, &*reference);
    if (!m) return m.error();
    all.push_back(std::move(*m));
    if (progress && !progress(all.back(), runs))
      return Error{ErrorCode::interrupted, "ensemble: stopped by progress"};
  }
  Result<std::vector<Mean>> means = average(problem.observables, all);
  if (members != nullptr) *members = std::move(all);
  return means;
}

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
