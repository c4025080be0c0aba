// SPDX-License-Identifier: Apache-2.0
// Which steps lead from now to the next frame.
#pragma once

#include <optional>

namespace runner {

/// Steps to enqueue before looking at what they came to.
struct Batch {
  double dt = 0;  ///< [s] of each
  int steps = 0;
  double end = 0;  ///< [s] time after them
};

/// Batches must not depend on how fast the machine is: adaptive steps follow the speeds of earlier batches, and a run must
/// repeat bit for bit.
inline constexpr int adaptive_steps_per_batch = 8;
/// Enough for a GPU to go on while a frame is read, few enough to be over soon after an interrupt.
inline constexpr int fixed_steps_per_batch = 32;

/// Whether `now` has come to `due`, but for a few roundings of the two: no fixed time may be taken for nothing, since a
/// whole run may be shorter.
bool reached(double now, double due);

/// Fixed stepping: a frame is cut into equal steps of at most `dt`.
double fixed_frame_dt(double frame_start, double frame_end, double dt);

/// Steps of `dt` from `now` on, of which the last one lands exactly on `frame_end`.
Batch fixed_batch(double now, double frame_end, double dt);

/// Equal steps of at most `limit` from `now` on, of which the last one lands exactly on `frame_end`.
Batch adaptive_batch(double now, double frame_end, double limit);

/// The largest step of at most `stable` that divides a frame evenly.
double automatic_dt(double stable, double frame);

}  // namespace runner
