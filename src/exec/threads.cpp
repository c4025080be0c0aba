// SPDX-License-Identifier: Apache-2.0
#include "exec/threads.hpp"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

namespace meltsim {
inline namespace v0 {
namespace core {
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();
constexpr int granted_anyway = 16;

/// The least value of read(directory) over the process's control group and the groups above it. Version 2 of the
/// interface; a container that shows only its own group shows that one at the root.
template <class Read>
auto least_of_groups(const Read& read) {
  auto least = read("/sys/fs/cgroup");
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (line.compare(0, 3, "0::") != 0) continue;
    for (std::string path = line.substr(3); path.size() > 1; path.resize(path.rfind('/')))
      least = std::min(least, read("/sys/fs/cgroup" + path));
  }
  return least;
}

double share_of_time(const std::string& group) {
  std::ifstream file(group + "/cpu.max");
  double quota = 0, period = 0;  // "max 100000" where there is no limit
  return file >> quota >> period && quota > 0 && period > 0 ? quota / period
                                                            : std::numeric_limits<double>::infinity();
}

std::uint64_t memory_left(const std::string& group) {
  std::uint64_t most = 0, used = 0, reclaimable = 0;
  if (!(std::ifstream(group + "/memory.max") >> most) || !(std::ifstream(group + "/memory.current") >> used))
    return unlimited;
  std::ifstream stat(group + "/memory.stat");
  std::string name;
  for (std::uint64_t bytes = 0; stat >> name >> bytes;)
    if (name == "file") reclaimable = bytes;
  used -= std::min(used, reclaimable);
  return most - std::min(most, used);
}

/// Processors in the affinity mask.
int allowed() {
  for (int most = 1024; most <= 1 << 20; most *= 2) {  // the system refuses a mask that is too short
    cpu_set_t* const mask = CPU_ALLOC(static_cast<std::size_t>(most));
    if (mask == nullptr) break;
    const std::size_t bytes = CPU_ALLOC_SIZE(static_cast<std::size_t>(most));
    const int count = sched_getaffinity(0, bytes, mask) == 0 ? CPU_COUNT_S(bytes, mask) : 0;
    CPU_FREE(mask);
    if (count > 0) return count;
  }
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Number of threads in the environment variable OMP_NUM_THREADS; no bound if it is absent or not a positive number. The name is
/// OpenMP's, because that is what people set for a program that computes.
int environment_threads() {
  const char* const text = std::getenv("OMP_NUM_THREADS");
  const long asked = text != nullptr ? std::strtol(text, nullptr, 10) : 0;
  return asked > 0 ? static_cast<int>(std::min<long>(asked, std::numeric_limits<int>::max()))
                   : std::numeric_limits<int>::max();
}

}  // namespace

int processors() {
  static const int known = [] {
    try {
      const double share = least_of_groups(share_of_time);
      const int here = allowed();
      return share < here ? std::max(1, static_cast<int>(std::ceil(share))) : here;
    } catch (const std::exception&) {
      return 1;
    }
  }();
  return known;
}

int threads_for(int asked) {
  if (asked <= 0) return std::min(processors(), environment_threads());
  return std::min(asked, std::max(processors(), granted_anyway));
}

std::uint64_t available_memory() {
  std::uint64_t left = unlimited;
  try {
    std::ifstream memory("/proc/meminfo");
    std::string name, unit;
    std::uint64_t available = 0, swap = 0;
    for (std::uint64_t kilobytes = 0; memory >> name >> kilobytes && std::getline(memory, unit);) {
      if (name == "MemAvailable:") available = kilobytes * 1024;
      if (name == "SwapFree:") swap = kilobytes * 1024;
    }
    if (available != 0) left = available + swap;
    return std::min(left, least_of_groups(memory_left));
  } catch (const std::exception&) {
    return left;
  }
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
