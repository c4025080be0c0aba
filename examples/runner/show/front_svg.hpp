// SPDX-License-Identifier: Apache-2.0
// A plot of error against cost, both logarithmic, as SVG.
#pragma once

#include <string>
#include <vector>

namespace runner {

struct FrontPoint {
  double cost, error;  ///< above 0, or the point is left out
};

struct FrontSeries {
  std::string title;
  std::string color;  ///< "#2f62c4"
  bool line = false;  ///< joined; else dots
  std::vector<FrontPoint> points;
};

std::string front_svg(const std::string& title, const std::string& cost, const std::string& error,
                      const std::vector<FrontSeries>& series);

}  // namespace runner
