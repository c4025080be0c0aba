// SPDX-License-Identifier: Apache-2.0
// Ctrl-C, SIGTERM and SIGHUP: noted, and acted upon when the current step is done.
#pragma once

#include "meltsim/world.hpp"

namespace runner {

/// From now on the first of these signals is only noted; a second one, of whatever kind, ends the program at once.
void watch_interrupts();
/// The signal that came, or 0.
int interrupt_signal();

/// While it lives, a step of this World that goes on for a second after the first signal is interrupted. The World must
/// not be moved.
class InterruptSteps {
 public:
  explicit InterruptSteps(meltsim::World& world);
  InterruptSteps(const InterruptSteps&) = delete;
  InterruptSteps& operator=(const InterruptSteps&) = delete;
  ~InterruptSteps();
};

}  // namespace runner
