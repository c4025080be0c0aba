// SPDX-License-Identifier: Apache-2.0
#include "exec/threads.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <fstream>
#include <limits>
#include <mutex>
#include <new>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace meltsim {
inline namespace v0 {
namespace core {
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();
constexpr int granted_anyway = 16;

/// What read(directory) says of the process's own control group and those above it; the least of it. Version 2 of the
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

/// Threads that wait until all have been made, and end. How many there were.
int try_threads(int wanted) {
  std::mutex mutex;
  std::condition_variable all_made;
  bool done = false;
  std::vector<std::thread> threads;
  try {
    threads.reserve(static_cast<std::size_t>(wanted));
    while (static_cast<int>(threads.size()) < wanted)
      threads.emplace_back([&] {
        std::unique_lock<std::mutex> lock(mutex);
        all_made.wait(lock, [&] { return done; });
      });
  } catch (const std::system_error&) {  // that was the last one
  } catch (const std::bad_alloc&) {
  }
  {
    const std::lock_guard<std::mutex> lock(mutex);
    done = true;
  }
  all_made.notify_all();
  for (std::thread& t : threads) t.join();
  return static_cast<int>(threads.size());
}

}  // namespace

int processors() {
  static const int known = [] {
    try {
      const double share = least_of_groups(share_of_time);
      const int here = std::max(1, omp_get_num_procs());  // of the affinity mask
      return share < here ? std::max(1, static_cast<int>(std::ceil(share))) : here;
    } catch (const std::exception&) {
      return 1;
    }
  }();
  return known;
}

int threads_for(int asked) {
  if (asked <= 0) return std::min(processors(), std::max(1, omp_get_max_threads()));
  return std::min(asked, std::max(processors(), granted_anyway));
}

int team_for(int wanted) {
  // OpenMP keeps a thread's team for its next region, and lets go of those that a smaller one has no use for.
  thread_local int last = 1;
  if (wanted > last) {
    const int more = try_threads(wanted - last);
    // One is left over for whatever else the process does meanwhile.
    if (last + more < wanted) wanted = std::max(1, last + more - 1);
  }
  return last = wanted;
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
