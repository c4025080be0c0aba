// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <csignal>

namespace runner {

namespace {

volatile std::sig_atomic_t noted = 0;

extern "C" void note_signal(int signal) { noted = signal; }

}  // namespace

void watch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A closed pipe (`meltsim run ... | head`) must not kill a long run.
  std::signal(SIGPIPE, SIG_IGN);
  // Nor must a limit on the size of files: writing fails, and that is said.
  std::signal(SIGXFSZ, SIG_IGN);
}

int interrupt_signal() { return noted; }

}  // namespace runner
