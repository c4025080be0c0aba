// SPDX-License-Identifier: Apache-2.0
// checkpoint.bin: the World's snapshot and what the runner needs to go on where it stopped.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene.hpp"
#include "stepper.hpp"

namespace runner {

struct RunState {
  double time = 0;               ///< [s]
  std::uint64_t steps = 0;       ///< time steps; the library may split each into sub-steps
  std::uint64_t next_frame = 0;  ///< the first one not written yet
  double frame_dt = 0;           ///< [s] step of the frame being computed; 0 = not chosen yet
  /// [s] What the speeds of the steps so far allow the next batches of adaptive stepping; empty = ask the World.
  std::vector<double> limits;
  Batch rest;                  ///< of the steps that an interrupt cut short
  Batch part;                  ///< sub-steps left of a step that an interrupt cut short; the first of `rest`
  double rest_speed = 0;       ///< [m/s] seen in those before it
  std::uint64_t meltable = 0;  ///< solid particles at the start that can melt
  std::optional<double> melted_at;      ///< [s] when nothing meltable was left
  std::optional<double> still_share;    ///< molten share that still.png shows, of a run of few frames
  double wall_s = 0;                    ///< of all sessions
  std::vector<std::uint64_t> substeps;  ///< of a run under a budget: of each frame after the first
  double owed = 0;                      ///< [s] of those frames that was not simulated
};

struct Checkpoint {
  RunState state;
  Json scene;  ///< as resolved when it was written
  std::vector<std::uint8_t> snapshot;
};

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint);
/// Fails on files that are cut short or changed.
Checkpoint read_checkpoint(const std::string& path);

}  // namespace runner
