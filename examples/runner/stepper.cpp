// SPDX-License-Identifier: Apache-2.0
#include "stepper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace runner {

namespace {

// Times are sums of rounded steps; a millionth of a step of slack keeps the rounding from adding a step.
constexpr double slack = 1e-6;

/// How many steps of `dt` cover `span`; at least one.
double steps_in(double span, double dt) { return std::max(1.0, std::ceil(span / dt - slack)); }

// Of a time that was added up from a handful of parts.
constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();

}  // namespace

bool reached(double now, double due) { return now >= due - rounding * std::abs(due); }

double fixed_frame_dt(double frame_start, double frame_end, double dt) {
  const double span = frame_end - frame_start;
  return span / steps_in(span, dt);
}

Batch fixed_batch(double now, double frame_end, double dt) {
  const double all = steps_in(frame_end - now, dt);
  const double steps = std::min(all, static_cast<double>(fixed_steps_per_batch));
  return {dt, static_cast<int>(steps), steps == all ? frame_end : now + steps * dt};
}

Batch adaptive_batch(double now, double frame_end, double limit) {
  const double span = frame_end - now;
  const double all = std::isinf(limit) ? 1 : steps_in(span, limit);
  const double dt = span / all;
  const double steps = std::min(all, static_cast<double>(adaptive_steps_per_batch));
  return {dt, static_cast<int>(steps), steps == all ? frame_end : now + steps * dt};
}

double automatic_dt(double stable, double frame) {
  return std::isinf(stable) ? frame : frame / steps_in(frame, stable);
}

}  // namespace runner
