// SPDX-License-Identifier: Apache-2.0
#include "trade/fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace meltsim {
inline namespace v0 {
namespace trade {

namespace {

// Twins whose knobs differ by less say nothing of a power.
constexpr double distinct = 1.03;
// Cosine of the turn from which on differences that hardly fall are a slow approach and no scatter.
constexpr double straight_on = 0.5;

/// Error falls along the list.
void sort_by_error(std::vector<Twin>& twins, double exponent) {
  std::sort(twins.begin(), twins.end(),
            [&](const Twin& a, const Twin& b) { return exponent > 0 ? a.x > b.x : a.x < b.x; });
  const auto same = [](const Twin& a, const Twin& b) {
    return std::max(a.x, b.x) < distinct * std::min(a.x, b.x);
  };
  twins.erase(std::unique(twins.begin(), twins.end(), same), twins.end());
}

double log_slope(double x1, double y1, double x2, double y2) {
  return y1 > 0 && y2 > 0 ? std::log(y2 / y1) / std::log(x2 / x1) : 0;
}

/// (a^p - b^p) / (b^p - c^p), which grows or falls steadily with p.
double ratio_of_steps(double a, double b, double c, double p) {
  return (std::pow(a, p) - std::pow(b, p)) / (std::pow(b, p) - std::pow(c, p));
}

/// The p in [least, most] whose ratio is nearest.
double exponent_of(double a, double b, double c, double ratio, const Nominal& range, bool& inside) {
  double low = range.least, high = range.most;
  const double at_low = ratio_of_steps(a, b, c, low), at_high = ratio_of_steps(a, b, c, high);
  const bool rises = at_high > at_low;
  inside = rises ? ratio >= at_low && ratio <= at_high : ratio <= at_low && ratio >= at_high;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    ((ratio_of_steps(a, b, c, middle) < ratio) == rises ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// Cosine between the ways from a to b and from b to c: 1 where the second goes on as the first began, below 0 where it turns back.
/// Single numbers have one way only, which says nothing: none, as where the two are the same.
std::optional<double> turn(const std::vector<double>& a, const std::vector<double>& b,
                           const std::vector<double>& c) {
  constexpr std::size_t few = 5;
  if (std::min({a.size(), b.size(), c.size()}) < few) return std::nullopt;
  double along = 0, first = 0, second = 0;
  for (std::size_t i = 0; i < std::min({a.size(), b.size(), c.size()}); ++i) {
    const double ab = b[i] - a[i], bc = c[i] - b[i];
    if (!std::isfinite(ab) || !std::isfinite(bc)) continue;
    along += ab * bc;
    first += ab * ab;
    second += bc * bc;
  }
  if (!(first > 0) || !(second > 0)) return std::nullopt;
  return along / std::sqrt(first * second);
}

/// Of scatter. Taken for the beginning of a difference to the limit, differences would be multiplied by x^p over a small change of it; and the
/// first and the last may be further apart than neighbours are.
template <class Apart>
double largest_of_pairs(const std::vector<Twin>& twins, const Apart& apart) {
  double most = 0;
  for (std::size_t i = 0; i < twins.size(); ++i)
    for (std::size_t j = i + 1; j < twins.size(); ++j) most = std::max(most, apart(twins[i], twins[j]));
  return most;
}

}  // namespace

Nominal nominal(Knob knob) {
  switch (knob) {
    case Knob::spacing:
      // Kernels interpolate to second order, and probes blur it; an error that falls faster has not reached its law yet.
      return {1, 0.7, 2.1};
    case Knob::sound_speed:
      return {-2, -3, -1};
    case Knob::courant:  // leap-frog is of second order
      return {2, 1, 3};
    case Knob::step:
    case Knob::support:
      break;
  }
  return {1, 0.5, 2.5};
}

double Law::at(double x) const { return error * std::pow(x, error_exponent); }

Law fit(Knob knob, const Observable& observable, double scale, std::vector<Twin> twins, double noise) {
  Nominal expected = nominal(knob);
  if (knob == Knob::spacing) expected.most = std::min(expected.most, observable.order + 0.1);
  Law law;
  law.knob = knob;
  law.error_exponent = expected.exponent;
  sort_by_error(twins, expected.exponent);
  if (twins.size() < 2) return law;
  law.cost_exponent = log_slope(twins.front().x, twins.front().work, twins.back().x, twins.back().work);
  std::vector<double> apart;
  const auto beyond_noise = [&](const Twin& a, const Twin& b) {
    const double d = difference(observable, scale, *a.values, *b.values).max;
    return std::sqrt(std::max(0.0, d * d - noise * noise));
  };
  for (std::size_t i = 0; i + 1 < twins.size(); ++i) apart.push_back(beyond_noise(twins[i], twins[i + 1]));
  if (twins.size() >= 3 && apart[0] > 0 && apart[1] > 0) {
    const double p =
        exponent_of(twins[0].x, twins[1].x, twins[2].x, apart[0] / apart[1], expected, law.fitted);
    const std::optional<double> way = turn(*twins[0].values, *twins[1].values, *twins[2].values);
    const bool slow = !law.fitted && std::abs(p) < std::abs(expected.exponent);
    law.scatters = slow ? !(way && *way >= straight_on) : way && *way < 0;
    if (!law.scatters) law.error_exponent = p;
    else law.fitted = false;
  }
  if (law.scatters) {
    law.error = largest_of_pairs(twins, beyond_noise) / std::pow(twins[0].x, law.error_exponent);
    return law;
  }
  for (std::size_t i = 0; i < apart.size(); ++i) {
    const double step =
        std::pow(twins[i].x, law.error_exponent) - std::pow(twins[i + 1].x, law.error_exponent);
    law.error = std::max(law.error, apart[i] / step);
  }
  return law;
}

Law fit_exact(const Observable& observable, double scale, const Law& relative, std::vector<Twin> twins,
              double others) {
  const Nominal expected = nominal(relative.knob);
  Law law = relative;
  law.fitted = law.scatters = false;
  law.error_exponent = expected.exponent;
  law.error = 0;
  sort_by_error(twins, expected.exponent);
  if (twins.empty()) return law;
  std::vector<double> errors;
  for (const Twin& twin : twins)
    errors.push_back(
        std::max(0.0, difference(observable, scale, *twin.values, observable.exact).max - others));
  if (twins.size() >= 2 && errors.front() > 0 && errors.back() > 0) {
    const double slope = log_slope(twins.front().x, errors.front(), twins.back().x, errors.back());
    law.error_exponent = std::clamp(slope, expected.least, expected.most);
    law.fitted = slope == law.error_exponent;
  }
  for (std::size_t i = 0; i < twins.size(); ++i)
    law.error = std::max(law.error, errors[i] / std::pow(twins[i].x, law.error_exponent));
  return law;
}

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
