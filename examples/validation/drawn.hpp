// SPDX-License-Identifier: Apache-2.0
// What cases drawn at random have in common: the spread of their errors.
#pragma once

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "run.hpp"

namespace validation {

using namespace meltsim;

inline std::string text(const char* format, double a, double b = 0, double c = 0, double d = 0, double e = 0,
                        double f = 0, double g = 0) {
  char out[240];
  std::snprintf(out, sizeof out, format, a, b, c, d, e, f, g);
  return out;
}

/// What one draw came to: its error in the unit of the target, and what was drawn.
struct Outcome {
  double error = 0;
  std::string what;
};
using One = std::function<Outcome(Dice&, const Settings&, Report&)>;

/// Makes `settings.draws` draws and reports their median and their worst.
inline void spread(const Settings& s, Report& report, const std::string& quantity, double target,
                   const std::string& unit, const std::string& reason, const One& one) {
  std::vector<std::pair<double, int>> errors;
  std::string worst;
  for (int k = 0; k < s.draws; ++k) {
    Dice dice(s.seed, static_cast<std::uint64_t>(k));
    const Outcome o = one(dice, s, report);
    if (!report.error.empty()) {
      report.error = "draw " + std::to_string(k) + " (" + o.what + "): " + report.error;
      return;
    }
    if (errors.empty() || !(o.error <= std::max_element(errors.begin(), errors.end())->first))
      worst = "draw " + std::to_string(k) + ", " + o.what;
    errors.emplace_back(o.error, k);
  }
  std::sort(errors.begin(), errors.end());
  const std::string of = " of " + std::to_string(s.draws);
  report.absolute(quantity + ": median" + of, errors[errors.size() / 2].first, 0, target, unit, reason);
  report.absolute(quantity + ": worst" + of, errors.back().first, 0, target, unit, reason);
  report.note += quantity + ": worst is " + worst + ". ";
  Curve curve{"meltsim", {}, {}, false};
  for (std::size_t k = 0; k < errors.size(); ++k) {
    curve.x.push_back(static_cast<double>(k + 1) / static_cast<double>(errors.size()));
    curve.y.push_back(errors[k].first);
  }
  std::string name = "drawn_" + quantity;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  report.plots.push_back(
      {name, quantity + ": error of each draw", "share of draws", "error [" + unit + "]", {curve}});
}

}  // namespace validation
