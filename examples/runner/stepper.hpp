// SPDX-License-Identifier: Apache-2.0
// Which steps lead from now to the next frame.
#pragma once

#include <optional>

namespace runner {

/// Steps to enqueue before waiting for them.
struct Batch {
  double dt = 0;  ///< [s] of each
  int steps = 0;
  double end = 0;  ///< [s] time after them
};

/// Waiting points must not depend on how fast the machine is: the library derives sub-steps from the speeds
/// seen at the last one, and a run must repeat bit for bit.
inline constexpr int steps_per_batch = 8;

/// Whether `now` has come to `due`, but for a few roundings of the two: no fixed time may be taken for nothing, since a
/// whole run may be shorter.
bool reached(double now, double due);

/// How many samples, `every` seconds apart from 0 on, are due by `now`. By division: a sum would take as long as there
/// are samples, and more than a step can ask for count as infinitely many.
double samples_by(double now, double every);
/// When the next one is due; `now` when that is sooner than the next step.
double next_sample(double now, double every);

/// Fixed stepping: a frame is cut into equal steps of at most `dt`.
double fixed_frame_dt(double frame_start, double frame_end, double dt);

/// Up to steps_per_batch steps of `dt` from `now` to at most `target`; the last step may pass `target` but
/// not `frame_end`, on which it lands exactly.
Batch fixed_batch(double now, double target, double frame_end, double dt);

/// Equal steps of at most `limit` from `now` that land exactly on `frame_end`: up to steps_per_batch of them, to at most
/// the first that reaches `target`.
Batch adaptive_batch(double now, double target, double frame_end, double limit);

/// The largest step of at most `stable` that divides a frame evenly.
double automatic_dt(double stable, double frame);

}  // namespace runner
