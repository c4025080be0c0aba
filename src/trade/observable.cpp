// SPDX-License-Identifier: Apache-2.0
// Comparison of observables.
#include <algorithm>
#include <cmath>
#include <limits>

#include "meltsim/trade.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

const char* knob_name(Knob knob) {
  switch (knob) {
    case Knob::spacing:
      return "spacing";
    case Knob::sound_speed:
      return "sound_speed";
    case Knob::courant:
      return "courant";
    case Knob::step:
      return "step";
    case Knob::support:
      return "support";
  }
  return "";
}

Ranges default_ranges() {
  Ranges ranges{};
  ranges[static_cast<std::size_t>(Knob::spacing)] = {0.25, 4};
  ranges[static_cast<std::size_t>(Knob::sound_speed)] = {0.3, 2};
  ranges[static_cast<std::size_t>(Knob::courant)] = {0.5, 1.5};
  return ranges;
}

Difference difference(const Observable& observable, double scale, const std::vector<double>& a,
                      const std::vector<double>& b) {
  const auto width = static_cast<std::size_t>(observable.reduce != Reduce::largest &&
                                                      observable.reduce != Reduce::time_to_reach
                                                  ? std::max(1, observable.components)
                                                  : 1);
  const std::size_t samples = std::min(a.size(), b.size()) / width;
  Difference result;
  double sum = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    double square = 0;
    for (std::size_t k = i * width; k < (i + 1) * width; ++k) {
      const bool none_a = !std::isfinite(a[k]), none_b = !std::isfinite(b[k]);
      const double d = none_a && none_b ? 0 : none_a || none_b ? scale : a[k] - b[k];
      square += d * d;
    }
    result.max = std::max(result.max, std::sqrt(square));
    sum += square;
  }
  if (samples > 0) result.rms = std::sqrt(sum / static_cast<double>(samples));
  return result;
}

std::vector<double> reduce(const Observable& observable, const std::vector<double>& times,
                           const std::vector<double>& values) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto width = static_cast<std::size_t>(std::max(1, observable.components));
  switch (observable.reduce) {
    case Reduce::curve:
      return values;
    case Reduce::last:
      if (values.size() < width) return std::vector<double>(width, none);
      return {values.end() - static_cast<std::ptrdiff_t>(width), values.end()};
    case Reduce::largest: {
      double most = none;
      for (const double value : values)
        if (!(most >= value) && std::isfinite(value)) most = value;
      return {most};
    }
    case Reduce::late_mean: {
      std::vector<double> sums(width, 0.0), counts(width, 0.0);
      const std::size_t samples = values.size() / width;
      for (std::size_t i = samples / 2; i < samples; ++i)
        for (std::size_t c = 0; c < width; ++c) {
          const double value = values[i * width + c];
          if (!std::isfinite(value)) continue;
          sums[c] += value;
          ++counts[c];
        }
      for (std::size_t c = 0; c < width; ++c) sums[c] = counts[c] > 0 ? sums[c] / counts[c] : none;
      return sums;
    }
    case Reduce::time_to_reach:
      break;
  }
  for (std::size_t i = 0; i < std::min(values.size(), times.size()); ++i) {
    if (!(values[i] >= observable.level)) continue;
    if (i == 0) return {times[0]};
    const double part = (observable.level - values[i - 1]) / (values[i] - values[i - 1]);
    return {times[i - 1] + (std::isfinite(part) ? part : 1) * (times[i] - times[i - 1])};
  }
  return {none};
}

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
