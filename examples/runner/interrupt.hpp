// SPDX-License-Identifier: Apache-2.0
// Ctrl-C and SIGTERM: noted, and acted upon when the current steps are done.
#pragma once

namespace runner {

/// From now on a first signal is only noted; a second one ends the program at once.
void watch_interrupts();
/// The signal that came, or 0.
int interrupt_signal();

}  // namespace runner
