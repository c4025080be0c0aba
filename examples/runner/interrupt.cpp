// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <time.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>

namespace runner {

namespace {

constexpr std::int64_t echo_ms = 500;  ///< within which the same signal again is no second one

std::atomic<int> noted{0};
std::atomic<std::int64_t> noted_at{0};  ///< [ms]
std::atomic<meltsim::World*> stepping{nullptr};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free &&
                  std::atomic<meltsim::World*>::is_always_lock_free,
              "signal handlers may touch nothing that locks");

std::int64_t milliseconds() {
  struct timespec now {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * std::int64_t{1000} + now.tv_nsec / 1000000;
}

extern "C" void note_signal(int signal) {
  const std::int64_t now = milliseconds();
  const int before = noted.exchange(signal);
  // `timeout` and batch systems send a signal to the program and to its group: at once again, it is the same one.
  if (before == signal && now - noted_at < echo_ms) return;
  // Files are written under another name first, so nothing is left half written.
  if (before != 0) _exit(128 + signal);
  noted_at = now;
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
