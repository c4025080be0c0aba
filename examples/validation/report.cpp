// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "validation.hpp"

namespace validation {

void Report::relative(const std::string& quantity, double value, double reference, double target_percent,
                      const std::string& reason) {
  const double deviation = std::fabs(value - reference);
  // Nothing off nothing is right; anything off nothing is infinitely wrong.
  const double percent = deviation == 0 ? 0 : 100 * deviation / std::fabs(reference);
  rows.push_back({quantity, value, reference, percent, target_percent, "%", reason});
}

void Report::absolute(const std::string& quantity, double value, double reference, double target,
                      const std::string& unit, const std::string& reason) {
  rows.push_back({quantity, value, reference, std::fabs(value - reference), target, unit, reason});
}

meltsim::WorldDesc world_desc(const Settings& s) {
  meltsim::WorldDesc d;
  d.backend = s.backend;
  d.precision = s.precision;
  d.threads = s.threads;
  return d;
}

}  // namespace validation
