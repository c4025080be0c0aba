// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace runner {

namespace {

std::atomic<int> noted{0};
std::atomic<meltsim::World*> stepping{nullptr};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<meltsim::World*>::is_always_lock_free,
              "signal handlers may touch nothing that locks");

extern "C" void note_signal(int signal) {
  // Files are written under another name first, so nothing is left half written.
  if (noted.exchange(signal) != 0) _exit(128 + signal);
  alarm(1);  // most steps are over before, and then nothing is cut short
}

extern "C" void interrupt_step(int /*signal*/) {
  if (meltsim::World* const world = stepping) world->interrupt();
}

}  // namespace

void watch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction late = action;
  late.sa_handler = interrupt_step;
  sigaction(SIGALRM, &late, nullptr);
  // Ignored from the start: nohup, or a script that put this into the background, keeps it so.
  for (const int signal : {SIGINT, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
  // A closed pipe (`meltsim run ... | head`) must not kill a long run.
  std::signal(SIGPIPE, SIG_IGN);
  // Nor must a limit on the size of files: writing fails, and that is said.
  std::signal(SIGXFSZ, SIG_IGN);
}

int interrupt_signal() { return noted; }

InterruptSteps::InterruptSteps(meltsim::World& world) { stepping = &world; }
InterruptSteps::~InterruptSteps() { stepping = nullptr; }

}  // namespace runner
