// SPDX-License-Identifier: Apache-2.0
#include "stepper.hpp"

#include <algorithm>
#include <cmath>

namespace runner {

namespace {

// Times are sums of rounded steps; a millionth of a step of slack keeps the rounding from adding a step.
constexpr double slack = 1e-6;

/// How many steps of `dt` cover `span`; at least one.
double steps_in(double span, double dt) { return std::max(1.0, std::ceil(span / dt - slack)); }

}  // namespace

double fixed_frame_dt(double frame_start, double frame_end, double dt) {
  const double span = frame_end - frame_start;
  return span / steps_in(span, dt);
}

Batch fixed_batch(double now, double target, double frame_end, double dt) {
  const double to_target = steps_in(target - now, dt), to_frame = steps_in(frame_end - now, dt);
  const double steps = std::min({to_target, to_frame, static_cast<double>(steps_per_batch)});
  return {dt, static_cast<int>(steps), steps == to_frame ? frame_end : now + steps * dt};
}

Batch adaptive_batch(double now, double target, double limit) {
  const double span = target - now;
  const double all = std::isinf(limit) ? 1 : steps_in(span, limit);
  const double dt = span / all;
  const double steps = std::min(all, static_cast<double>(steps_per_batch));
  return {dt, static_cast<int>(steps), steps == all ? target : now + steps * dt};
}

double automatic_dt(double stable, double frame) {
  return std::isinf(stable) ? frame : frame / steps_in(frame, stable);
}

}  // namespace runner
