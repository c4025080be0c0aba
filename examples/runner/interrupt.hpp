// SPDX-License-Identifier: Apache-2.0
// Ctrl-C, SIGTERM and SIGHUP: noted, and acted upon when the current step is done.
#pragma once

namespace runner {

/// From now on the first of these signals is only noted; a second one, of whatever kind, ends the program at once.
void watch_interrupts();
/// The signal that came, or 0.
int interrupt_signal();

}  // namespace runner
