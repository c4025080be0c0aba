// SPDX-License-Identifier: Apache-2.0
#include "processors.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

namespace runner {

namespace {

// Looks at a barrier before a thread sleeps, some 30 microseconds: longer than the threads of one loop are apart, short
// beside a time slice of another program. libgomp takes the same number where there are more threads than processors.
constexpr const char* spins = "1000";

}  // namespace

int processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void wait_politely(char** argv) {
  for (const char* chosen : {"OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "KMP_BLOCKTIME"}) {
    if (std::getenv(chosen) != nullptr) return;
  }
  if (setenv("GOMP_SPINCOUNT", spins, 1) != 0) return;
  setenv("KMP_BLOCKTIME", "0", 1);  // the same of LLVM's OpenMP, in ms
  execv("/proc/self/exe", argv);
}

}  // namespace runner
